#!/bin/sh
# Fetches the packages of package-lock.json into a folder, unless they are those already.
# Usage: packages.sh NPM FOLDER
set -eu
source=$(dirname "$0")
mkdir -p "$2"
if cmp -s "$source/package-lock.json" "$2/fetched-lock.json"; then
  exit 0
fi
cp "$source/package.json" "$source/package-lock.json" "$2/"
cd "$2"
"$1" ci --ignore-scripts --no-audit --no-fund
cp package-lock.json fetched-lock.json
