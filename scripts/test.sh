#!/usr/bin/env bash
# Installs packages, builds and runs the tests.
# Usage: test.sh [release|ci|debug] [ARGUMENTS OF CTEST]
#   debug: address and undefined-behaviour sanitizers. Without arguments all tests but those labelled
#   `nightly` run; `test.sh release -L nightly` runs these, `test.sh release -L batch` those of batches.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
selection=("$@")
if [ $# -eq 0 ]; then
  selection=(-LE nightly)
fi

scripts/install_packages.sh test
cmake --preset "$preset" -DTESSERA_TESTS=ON
cmake --build --preset "$preset"
ctest --preset "$preset" -j "$(nproc)" "${selection[@]}"
