#!/usr/bin/env bash
# Installs what Tessera needs on Debian 12, Debian 13 or Ubuntu 24.04.
# Usage: install_packages.sh [build|package|test|check]
#   build  to build and run (default); package  also what a Debian package is made with; test  what
#   scripts/test.sh needs; check  also what the other checks of .ci/run and .ci/nightly need (clang,
#   formatters, debootstrap, mkdocs).
set -euo pipefail
purpose=${1:-build}
. /etc/os-release

packages=(
  g++ cmake ninja-build pkg-config git ca-certificates curl
  libglm-dev libpng-dev zlib1g-dev libdeflate-dev libzstd-dev libwebp-dev libfmt-dev nlohmann-json3-dev
  libcli11-dev libtbb-dev libyaml-cpp-dev libutf8proc-dev
  libavformat-dev libavcodec-dev libavutil-dev libswscale-dev libswresample-dev
  libopenimageio-dev libopencv-dev colmap libmicrohttpd-dev
)
case "$ID ${VERSION_ID:-}" in
  "debian 12") clang=14 browser=chromium ;;
  "debian 13") clang=19 browser=chromium ;;
  "ubuntu 24.04") clang=18 browser= ;;  # chromium is a snap there: browser tests are skipped
  *)
    echo "install_packages.sh: knows Debian 12, Debian 13 and Ubuntu 24.04, this is ${PRETTY_NAME:-$ID};" \
      "install the equivalents of: ${packages[*]}" >&2
    exit 2
    ;;
esac
if [ "$purpose" = package ]; then
  packages+=(dpkg-dev file)
elif [ "$purpose" != build ]; then
  packages+=(libgtest-dev libgmock-dev ccache ffmpeg python3-numpy $browser snakemake slurmctld slurmd
    slurm-client munge)
fi
if [ "$purpose" = check ]; then
  packages+=("clang-$clang" "libclang-rt-$clang-dev" debootstrap mkdocs mkdocs-material)
  # other versions format otherwise
  [ "$clang" != 14 ] || packages+=(clang-format-14 clang-tidy-14)
fi
if ! command -v node >/dev/null && [ ! -d "$(dirname "$0")/../tools/web/built" ]; then
  packages+=(nodejs)  # the web player; a newer node than the distribution's stays
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
