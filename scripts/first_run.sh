#!/usr/bin/env bash
# Set-up and main job on a fresh Debian 12 machine: installs packages, builds, makes a capture with
# `tessera synth`, reconstructs it, and ends with the result, its PSNR and a page that plays it.
# Usage: first_run.sh [OUT]     (default: out/first_run)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/first_run}

scripts/install_packages.sh build
cuda=AUTO  # three minutes of compiling that nothing here would use without a card
nvidia-smi -L >/dev/null 2>&1 || cuda=OFF
cmake --preset release -DTESSERA_TESTS=OFF -DTESSERA_CUDA=$cuda
cmake --build --preset release
tessera=build/release/tessera

if [ ! -f "$out/capture/ground_truth.json" ]; then
  "$tessera" synth room -o "$out/capture" --layout n3dv --cameras 12 --frames 24
fi
"$tessera" run "$out/capture" -o "$out/result" --preset fast
