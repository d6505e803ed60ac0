#!/usr/bin/env bash
# Builds the tests of kernels, ingest and recon4d with the address and undefined-behaviour
# sanitizers and runs them. `scripts/test.sh debug` does so for everything, in twice the time.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/install_packages.sh test
cmake --preset debug -DTESSERA_TESTS=ON
cmake --build --preset debug --target kernels_test ingest_test recon4d_test
ctest --preset debug -j "$(nproc)" -R '^(kernels|ingest|recon4d)/'
