#!/bin/bash
# What is wrong in batch.yaml is said in one line that names it and the remedy, with exit code 2.
source "$(dirname "$0")/common.sh"

mkdir -p "$work/captures/a" "$work/more/a"
says() { # TEXT LINES...
  local text=$1 seen
  write_batch "$work/out" "${@:2}"
  check "exit code 2" same 2 "$(exit_code flow "$work/out" --dry-run 2>"$work/said")"
  seen=$(cat "$work/said")
  check "one line" same 1 "$(wc -l <"$work/said")"
  check "$text" grep -qF -- "$text" <<<"$seen"
}
says "unknown key 'preset'; did you mean 'presets'?" "captures: [../captures/*/]" "preset: fast"
says "unknown key 'ingst'; did you mean 'ingest'?" "scenes: [{path: a, ingst: []}]"
says "unknown key 'captain'; There are" "captures: [../captures/*/]" "captain: fast"
says "no folder matches ../nothing/*/" "captures: [../nothing/*/]"
says "two are named 'a'" "captures: [../captures/*/, ../more/*/]"
says "unknown preset 'balancd'; did you mean 'balanced'?" "captures: [../captures/*/]" "presets: [balancd]"
says "unknown option 'iteration'; did you mean 'iterations'?" "captures: [../captures/*/]" \
  "presets: [{preset: fast, options: {iteration: 5}}]"
says "'seed' is no option of a preset; use \`seeds\`" "captures: [../captures/*/]" \
  "presets: [{preset: fast, options: {seed: 5}}]"
says "two are named 'fast'" "captures: [../captures/*/]" "presets: [fast, {preset: fast}]"
says "unknown format 'tesera'; did you mean 'tessera'?" "captures: [../captures/*/]" "exports: [tesera]"
says "option 'iterations' is -5" "captures: [../captures/*/]" "presets: [{preset: fast, options: {iterations: -5}}]"
says "presets: expected a list" "captures: [../captures/*/]" "presets: fast"
says "scenes: expected a list" "scenes: 2026-11-22"
says "seeds: -1 is too small" "captures: [../captures/*/]" "seeds: [-1]"
says "seeds: expected a list with something in it" "captures: [../captures/*/]" "seeds: []"
says "seeds: expected a list of numbers" "captures: [../captures/*/]" "seeds: 3"
says "threads: expected a whole number from 1" "captures: [../captures/*/]" "threads: 0"
says "no scenes: give" "presets: [fast]"
says "cannot name a folder of results" "scenes: [{path: a, name: 'my capture'}]"
says "out: is /elsewhere" "captures: [../captures/*/]" "out: /elsewhere"
says "/no/tessera reference json does not run" "tessera: /no/tessera" "captures: [../captures/*/]"
