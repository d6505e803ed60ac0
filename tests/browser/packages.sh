#!/bin/sh
# Fetches the packages of package-lock.json into a folder, unless they are those already.
# Usage: packages.sh NODE FOLDER
set -eu
source=$(dirname "$0")
mkdir -p "$2"
if cmp -s "$source/package-lock.json" "$2/fetched-lock.json"; then
  exit 0
fi
rm -f "$2/fetched-lock.json"
"$1" "$source/../../tools/web/fetch_packages.mjs" "$source/package-lock.json" "$2"
cp "$source/package-lock.json" "$2/fetched-lock.json"
