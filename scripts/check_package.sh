#!/usr/bin/env bash
# Builds the Debian package on a bare system and installs it on another, where it makes a capture,
# reconstructs it and prints what `tessera env` says. Both are root folders (bare_root.sh). Needs
# root, debootstrap and about 8 GB below build/fresh.
# Usage: check_package.sh [bookworm|trixie]
# Prints seconds, packages and megabytes; keeps the logs, the package in build/fresh/packages and
# build/fresh/SUITE.package.json.
set -euo pipefail
cd "$(dirname "$0")/.."
suite=${1:-bookworm}
work=$PWD/build/fresh
built=$work/$suite
root=$work/$suite.installed
packages=$work/packages
. scripts/bare_root.sh
trap 'unmount_root "$built"; unmount_root "$root"' EXIT

scripts/check_fresh.sh "$suite" 'scripts/install_packages.sh package && cmake --workflow --preset package'
mkdir -p "$packages"
file=$(ls "$built"/root/tessera/build/package/tessera_*.deb)
cp "$file" "$packages/"
file=$(basename "$file")
make_root "$suite" "$root" "$work"
cp "$packages/$file" "$root/root/"
before=$(packages_in "$root")
megabytes() { du -smx --exclude=archives "$root/usr" | cut -f1; }
size_before=$(megabytes)

timed() {  # timed NAME COMMAND: seconds of it; its output in SUITE.NAME.log
  local start
  start=$(date +%s)
  if ! in_root "$root" "cd /root && $2" >"$work/$suite.$1.log" 2>&1 </dev/null; then
    tail -n 20 "$work/$suite.$1.log" >&2
    exit 1
  fi
  echo $(($(date +%s) - start))
}
install=$(timed install "apt-get update -qq && apt-get install -y -qq --no-install-recommends ./$file")
installed=$(($(packages_in "$root") - before))
size=$(($(megabytes) - size_before))
capture=$(timed capture 'tessera synth room -o capture --layout n3dv --cameras 12 --frames 24')
result=$(timed result 'tessera run capture -o result --preset fast')
timed env 'tessera env' >/dev/null
cat "$work/$suite.env.log"
echo "$suite: $file: $installed packages and $size MB in $install s; capture $capture s, result $result s"
cat >"$work/$suite.package.json" <<JSON
{"check": "scripts/check_package.sh $suite", "commit": "$(git rev-parse HEAD)", "file": "$file",
 "bytes": $(stat -c %s "$packages/$file"), "packages_installed": $installed, "megabytes": $size,
 "seconds": {"install": $install, "capture": $capture, "result": $result}, "cores": $(nproc),
 "date": "$(date -u +%F)"}
JSON
