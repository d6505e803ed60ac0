#!/bin/bash
# Shared functions of the batch tests: captures, runs, checks.
# TESSERA: the program. ENGINE=snakemake: by Snakemake on this machine, not by the program itself.
# KEEP=1: leave the folder of the test.
set -euo pipefail
test_folder=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
: "${TESSERA:?the program, e.g. TESSERA=build/release/tessera}"
TESSERA=$(realpath "$TESSERA")
skip() { echo "skip  $*" && exit 77; }
need_snakemake() {
  command -v snakemake >/dev/null || skip "no snakemake: apt-get install --no-install-recommends snakemake"
}
[[ ${ENGINE:-} != snakemake ]] || need_snakemake
work=$(mktemp -d "${TMPDIR:-/tmp}/tessera-batch.XXXXXX")

finish() { # runs at every end; on_exit is the test's own
  local code=$?
  on_exit
  if ((code == 0 || code == 77)) && [[ -z ${KEEP:-} ]]; then rm -rf "$work"; else echo "left: $work"; fi
}
on_exit() { :; }
trap finish EXIT

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
  printf '%s\n' "${@:2}" >"$1/batch.yaml"
}

engine_of() { # OUT: engine becomes the words that start it, by Snakemake with PROFILE
  engine=("$TESSERA" batch -o "$1")
  if [[ ${ENGINE:-} == snakemake && -z ${PROFILE:-} ]]; then
    mkdir -p "$work/profile"
    printf 'cores: 2\nretries: 2\n' >"$work/profile/config.yaml"
    engine+=(--profile "$work/profile")
  elif [[ -n ${PROFILE:-} ]]; then
    engine+=(--profile "$PROFILE")
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

planned() { # OUT: the jobs that a run would do, sorted: train/a/quick/seed-1
  "$TESSERA" batch -o "$1" --dry-run 2>&1 | sed '/^nothing is to do$/d' | sort
}

lines() { printf '%s\n' "$@" | sort; }

models() { # without those that were replaced, which are kept as seed-N.1 and so on
  (cd "$1" && find runs -name 'seed-*.*' -prune -o -name model.ply -print0 | sort -z | xargs -0 sha256sum)
}

failures() { # OUT: jobs that were begun and are not done
  (cd "$1/jobs" && { grep -rl --include='*.json' '"done": false' . || true; } | sed 's#^\./##; s#\.json$##' | sort)
}
