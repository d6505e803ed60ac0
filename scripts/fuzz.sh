#!/usr/bin/env bash
# Fuzzes every reader of third-party files under libFuzzer and sanitizers.
# Usage: fuzz.sh [EXECUTIONS per reader, default 20000] [READER…]
# Prints a line per reader and keeps inputs that crash it in build/fuzz/crashes, with exit code 1.
# Executions include the seed inputs, which the project's writers make. Equal seeds (FUZZ_SEED, default
# 1) and executions give equal inputs.
set -euo pipefail
cd "$(dirname "$0")/.."

executions=${1:-20000}
shift || true
readers=("$@")
if [ ${#readers[@]} -eq 0 ]; then
  readers=(ply png sog splat spz glb lines model tessera4d transforms calibration profile view)
fi
build=build/fuzz
compiler=$(compgen -c clang++- | grep -E '^clang\+\+-[0-9]+$' | sort -V | head -1)
cmake -S . -B $build -G Ninja -DTESSERA_FUZZ=ON -DCMAKE_CXX_COMPILER="${compiler:-clang++}" \
  -DCMAKE_BUILD_TYPE=None -DTESSERA_INGEST=OFF -DTESSERA_CUDA=OFF -DTESSERA_TESTS=OFF >/dev/null
ninja -C $build fuzz_seeds "${readers[@]/#/fuzz_}" >$build/ninja.log || { cat $build/ninja.log; exit 1; }

export TMPDIR ASAN_OPTIONS=quarantine_size_mb=32
TMPDIR=$(mktemp -d -p "$([ -d /dev/shm ] && echo /dev/shm || echo /tmp)")
trap 'rm -rf "$TMPDIR"' EXIT
mkdir -p $build/crashes
$build/tests/fuzz/fuzz_seeds "$TMPDIR/seeds"

status=0
for reader in "${readers[@]}"; do
  mkdir -p "$TMPDIR/found"
  log=$build/$reader.log
  longest=4096
  [ "$reader" != lines ] || longest=16384  # codebooks of 256 numbers in text
  # 512 MB in all and at once: what a file promises must not be believed
  $build/tests/fuzz/fuzz_"$reader" -runs="$executions" -seed="${FUZZ_SEED:-1}" -max_len="$longest" -timeout=10 \
    -rss_limit_mb=512 -malloc_limit_mb=512 -dict=tests/fuzz/words.dict -print_final_stats=1 \
    -artifact_prefix=$build/crashes/"$reader"- "$TMPDIR/found" "$TMPDIR/seeds/$reader" \
    >"$log" 2>&1 && crashes=0 || crashes=1
  done_runs=$(sed -n 's/stat::number_of_executed_units: //p' "$log")
  seconds=$(sed -n 's/.*Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$log")
  echo "$reader: ${done_runs:-0} executions, $crashes crashes${seconds:+, $seconds s}"
  if [ $crashes -ne 0 ]; then
    grep -m3 -E "ERROR|runtime error|SUMMARY" "$log" || tail -5 "$log"
    status=1
  fi
  rm -rf "$TMPDIR/found"
done
exit $status
