#!/usr/bin/env bash
# Makes the animation of a test camera: recorded images on the left, the reconstruction on the right,
# with labels.
# Usage: make_picture.sh RUN SCENE OUT.webp [FRAMES_PER_SECOND]
#   RUN: run folder or model; SCENE: its prepared scene, of which the first test camera is shown.
set -euo pipefail
tessera=${TESSERA:-build/release/tessera}
if [ $# -lt 3 ]; then
  sed -n '2,5s/^# //p' "$0" >&2
  exit 2
fi
run=$1 scene=$2 out=$3 fps=${4:-12}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$tessera" render "$run" --cameras "$scene" --split test -o "$work/result" >&2
mapfile -t rendered < <(find "$work/result" -name '*.png' | sort)
camera=$(basename "$(dirname "${rendered[0]}")")
number=0
for image in "${rendered[@]}"; do
  [ "$(basename "$(dirname "$image")")" = "$camera" ] || continue
  name=$(printf '%05d.png' "$number")
  ln -s "$scene/$camera/$(basename "$image")" "$work/truth_$name"
  ln -s "$image" "$work/result_$name"
  number=$((number + 1))
done
label() {
  printf "drawtext=text='%s':x=10:y=h-th-10:fontsize=16:fontcolor=white:box=1:boxcolor=black@0.5:boxborderw=4" "$1"
}
ffmpeg -v error -y -framerate "$fps" -i "$work/truth_%05d.png" -framerate "$fps" \
  -i "$work/result_%05d.png" -filter_complex \
  "[0]$(label 'recorded')[a];[1]$(label 'reconstructed, new view')[b];[a][b]hstack" \
  -c:v libwebp_anim -quality 75 -loop 0 "$out"
echo "$out: $number frames of $camera, $(stat -c %s "$out") bytes"
