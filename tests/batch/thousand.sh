#!/bin/bash
# How long it takes to plan 1,000 scenes x 3 presets.
source "$(dirname "$0")/common.sh"
scenes=${1:-1000}

for ((i = 0; i < scenes; ++i)); do
  mkdir -p "$work/captures/scene_$i"
  echo '{"frames": []}' >"$work/captures/scene_$i/transforms.json"
done
write_batch "$work/out" "captures: [../captures/*/]" "presets: [fast, balanced, best]"
jobs=$((scenes * (1 + 3 * 4)))
TIMEFORMAT="%R"
spent=$({ time planned "$work/out" >"$work/plan.txt"; } 2>&1)
check "$jobs jobs are planned" same "$jobs" "$(wc -l <"$work/plan.txt")"
check "in $spent s: below 5 ms a job" python3 -c "import sys; sys.exit($spent > 0.005 * $jobs)"
