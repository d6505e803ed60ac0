#!/usr/bin/env bash
# Fails where two files of the program define one name differently (the one-definition rule): types,
# functions and variables of all layers, compared by the compiler at link time. Nothing is optimised
# and nothing is run. For the nightly: it compiles everything again, in build/odr.
# Usage: check_odr.sh [TARGET…]   default: tessera
set -euo pipefail
cd "$(dirname "$0")/.."
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  targets=(tessera)
fi
checks="-flto=auto -Werror=odr -Werror=lto-type-mismatch"
cmake -S . -B build/odr -G Ninja -DCMAKE_BUILD_TYPE=None -DTESSERA_NATIVE=OFF -DTESSERA_CUDA=OFF \
  -DTESSERA_TESTS=ON -DCMAKE_CXX_FLAGS="-O0 $checks -fno-fat-lto-objects" \
  -DCMAKE_EXE_LINKER_FLAGS="$checks" -DCMAKE_AR="$(command -v gcc-ar)" \
  -DCMAKE_RANLIB="$(command -v gcc-ranlib)" >/dev/null
ninja -C build/odr "${targets[@]}"
