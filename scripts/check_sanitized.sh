#!/usr/bin/env bash
# Builds the tests of kernels, ingest and recon4d with the address and undefined-behaviour
# sanitizers and runs them. `scripts/test.sh debug` does so for everything, in twice the time.
# Without CUDA: the sanitizers look at the host, and the ci build compiles the device's code.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_packages.sh test
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
cmake --preset debug -DTESSERA_TESTS=ON -DTESSERA_CUDA=OFF "${launcher[@]}"
cmake --build --preset debug --target kernels_test ingest_test recon4d_test
ctest --preset debug -j "$(nproc)" -R '^(kernels|ingest|recon4d)/'
