#!/usr/bin/env bash
# Runs the README's two commands on a bare system: a root folder made by debootstrap
# (--variant=minbase) with a clone of HEAD and, of this machine, only host names and certificates.
# Needs root, debootstrap and about 12 GB below build/fresh.
# Usage: check_fresh.sh [bookworm|trixie] [COMMAND]
#   COMMAND  one shell command in the clone, in place of the two, such as 'CXX=clang++ scripts/test.sh'
# Prints one line per command: exit code, seconds, installed packages; keeps the logs and
# build/fresh/SUITE.json (version, commit, command, seconds, machine). Exit code 1 where a command failed.
set -euo pipefail
cd "$(dirname "$0")/.."
suite=${1:-bookworm}
shift || true
commands=(scripts/first_run.sh scripts/test.sh)
if [ $# -gt 0 ]; then
  commands=("$@")
fi

work=$PWD/build/fresh
root=$work/$suite
. scripts/bare_root.sh
trap 'unmount_root "$root"' EXIT
make_root "$suite" "$root" "$work"
git clone -q --no-hardlinks . "$root/root/tessera"
commit=$(git -C "$root/root/tessera" rev-parse HEAD)

# git, which fetches the clone on a real machine, comes with the first command
status=0
records=()
for i in "${!commands[@]}"; do
  command=${commands[$i]}
  log=$work/$suite.$i.log
  before=$(packages_in "$root")
  start=$(date +%s)
  code=0
  in_root "$root" "cd /root/tessera && $command" >"$log" 2>&1 </dev/null || code=$?
  seconds=$(($(date +%s) - start))
  packages=$(($(packages_in "$root") - before))
  echo "$suite: $command: exit $code, $seconds s, $packages packages installed; log: $log"
  records+=("{\"command\": \"${command//\"/\\\"}\", \"exit\": $code, \"seconds\": $seconds, \"packages_installed\": $packages}")
  if [ "$code" -ne 0 ]; then
    tail -n 20 "$log"
    status=1
  fi
done
version=$(sed -n 's/^project(tessera VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
joined=$(printf ', %s' "${records[@]}")
cat >"$work/$suite.json" <<JSON
{"check": "scripts/check_fresh.sh $suite", "version": "$version", "commit": "$commit",
 "cores": $(nproc), "date": "$(date -u +%F)", "commands": [${joined:2}]}
JSON
exit $status
