#!/bin/bash
# How long it takes to plan 1,000 scenes x 3 presets, and what that time goes into.
source "$(dirname "$0")/common.sh"
scenes=${1:-1000}

for ((i = 0; i < scenes; ++i)); do
  mkdir -p "$work/captures/scene_$i"
  echo '{"frames": []}' >"$work/captures/scene_$i/transforms.json"
done
write_batch "$work/out" "captures: [../captures/*/]" "presets: [fast, balanced, best]"
jobs=$((scenes * (2 + 3 * 4) + 1))
TIMEFORMAT="%R %U %S"
spent=$({ time flow "$work/out" -n -q >"$work/plan.txt" 2>&1; } 2>&1)
check "$jobs jobs are planned" grep -q "^total *$jobs " "$work/plan.txt"
read -r wall user system <<<"$spent"
each=$(python3 -c "print(round(1000 * ($user + $system) / $jobs, 2))")
echo "      in $wall s, $user + $system s of a core: $each ms a job"
check "below 5 ms a job" python3 -c "import sys; sys.exit($each > 5)"
"$(sed -n "1s/^#! *//p" "$(command -v snakemake)")" -m cProfile -o "$work/profile" "$(command -v snakemake)" -s "$batch_folder/Snakefile" \
  --profile "$batch_folder/profiles/local" --directory "$work/out" --cores 2 -n -q >/dev/null 2>&1
python3 - "$work/profile" <<'PYTHON'
import pstats, sys
stats = pstats.Stats(sys.argv[1])
rows = sorted(((cumulative, name, file) for (file, _, name), (_, _, _, cumulative, _) in
               stats.stats.items()), reverse=True)
named = ("update", "update_needrun", "update_conda_envs", "stamp", "load", "check_with_program",
         "expand_resources", "expand_params", "replace_job", "print_job_scheduler")
total = rows[0][0]
for cumulative, name, file in rows:
    if name in named and ("snakemake" in file or "batch" in file):
        print(f"      {100 * cumulative / total:5.1f} %  {name} ({file.rsplit('/', 1)[-1]})")
PYTHON
