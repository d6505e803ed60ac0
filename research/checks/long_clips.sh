#!/usr/bin/env bash
# Trains the long clips of long_captures.md on this machine's card, and prints their scores.
# Usage: long_clips.sh TESSERA OUT [SEED...]     (default: seeds 1 2 3)
# Eight cameras of 240x180, 1,200 frames: in windows of 5 s, and the first 300 frames alone, all seeds
# at once: start an MPS server before, and take no seconds from it. Then 20 cameras of 1352x1014, five
# seconds 120 times over: what the windows share, and window 60 of 120. Continues where it stopped.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
tessera=$1 out=$2
shift 2
seeds=("$@")
[ $# -gt 0 ] || seeds=(1 2 3)
mkdir -p "$out"
cd "$out"

rig() { # NAME CAMERAS WIDTH HEIGHT FRAMES QUALITY
  [ -e "$1/poses_bounds.npy" ] || "$tessera" synth room -o "$1" --layout n3dv --cameras "$2" \
    --width "$3" --height "$4" --frames "$5" --repeat 150 --fps 30 --supersampling 1 \
    --video-quality "$6"
}
prepared() { # CAPTURE SCENE OPTION...
  [ -e "$2/transforms.json" ] ||
    "$tessera" ingest "$1" -o "$2" --frames-as video --sync none "${@:3}"
}
score() { # RUN: one line
  "$tessera" evaluate "$1" --json > "$1.json"
  python3 - "$1.json" << 'SCORES'
import json, sys
scores = json.load(open(sys.argv[1]))
print(json.dumps({"run": sys.argv[1], **{key: scores.get(key) for key in (
    "psnr", "psnr_dynamic", "psnr_static", "num_static", "num_dynamic", "windows", "borders")}}))
SCORES
}

rig small_rig 8 240 180 1200 16
prepared small_rig small
prepared small_rig small_300 --frames 300
for seed in "${seeds[@]}"; do
  {
    "$tessera" train small -o "windows_$seed" --windows 5s --seed "$seed" -q
    score "windows_$seed"
  } &
  {
    "$tessera" train small_300 -o "alone_$seed" --seed "$seed" -q
    score "alone_$seed"
  } &
done
wait

rig five_seconds 20 1352 1014 150 21
mkdir -p ten_rig
for file in five_seconds/*.mp4; do
  python3 "$here/repeat_mp4.py" "$file" "ten_rig/$(basename "$file")" 120
done
cp five_seconds/poses_bounds.npy ten_rig/
prepared ten_rig ten
timed() {
  local begin=$SECONDS
  "$@"
  echo "$((SECONDS - begin)) s: ${*:2}"
}
timed "$tessera" unpack ten --static -o ten_static_scene --overwrite
timed "$tessera" train ten_static_scene -o ten_static --overwrite -q
timed "$tessera" train ten -o ten_window --window 60/120 --static-model ten_static \
  --evaluate-every never --overwrite -q
score ten_window
