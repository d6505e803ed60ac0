#!/bin/bash
# Shared functions of the batch tests: captures, runs, checks.
# TESSERA: the program. ENGINE=one_by_one: as where Snakemake is not installed. KEEP=1: leave the
# folder of the test.
set -euo pipefail
test_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
batch_folder=$(dirname "$test_folder")
: "${TESSERA:?the program, e.g. TESSERA=build/release/tessera}"
TESSERA=$(realpath "$TESSERA")
skip() { echo "skip  $*" && exit 77; }
one_by_one() { [[ ${ENGINE:-} == one_by_one ]]; }
if one_by_one; then
  python3 -c 'import yaml' 2>/dev/null || skip "no python3-yaml"
else
  command -v snakemake >/dev/null || skip "no snakemake: apt-get install --no-install-recommends snakemake"
fi
data=${TESSERA_DATA:-} # of third parties: shared/data beside a folder above, where there is one
folder=$test_folder
until [[ -n $data || $folder == / ]]; do
  folder=$(dirname "$folder")
  if [[ -d $folder/shared/data ]]; then data=$folder/shared/data; fi
done
work=$(mktemp -d "${TMPDIR:-/tmp}/tessera-batch.XXXXXX")

finish() { # runs at every end; on_exit is the test's own
  local code=$?
  on_exit
  if ((code == 0 || code == 77)) && [[ -z ${KEEP:-} ]]; then rm -rf "$work"; else echo "left: $work"; fi
}
on_exit() { :; }
trap finish EXIT

hide_snakemake() { # from `tessera batch`: PATH is one folder of links to all other programs
  local folders folder
  IFS=: read -ra folders <<<"$PATH"
  mkdir "$work/bin"
  for folder in "${folders[@]}"; do
    find "$folder" -maxdepth 1 ! -type d ! -name 'snakemake*' -exec ln -st "$work/bin" {} + 2>/dev/null || true
  done
  PATH=$work/bin
}
if one_by_one; then hide_snakemake; fi

check() { # TEXT COMMAND...: says what holds, ends the test where it does not
  if "${@:2}"; then echo "ok    $1"; else echo "WRONG $1" && exit 1; fi
}

same() { # EXPECTED SEEN
  [[ $1 == "$2" ]] || { diff <(echo "$1") <(echo "$2") | head -20 >&2 && return 1; }
}

wait_for() { # SECONDS COMMAND...
  local end=$((SECONDS + $1))
  until "${@:2}"; do
    ((SECONDS < end)) || { echo "not within $1 s: ${*:2}" >&2 && return 1; }
    sleep 0.2
  done
}

make_capture() { # NAME SEED [FRAMES]: 48 x 36 pixels
  "$TESSERA" synth room -o "$work/captures/$1" --layout dnerf --frames "${3:-12}" \
    --held-out-frames 2 --width 48 --height 36 --points 500 --seed "$2" >/dev/null 2>&1
}

write_batch() { # OUT LINES...: batch.yaml
  mkdir -p "$1"
  { echo "tessera: $TESSERA" && printf '%s\n' "${@:2}"; } >"$1/batch.yaml"
}

engine_of() { # OUT: engine becomes the words that start it, Snakemake with PROFILE (local)
  if one_by_one; then
    engine=(python3 "$batch_folder/one_by_one.py" --directory "$1")
  else
    engine=(snakemake -s "$batch_folder/Snakefile" --profile "$batch_folder/profiles/${PROFILE:-local}"
      --directory "$1")
    [[ -n ${PROFILE:-} ]] || engine+=(--cores 2)
  fi
}

flow() { # OUT ARGUMENTS...
  local engine
  engine_of "$1"
  "${engine[@]}" "${@:2}"
}

run_batch() { flow "$1" "${@:2}" >>"$1.log" 2>&1; }

exit_code() { # COMMAND...: prints it
  local code=0
  "$@" || code=$?
  echo "$code"
}

planned() { # OUT: the jobs that a run would do, sorted: "train a quick 1"
  if one_by_one; then
    flow "$1" --dry-run 2>&1 | sed '/^nothing is to do$/d' | sort
  else
    flow "$1" --dry-run -p 2>&1 | sed -n 's/^ *exec .*job\.py \(.*\) --threads.*/\1/p' | sort
  fi
}

lines() { printf '%s\n' "$@" | sort; }

models() { # without those that were replaced, which are kept as seed-N.1 and so on
  (cd "$1" && find runs -name 'seed-*.*' -prune -o -name model.ply -print0 | sort -z | xargs -0 sha256sum)
}

failures() { find "$1/failures" -name '*.json' -printf '%f\n' | sort; }
