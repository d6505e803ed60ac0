#!/bin/bash
# Ctrl-C of `tessera batch`: trainings leave their checkpoints, nothing is left running, the same command ends
# it. And a batch that runs is what it was when it began, whatever becomes of batch.yaml.
source "$(dirname "$0")/common.sh"

make_capture room 1
options=(--preset fast --deterministic true --init-points 500 --peak-gaussians 1000 --iterations 2000
  --checkpoint-every 20 --exports tessera --threads 1)
batch() { "$TESSERA" batch "$work/captures" -o "$1" "${options[@]}" >>"$1.log" 2>&1; }
begun() { [[ -s $1/runs/room/fast/seed-1/checkpoint.ckpt ]]; }
alive() { pgrep -f "$work" | grep -vx $$ || true; }
check "a batch" batch "$work/whole"

for signal in INT TERM HUP; do
  out=$work/$signal
  "$TESSERA" batch "$work/captures" -o "$out" "${options[@]}" >"$out.log" 2>&1 &
  driver=$!
  check "SIG$signal: at work" wait_for 60 begun "$out"
  kill -"$signal" "$driver"
  code=0 && wait "$driver" || code=$?
  expected=75 && [[ $signal != INT ]] || expected=130
  check "its exit code" same "$expected" "$code"
  check "nothing is left running" wait_for 5 test -z "$(alive)"
  check "no report was waited for" test ! -e "$out/report"
  check "the same command ends it" batch "$out"
  check "from its checkpoint" grep -q '"initialisation":"checkpoint"' "$out/runs/room/fast/seed-1/log.jsonl"
  check "with the model of an undisturbed batch" same "$(models "$work/whole")" "$(models "$out")"
done

out=$work/changed
batch "$out" &
driver=$!
check "another: at work" wait_for 60 begun "$out"
sed -i 's/"iterations": "2000"/"iterations": "30"/; s/"name": "room"/"name": "hall"/' "$out/batch.yaml" "$out/jobs.json"
check "its end" wait "$driver"
check "trained as it began" same "$(models "$work/whole")" "$(models "$out")"
