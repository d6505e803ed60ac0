#!/usr/bin/env bash
# Where presets fail: scenes that are each hard in one way, trained with the presets and with the 4D
# protocol of Faster-GS, three seeds each. `make` needs FFmpeg, `train` a card.
# Usage: measure_stability.sh make FOLDER         makes the captures in FOLDER
#        measure_stability.sh train FOLDER OUT    a batch of every capture in FOLDER; OUT/report has it
# Put other captures or prepared scenes beside those that are made. TESSERA names the program, JOBS how
# many jobs run side by side (seconds are not comparable then).
set -euo pipefail
here=$(dirname "$0")
tessera=${TESSERA:-$here/../build/release/tessera}
action=${1:-} folder=${2:-}
usage() {
  sed -n '2,/^set /s/^# //p' "$0" >&2
  exit 2
}
[ -n "$folder" ] || usage

# name, options of `tessera synth`
small='--cameras 9 --width 320 --height 240'
scenes="
plain        room $small
lights       room $small --light-step 0.6 --camera-gains
few_cameras  room --cameras 5 --width 320 --height 240
offsets      room $small --shift cam02=1.5,cam05=-0.75
noise        room $small --noise 15
shiny        room $small --specular 0.8
long_clip    patch --frames 1050 --cameras 6 --width 160 --height 120
"

make_captures() {
  mkdir -p "$folder"
  while read -r name of; do
    [ -n "$name" ] && [ ! -e "$folder/$name" ] || continue
    read -ra words <<< "$of"
    "$tessera" synth "${words[@]}" --layout n3dv -o "$folder/$name"
  done <<< "$scenes"
}

case $action in
  make) make_captures ;;
  train)
    "$tessera" batch "$folder"/*/ -o "${3:?measure_stability.sh train FOLDER OUT}" --seeds 1,2,3 \
      --preset fast,balanced,best,faster-gs --exports tessera --jobs "${JOBS:-1}"
    ;;
  *) usage ;;
esac
