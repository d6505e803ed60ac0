#!/usr/bin/env bash
# Builds the tests of kernels, ingest and recon4d with the address and undefined-behaviour
# sanitizers and runs them. `scripts/test.sh debug` does so for everything, in twice the time.
# Without CUDA: the sanitizers look at the host, and the ci build compiles the device's code.
# Each program runs as a few processes, not as one for every case: starting a sanitized one costs
# more than most cases. Whole captures of the real data sets stay out: three cases took as long as
# all others together.
set -euo pipefail
cd "$(dirname "$0")/.."
programs=(kernels ingest recon4d)
scripts/install_packages.sh test
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset debug -DTESSERA_TESTS=ON -DTESSERA_CUDA=OFF "${launcher[@]}"
cmake --build --preset debug --target "${programs[@]/%/_test}"

shards=$(nproc)
export GTEST_TOTAL_SHARDS=$shards GTEST_BRIEF=1
export GTEST_FILTER='-*OfStudio*:*.Fern*'
for program in "${programs[@]}"; do
  for ((shard = 0; shard < shards; shard++)); do
    echo "$program $shard"
  done
done | xargs -P "$shards" -L 1 bash -c 'cd build/debug/tests/$0 && GTEST_SHARD_INDEX=$1 ./$0_test'
