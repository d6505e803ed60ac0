#!/usr/bin/env bash
# Parses all sources in the unity files of the preset release. The commands of README.md compile
# these, and the build of .ci/run does not. A name of two unnamed namespaces in one unity file fails.
set -euo pipefail
cd "$(dirname "$0")/.."

cmake --preset release -B build/unity -DTESSERA_CUDA=OFF -DTESSERA_TESTS=ON -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
  >/dev/null
python3 - << 'PARSE'
import concurrent.futures, json, os, pathlib, shlex, subprocess, sys

def parse(entry):
    words = shlex.split(entry["command"])
    words[words.index("-o") + 1] = os.devnull
    return subprocess.run(words + ["-fsyntax-only", "-O0"], cwd=entry["directory"], capture_output=True, text=True)

entries = [e for e in json.loads(pathlib.Path("build/unity/compile_commands.json").read_text()) if "/Unity/" in e["file"]]
with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
    failed = [run.stderr for run in pool.map(parse, entries) if run.returncode]
print(f"{len(entries)} unity files, {len(failed)} do not compile", *failed, sep="\n")
sys.exit(bool(failed) or not entries)
PARSE
