#!/usr/bin/env bash
# Measures the figures of docs/results.md again, on this machine's card: trains the scenes in DATA, one
# training at a time, writes results/ID.json, and redraws the tables and the chart. Figures in the text
# of the pages are corrected by hand: exit code 1 and a line for each that does not hold any more.
# Usage: measure.sh [--tessera PROGRAM] [--out DIR] [--only ID,ID] DATA
# DATA holds captures or prepared scenes with the names of the scenes in results/; those that are
# rendered are made there. A results file of which another scene is absent stays as it is. The
# batches are in DIR, default build/measured/COMMIT; the same command continues where it was stopped.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
tessera=$root/build/release/tessera out='' only='' data=''
usage() {
  sed -n '2,/^set /s/^# //p' "$0" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  case $1 in
    --tessera) tessera=${2:?} && shift 2 ;;
    --out) out=${2:?} && shift 2 ;;
    --only) only=${2:?} && shift 2 ;;
    -*) usage ;;
    *)
      [ -z "$data" ] || usage
      data=$1 && shift
      ;;
  esac
done
[ -d "$data" ] || usage
commit=$("$tessera" env --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["commit"])')
out=${out:-$root/build/measured/$commit}
mkdir -p "$out"

rendered() { # SCENE: makes one that is rendered, as its results file says; 1: it is none of these
  case $1 in
    figure) set -- figure --layout dnerf --frames 150 --held-out-frames 20 --width 800 --height 800 ;;
    fast)
      set -- fast --layout n3dv --cameras 12 --frames 48 --width 480 --height 360 \
        --light-step 0.85 --camera-gains
      ;;
    *) return 1 ;;
  esac
  "$tessera" synth "$@" -o "$data/$1"
}

wanted() { # ID SCENE...: whether it is asked for, and all its scenes are there
  case ,${only:-$1}, in *,"$1",*) ;; *) return 1 ;; esac
  local scene
  for scene in "${@:2}"; do
    [ -e "$data/$scene" ] || rendered "$scene" ||
      { echo "skipped: $1, as there is no $data/$scene" && return 1; }
  done
}

train() { # BATCH "SCENE..." PRESETS OPTION...
  local scenes
  read -ra scenes <<< "$2"
  "$tessera" batch "${scenes[@]/#/$data/}" -o "$out/$1" --preset "$3" --seeds 1,2,3 --jobs 1 \
    --exports tessera "${@:4}"
}

take() { # ID REPORT...
  python3 "$root/scripts/take_results.py" "${@:2}" --id "$1" --val dnerf_lego --commit "$commit" \
    -o "$root/results"
}

report_of() { # BATCH
  echo "$out/$1/report/report.json"
}

add_objects() { # BATCH BOXES: scores of what moves, which a batch does not have, into metrics.json
  local run
  for run in "$out/$1"/runs/*/*/seed-*; do
    "$tessera" evaluate "$run" --boxes "$2" --json > "$run/objects.json"
    python3 - "$run" << 'MERGE'
import json, pathlib, sys
run = pathlib.Path(sys.argv[1])
metrics = json.loads((run / "metrics.json").read_text())
metrics["objects"] = json.loads((run / "objects.json").read_text())["objects"]
(run / "metrics.json").write_text(json.dumps(metrics, indent=1))
MERGE
  done
}

quality() { # ID SCENE OPTION...: the three presets
  wanted "$1" "$2" || return 0
  train "$1" "$2" fast,balanced,best "${@:3}"
  if [ "$2" = fast ]; then add_objects "$1" "$data/fast/ground_truth.json"; fi
  take "$1" "$(report_of "$1")"
}

quality quality_lego dnerf_lego
quality quality_figure figure
quality quality_studio studio
quality quality_basketball basketball --cloud none # the training makes it on the card
quality quality_fast fast --sync none
quality quality_mic mic --background black
quality quality_bonsai bonsai
if wanted protocols mic dnerf_lego figure; then
  train protocols_3dgs mic 3dgs --background black
  train protocols_faster_gs "dnerf_lego figure" faster-gs
  take protocols "$(report_of protocols_3dgs)" "$(report_of protocols_faster_gs)"
fi
python3 "$root/scripts/make_tables.py"
python3 "$root/scripts/make_chart.py"
python3 "$root/scripts/make_tables.py" --check
