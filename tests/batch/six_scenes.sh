#!/bin/bash
# Six scenes over night, one of them broken: five are done, the broken one is in the report.
# Two are third-party data: TESSERA_DATA/stress/occlusion and rapid_motion (D-NeRF layout).
source "$(dirname "$0")/common.sh"

for i in 1 2 3; do make_capture "room_$i" "$i"; done
mkdir -p "$work/broken" && echo "no capture" >"$work/broken/notes.txt"
scenes=(room_1 room_2 room_3)
stress=()
if [[ -d $data/stress/occlusion ]]; then
  for name in occlusion rapid_motion; do
    scenes+=("$name")
    stress+=("  - {path: $data/stress/$name, ingest: [--scale, 0.1, --frames, 12]}")
  done
else
  echo "skip  two scenes: no stress/occlusion in TESSERA_DATA"
fi
write_batch "$work/out" "captures: [../captures/*/]" "scenes:" "  - {path: ../broken}" "${stress[@]}" \
  "presets: [{name: quick, preset: fast, options: {iterations: 40, init_points: 500, peak_gaussians: 1000}}]" "exports: [tessera, html]"

check "exit code 1, as one scene failed" same 1 "$(exit_code run_batch "$work/out")"
for scene in "${scenes[@]}"; do
  run=$work/out/runs/$scene/quick/seed-1
  check "$scene: model and scores" test -s "$run/model.ply" -a -s "$run/metrics.json"
  check "$scene: player" test -s "$work/out/exports/$scene/quick/seed-1/html/index.html"
done
check "one failure is recorded" same ingest/broken "$(failures "$work/out")"
check "with the exit code" grep -q '"exit_code": 2' "$work/out/jobs/ingest/broken.json"
check "and the program's line" grep -q '"message": "tessera: .*name the folder' "$work/out/jobs/ingest/broken.json"
check "the report is written" test -n "$(ls -A "$work/out/report")"

make_capture ../broken/capture 4 && mv "$work"/broken/capture/* "$work/broken/"
place=broken/quick/seed-1
check "fixed, that scene alone is to do" same "$(lines ingest/broken train/$place \
  evaluate/$place export/$place/html export/$place/tessera)" "$(planned "$work/out")"
check "exit code 0" same 0 "$(exit_code run_batch "$work/out")"
check "no failure is recorded" same "" "$(failures "$work/out")"
check "nothing is to do" same "" "$(planned "$work/out")"
