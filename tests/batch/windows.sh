#!/bin/bash
# A long clip of a batch is trained window by window, with scores and files of the whole; a short one
# beside it as a whole; another cut is another request.
# Finds: windows without scores or files of the whole clip; a batch that is never done; windows of an earlier cut that stay.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
"$TESSERA" synth room -o "$work/captures/long" --layout n3dv --cameras 4 --frames 48 --width 48 \
  --height 36 --supersampling 1 --points 300 >/dev/null 2>&1 || skip "no video encoder"
make_capture short 2
out=$work/out
settings() { # WINDOWS
  write_batch "$out" "captures: [../captures/*/]" "exports: [tessera]" "seeds: [1]" "threads: 1" \
    "windows: $1" \
    "presets: [{name: quick, preset: fast, options: {iterations: 12, batch: 1, init-points: 300, sweep: false}}]"
}
value() { # FILE KEY: null where there is none
  python3 -c 'import json, sys; print(json.load(open(sys.argv[1])).get(sys.argv[2]))' "$out/$1" "$2"
}
run=runs/long/quick/seed-1

settings 1s
check "ends well" same 0 "$(exit_code run_batch "$out")"
check "the long clip has two windows over one static set" same 3 \
  "$(find "$out/$run" -name model.ply | wc -l)"
check "and scores" same 2 "$(value $run/metrics.json windows)"
check "and a file of both" same 2 "$(value exports/long/quick/seed-1/tessera.json windows)"
check "there is no model of the whole clip" test ! -e "$out/$run/model.ply"
check "the short clip is trained as a whole" test -e "$out/runs/short/quick/seed-1/model.ply"
check "the report has both" same "2 of 2" \
  "$("$TESSERA" report "$out" 2>&1 | grep -o '2 of 2' | head -1)"
before=$(models "$out")
check "nothing is left to do" same "" "$(planned "$out")"

settings 0.7s
check "another cut is trained" same 0 "$(exit_code run_batch "$out")"
check "with other windows" same 3 "$(value $run/metrics.json windows)"
settings none
check "and the whole clip" same 0 "$(exit_code run_batch "$out")"
check "without windows" test ! -e "$out/$run/windows"
settings 1s
check "and windows again" same 0 "$(exit_code run_batch "$out")"
check "which are those of before" same "$before" "$(models "$out")"
settings soon
check "bad input" same 2 "$(exit_code run_batch "$out")"
check "in one line" grep -q "^tessera: windows: .*soon.*5s" "$out.log"
