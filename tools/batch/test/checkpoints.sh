#!/bin/bash
# What becomes of a checkpoint when a training fails: it stays as it is whatever the exit code, and the
# program is asked to decide again. The program is a script that ends as it is told, so that every exit
# code has its turn; cli_test looks at what it decides.
set -euo pipefail
batch_folder=$(dirname "$(cd "$(dirname "$0")" && pwd)")
python3 -c 'import yaml' 2>/dev/null || { echo "skip  no python3-yaml" && exit 77; }
work=$(mktemp -d "${TMPDIR:-/tmp}/tessera-checkpoints.XXXXXX")
trap 'rm -rf "$work"' EXIT
run=$work/runs/room/fast/seed-1

check() { # TEXT COMMAND...
  if "${@:2}"; then echo "ok    $1"; else echo "WRONG $1" && exit 1; fi
}

cat >"$work/program" <<PROGRAM
#!/bin/sh
echo "\$@" >>"$work/words"
case " \$* " in
  *" --overwrite --preset "*) [ ! -e "$work/code" ] || {
    echo "tessera: told to end with \$(cat "$work/code")" >&2 && exit "\$(cat "$work/code")"
  } ;;
esac
echo '{"finished": true}'
PROGRAM
chmod +x "$work/program"
mkdir -p "$work/scenes/room" "$work/doctor"
echo '{}' >"$work/scenes/room/transforms.json"
echo '{"tables": {}}' >"$work/doctor/room.json"
cat >"$work/asked.json" <<ASKED
{"tessera": "$work/program", "scenes": [{"name": "room", "path": "/data/room", "ingest": []}],
 "variants": [{"name": "fast", "preset": "fast", "options": {}}], "seeds": [1], "exports": [],
 "threads": 1, "gpus": 0, "deterministic": true}
ASKED

train() { (cd "$work" && python3 "$batch_folder/job.py" train room fast 1 2>"$work/err"); }
begin_with() { echo "$1" >"$run/checkpoint.ckpt"; }
ends_with() { # CODE
  local code=0
  train || code=$?
  [[ $code == "$1" ]] || { echo "exit code $code, expected $1" >&2 && cat "$work/err" >&2 && return 1; }
}
same_words() { [[ $(tail -n 1 "$work/words") == "$asked" ]]; }
holds() { [[ $(cat "$run/$1") == "$2" ]]; }

check "a training" ends_with 0
asked=$(tail -n 1 "$work/words")
check "the job of evaluate alone scores" grep -q -e "--evaluate-every never" <<<"$asked"
check "the program decides on it" grep -q -e "--overwrite --preset fast" <<<"$asked"
begin_with "hours of work"
for code in 1 2 75 130 137; do
  echo "$code" >"$work/code"
  check "a resumed one ends with $code" ends_with "$code"
  check "its checkpoint stays" holds checkpoint.ckpt "hours of work"
  check "nothing else is tried" same_words
  rm -f "$work/failures"/*.json # the next start is no second attempt
done

mv "$work/scenes/room/transforms.json" "$work/kept.json"
check "a scene that is out of reach for a moment" ends_with 1
check "costs no checkpoint" holds checkpoint.ckpt "hours of work"
mv "$work/kept.json" "$work/scenes/room/transforms.json"
