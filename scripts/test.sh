#!/usr/bin/env bash
# Installs packages, builds and runs the tests on a fresh Debian 12 machine.
# Usage: test.sh [release|ci|debug]   debug: address and undefined-behaviour sanitizers
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}

scripts/install_packages.sh test
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_CUDA_COMPILER_LAUNCHER=ccache)
fi
cmake --preset "$preset" -DTESSERA_TESTS=ON "${launcher[@]}"
cmake --build --preset "$preset"
ctest --preset "$preset" -j "$(nproc)"
