#!/bin/bash
# Killed in the middle and started again: only unfinished work is redone, and the models are those
# of a batch that was not killed. Then what a change reruns, and what it does not.
source "$(dirname "$0")/common.sh"

small="init_points: 500, peak_gaussians: 1000"
batch() { # OUT OPTIONS LINES...
  write_batch "$1" "deterministic: true" "threads: ${threads:-1}" "exports: [tessera]" "presets:" \
    "  - {name: plain, preset: fast, options: {$small, iterations: 200, checkpoint_every: 10}}" \
    "  - {name: quick, preset: fast, options: {$small, $2}}" "${@:3}"
}
captures="captures: [../captures/*/]"
options="iterations: 300, checkpoint_every: 10"
for i in 1 2; do make_capture "room_$i" "$i"; done

batch "$work/whole" "$options" "$captures"
check "an uninterrupted batch" run_batch "$work/whole"

half_way() { # a training is done, another has a checkpoint and is not
  local run done=0 begun=0
  for run in "$work"/killed/runs/*/*/seed-1; do
    if [[ -f $run/train.json ]]; then done=1; elif [[ -f $run/checkpoint.ckpt ]]; then begun=1; fi
  done
  ((done && begun))
}
# finished outputs with their times
finished() {
  find "$work"/killed/{scenes,runs,exports} -maxdepth 4 -name '*.json' ! -name config.json \
    ! -name transforms.json -printf '%p %T@\n' 2>/dev/null | sort || true
}
batch "$work/killed" "$options" "$captures"
engine_of "$work/killed"
setsid "${engine[@]}" >"$work/killed.log" 2>&1 &
session=$! # of all that it starts, whatever group that is in
check "half way" wait_for 600 half_way
pkill -KILL -s "$session" || true
wait "$session" 2>/dev/null || true
dead() { ! ps -o stat= -s "$session" | grep -qv '^Z'; }
check "nothing of it is left running" wait_for 10 dead
before=$(finished)
check "killed jobs are recorded" test -n "$(failures "$work/killed")"
check "started again: done" run_batch "$work/killed"
check "what was finished was not touched" same "" "$(comm -23 <(echo "$before") <(finished))"
check "a training went on from its checkpoint" grep -qr '"initialisation":"checkpoint"' "$work/killed/runs"
check "models are bit-equal to those of the uninterrupted batch" \
  same "$(models "$work/whole")" "$(models "$work/killed")"
check "no failure is recorded" same "" "$(failures "$work/killed")"

out=$work/killed
of_run() { lines "train/$1" "evaluate/$1" "export/$1/tessera"; }
check "nothing is to do" same "" "$(planned "$out")"
threads=2 batch "$out" "$options" "$captures"
check "nothing with other threads" same "" "$(planned "$out")"
threads=1 batch "$out" "iterations: 300, checkpoint_every: 20" "$captures"
check "nothing with other checkpoints" same "" "$(planned "$out")"
batch "$out" "iterations: 310, checkpoint_every: 10" "$captures"
check "an option of one preset: its runs" same \
  "$(lines "$(of_run room_1/quick/seed-1)" "$(of_run room_2/quick/seed-1)")" "$(planned "$out")"
batch "$out" "$options" "$captures"
check "and back: nothing" same "" "$(planned "$out")"
make_capture room_3 3
check "a scene more: it alone" same "$(lines ingest/room_3 "$(of_run room_3/plain/seed-1)" \
  "$(of_run room_3/quick/seed-1)")" "$(planned "$out")"
rm -r "$work/captures/room_3"
check "and gone: nothing" same "" "$(planned "$out")"
touch "$work/captures/room_1/train/r_003.png"
check "an input file touched: nothing" same "" "$(planned "$out")"
expected=$(lines ingest/room_1 "$(of_run room_1/plain/seed-1)" "$(of_run room_1/quick/seed-1)")
cp "$work/captures/room_2/train/r_004.png" "$work/captures/room_1/train/r_003.png"
check "an input file of other content: its scene" same "$expected" "$(planned "$out")"
check "runs" run_batch "$out"
check "and its models change, the others do not" same \
  "$(models "$work/whole" | grep room_2 | sort)" \
  "$(comm -12 <(models "$work/whole" | sort) <(models "$out" | sort))"
check "nothing is to do" same "" "$(planned "$out")"
batch "$out" "$options" "scenes: [{path: ../captures/room_1, split: train}, ../captures/room_2]"
check "another split: its scores alone" same \
  "$(lines evaluate/room_1/plain/seed-1 evaluate/room_1/quick/seed-1)" "$(planned "$out")"
check "runs" run_batch "$out"
check "they are of the split" grep -q '"train"' "$out/runs/room_1/quick/seed-1/metrics.json"
check "nothing is to do" same "" "$(planned "$out")"
