#!/bin/bash
# The driver of batches where Snakemake is not installed: which jobs it runs, how often and with how
# much memory, what a signal does, and batch.yaml where Python has no module for YAML. The program is a
# script that does as it is told; the tests with ENGINE=one_by_one run the real one.
set -euo pipefail
batch_folder=$(dirname "$(cd "$(dirname "$0")" && pwd)")
work=$(mktemp -d "${TMPDIR:-/tmp}/tessera-one-by-one.XXXXXX")
trap 'rm -rf "$work"' EXIT
out=$work/out

check() { # TEXT COMMAND...
  if "${@:2}"; then echo "ok    $1"; else echo "WRONG $1" && exit 1; fi
}
same() { # EXPECTED SEEN
  [[ $1 == "$2" ]] || { diff <(echo "$1") <(echo "$2") >&2 || return 1; }
}

cat >"$work/program" <<PROGRAM
#!/bin/bash
cd "\$(dirname "\$0")"
echo "\$*" >>words
case "\$*" in
  "reference json") cat reference.json && exit ;;
  "train no scene"*) echo "tessera: no scene: no such folder" >&2 && exit 2 ;;
esac
if [[ -e \$1.code ]]; then echo "tessera: \$1 was told to fail" >&2 && exit "\$(cat "\$1.code")"; fi
if [[ \$1 == ingest ]]; then
  [[ \$2 != */bad ]] || { echo "tessera: bad capture" >&2 && exit 2; }
  mkdir -p "out/\$4" && echo '{}' >"out/\$4/transforms.json"
fi
if [[ \$1 == train && -e slow ]]; then
  trap 'echo INT >>signals; sleep 0.3; exit 130' INT
  trap 'echo TERM >>signals; sleep 0.3; exit 75' TERM
  : >begun
  for _ in {1..200}; do sleep 0.1; done
fi
echo '{"tables": {"leakage": {"held_out_frames": 1}}}'
PROGRAM
chmod +x "$work/program"
cat >"$work/reference.json" <<REFERENCE
{"commands": [{"name": "train", "options": [{"names": ["--preset"], "choices": ["fast"]}]},
              {"name": "export", "options": [{"names": ["--format"], "choices": ["html"]}]}],
 "train_options": [{"key": "iterations"}, {"key": "checkpoint_every"}]}
REFERENCE
settings() { # OPTIONS
  cat >"$out/batch.yaml" <<BATCH
{"tessera": "$work/program", "captures": ["../captures/*/"], "exports": ["html"],
 "presets": [{"name": "quick", "preset": "fast", "options": {$1}}], "threads": 1}
BATCH
}
mkdir -p "$out" "$work/captures"/{bad,good}
touch "$work/captures"/{bad,good}/image
settings '"iterations": 5'

flow() { PYTHONPATH=$work/modules python3 "$batch_folder/one_by_one.py" --directory "$out" "$@"; }
ends_with() { # CODE ARGUMENTS...
  local code=0
  flow "${@:2}" >"$work/log" 2>&1 || code=$?
  [[ $code == "$1" ]] || { echo "exit code $code, expected $1" >&2 && cat "$work/log" >&2 && return 1; }
}
planned() { flow --dry-run 2>/dev/null; }
chain() { # SCENE FIRST: the jobs of a scene from that rule
  printf '%s\n' "ingest $1" "doctor $1" "train $1 quick 1" "evaluate $1 quick 1" \
    "export $1 quick 1 html" report | sed -n "/^$2/,\$p"
}
record() { # JOB KEY
  python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))[sys.argv[2]])' "$out/failures/$1.json" "$2"
}
calls() { grep -c "^$1" "$work/words" || true; }

# a module that is not there
mkdir "$work/modules" && echo 'raise ImportError("hidden")' >"$work/modules/yaml.py"
check "JSON needs no module for YAML" ends_with 0 --dry-run
check "a dry run writes nothing" test ! -e "$out/asked.json"
cp "$out/batch.yaml" "$work/kept" && echo 'captures: [../captures/*/]' >"$out/batch.yaml"
check "YAML does: exit code 2" ends_with 2
check "and one line names the package" same "1 1" \
  "$(wc -l <"$work/log") $(grep -c '^tessera: batch.yaml: .*apt-get install python3-yaml' "$work/log")"
cp "$work/kept" "$out/batch.yaml"

check "a scene fails: exit code 1" ends_with 1
check "bad input is not tried again" same 1 "$(grep -c '^ingest .*/bad' "$work/words")"
check "nothing that needs it runs" test ! -e "$out/doctor/bad.json"
check "the other scene is done" test -e "$out/exports/good/quick/seed-1/html.json"
check "the report is written, and says that it is no whole one" test ! -e "$out/logs/report.txt" -a \
  "$(calls "report $out")" == 1
check "the failed scene alone is to do" same "$(chain bad ingest)" "$(planned)"
rm -r "$work/captures/bad"
check "without it: the report" same report "$(planned)"
check "runs" ends_with 0
check "the record of its failure is gone" same "" "$(ls -A "$out/failures")"
check "nothing is to do" same "" "$(planned)"

sed -i 's/"exports": \["html"\]/"exports": []/' "$out/batch.yaml"
check "less is asked for: the report" same report "$(planned)"
settings '"iterations": 6'
check "an option: from the training" same "$(chain good train)" "$(planned)"
settings '"iterations": 5, "checkpoint_every": 7'
check "how often it saves: nothing" same "" "$(planned)"
touch "$work/captures/good/image"
check "a file of the capture: the scene" same "$(chain good ingest)" "$(planned)"
rm -r "$out/stamps"
check "without a record of it: nothing" same "" "$(planned)"
touch "$out/doctor/good.json"
check "a newer input: what needs it" same "$(chain good train)" "$(planned)"
check "runs" ends_with 0

touch "$out/runs/good/quick/seed-1/train.json"
echo 1 >"$work/evaluate.code" && : >"$work/words"
check "a job fails: exit code 1" ends_with 1
check "after three attempts" same 3 "$(calls evaluate)"
check "the last with three times the memory" same "3 900" \
  "$(record evaluate.good.quick.seed-1 attempt) $(record evaluate.good.quick.seed-1 mem_mb)"
check "what does not need it runs" same 1 "$(calls export)"
check "no older result is left" test ! -e "$out/runs/good/quick/seed-1/metrics.json"
rm "$work/evaluate.code"
check "that job is to do" same "$(printf '%s\n' "evaluate good quick 1" report)" "$(planned)"
check "runs" ends_with 0

settings '"iterations": 8'
: >"$work/slow"
mkdir "$work/captures/later" && touch "$work/captures/later/image"
stopped_by() { # SIGNAL: exit code
  local code=0
  rm -f "$work/begun" "$work/signals" && : >"$work/words"
  # a background job of a shell without job control ignores SIGINT, and one under nohup SIGHUP
  PYTHONPATH=$work/modules python3 -c 'import os, signal, sys
signal.signal(signal.SIGINT, signal.SIG_DFL), signal.signal(signal.SIGHUP, signal.SIG_DFL)
os.execvp("python3", ["python3", *sys.argv[1:]])' "$batch_folder/one_by_one.py" --directory "$out" 2>/dev/null &
  for _ in {1..100}; do [[ -e $work/begun ]] && break || sleep 0.1; done
  kill -"$1" $! && wait $! || code=$?
  echo "$code $(tr '\n' ' ' <"$work/signals")$(grep -c -e ^evaluate -e ^report -e "^ingest .*/later" "$work/words")"
}
check "Ctrl-C reaches the program once; nothing else starts" same "130 INT 0" "$(stopped_by INT)"
check "and that is the reason" same "was interrupted; repeat the command to go on" \
  "$(record train.good.quick.seed-1 message)"
check "so does SIGTERM" same "75 TERM 0" "$(stopped_by TERM)"
check "a lost terminal is a SIGTERM" same "75 TERM 0" "$(stopped_by HUP)"
rm "$work/slow"
check "the rest is to do" same "$(chain good train | grep -v report && chain later ingest)" "$(planned)"
check "runs" ends_with 0
