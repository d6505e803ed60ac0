#!/bin/sh
# Builds player.html in a folder of the build: packages of package-lock.json, then the page.
# Usage: build_page.sh NPM SOURCE WORK OUT on|auto   auto: without packages (no network) an empty OUT
set -eu
npm=$1 source=$2 work=$3 out=$4 mode=$5

fail() {
  if [ "$mode" = on ]; then
    echo "player: $1" >&2
    exit 1
  fi
  echo "player: $1; built without it. To try again: rm $out, and build" >&2
  : > "$out"
  exit 0
}

mkdir -p "$work"
if ! cmp -s "$source/package-lock.json" "$work/fetched-lock.json"; then
  rm -f "$work/fetched-lock.json"
  cp "$source/package.json" "$source/package-lock.json" "$work/"
  (cd "$work" && "$npm" ci --ignore-scripts --no-audit --no-fund --loglevel=error >&2) ||
    fail "npm ci cannot fetch the packages of tools/player/package-lock.json"
  cp "$source/package-lock.json" "$work/fetched-lock.json"
fi
rm -rf "$work/src" "$work/dist"
cp -R "$source/src" "$work/src"
cp "$source/package.json" "$source/index.html" "$source/vite.config.ts" "$source/tsconfig.json" "$work/"
# what is wrong with the page itself is never passed over
(cd "$work" && "$npm" run --silent build >&2)
cp "$work/dist/player.html" "$out"
