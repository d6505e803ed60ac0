#!/usr/bin/env bash
# Runs clang-tidy 14 over the sources of the given folders (default: all layers), with the compile
# commands of the ci build. Usage: check_tidy.sh [FOLDER…]
set -euo pipefail
cd "$(dirname "$0")/.."
folders=("$@")
if [ ${#folders[@]} -eq 0 ]; then
  folders=(kernels ingest recon4d static3d tools)
fi
git ls-files "${folders[@]/%//*.cpp}" | grep -v -e '_absent.cpp$' -e 'parallel_std.cpp$' |
  xargs -P "$(nproc)" -n 2 clang-tidy-14 --quiet -p build/ci
