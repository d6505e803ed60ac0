#!/usr/bin/env bash
# Installs what Tessera needs on Debian 12. Usage: install_packages.sh [build|test]
#   build  to build and run (default); test  also what the checks of .ci/run need.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config git ca-certificates
  libglm-dev libpng-dev zlib1g-dev libzstd-dev libfmt-dev nlohmann-json3-dev libcli11-dev libtbb-dev
  libavformat-dev libavcodec-dev libavutil-dev libswscale-dev libswresample-dev
  libopenimageio-dev libopencv-dev colmap gnuplot-nox
)
if [ "${1:-build}" = test ]; then
  packages+=(libgtest-dev clang-14 libclang-rt-14-dev clang-format-14 clang-tidy-14 ccache ffmpeg
    chromium snakemake slurmctld slurmd slurm-client munge)
fi
if ! command -v node >/dev/null; then
  packages+=(nodejs npm)  # the web player; a newer node than Debian's stays
fi

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  exit 0
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
  "${missing[@]}"
