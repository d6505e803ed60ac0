#!/bin/bash
# Six captures, two of them broken: four are done, the broken ones are in the report, which is the
# same whatever engine has run the jobs. Fixed, they alone are done again.
source "$(dirname "$0")/common.sh"

scenes=(room_1 room_2 room_3 room_4)
for i in 1 2 3 4; do make_capture "room_$i" "$i"; done
mkdir -p "$work"/{broken,torn} && echo "no capture" >"$work/broken/notes.txt" && echo "{" >"$work/torn/transforms.json"
write_batch "$work/out" "captures: [../captures/*/]" "scenes: [../broken, ../torn]" \
  "presets: [{name: quick, preset: fast, options: {iterations: 40, init_points: 500, peak_gaussians: 1000}}]" \
  "exports: [tessera, html]"

check "exit code 1, as scenes failed" same 1 "$(exit_code run_batch "$work/out")"
for scene in "${scenes[@]}"; do
  run=$work/out/runs/$scene/quick/seed-1
  check "$scene: model and scores" test -s "$run/model.ply" -a -s "$run/metrics.json"
  check "$scene: player" test -s "$work/out/exports/$scene/quick/seed-1/html/index.html"
done
check "two failures are recorded" same "$(lines ingest/broken ingest/torn)" "$(failures "$work/out")"
check "with the exit code" grep -q '"exit_code": 2' "$work/out/jobs/ingest/broken.json"
check "and the program's line" grep -q '"message": "tessera: .*name the folder' "$work/out/jobs/ingest/broken.json"
check "the report says so" same \
  "4 of 6 runs done, 2 failed, 0 not run; 4 of 6 scenes complete" \
  "$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["batch"]["summary"])' "$work/out/report/report.json")"
check "with both reasons" same 2 \
  "$(python3 -c 'import json, sys; print(len(json.load(open(sys.argv[1]))["batch"]["failures"]))' "$work/out/report/report.json")"
check "few lines are for people" test "$(wc -l <"$work/out.log")" -le 12

make_capture ../broken/capture 5 && mv "$work"/broken/capture/* "$work/broken/"
make_capture ../torn/capture 6 && rm "$work/torn/transforms.json" && mv "$work"/torn/capture/* "$work/torn/"
of_scene() { lines "ingest/$1" "train/$1/quick/seed-1" "evaluate/$1/quick/seed-1" \
  "export/$1/quick/seed-1/html" "export/$1/quick/seed-1/tessera"; }
check "fixed, these scenes alone are to do" same "$(lines "$(of_scene broken)" "$(of_scene torn)")" \
  "$(planned "$work/out")"
check "exit code 0" same 0 "$(exit_code run_batch "$work/out")"
check "no failure is recorded" same "" "$(failures "$work/out")"
check "nothing is to do" same "" "$(planned "$work/out")"
