#!/bin/sh
# Builds PAGE.html in OUT, a folder of the build, one after another: packages of package-lock.json,
# then the pages.
# Usage: build_pages.sh NODE SOURCE OUT on|auto PAGE...   auto: without packages (no network) empty
# pages
set -eu
node=$1 source=$2 out=$3 mode=$4
shift 4
work=$out/work

pages=$*
fail() {
  if [ "$mode" = on ]; then
    echo "web pages: $1" >&2
    exit 1
  fi
  echo "web pages: $1; built without them. To try again: rm $out/*.html, and build" >&2
  for page in $pages; do : > "$out/$page.html"; done
  exit 0
}

mkdir -p "$work"
"$node" "$source/fetch_packages.mjs" "$source/package-lock.json" "$work" >&2 ||
  fail "the packages of tools/web/package-lock.json cannot be fetched"
rm -rf "$work/dist"
for page in "$@"; do
  rm -rf "${work:?}/$page"
  cp -R "$source/$page" "$work/$page"
done
cp "$source/package.json" "$source/vite.config.ts" "$source/tsconfig.json" "$work/"
# what is wrong with a page itself is never passed over
(cd "$work" && "$node" node_modules/typescript/bin/tsc --noEmit >&2)
for page in "$@"; do
  # a build for each: what two pages share would be a file of its own
  (cd "$work" && PAGE=$page "$node" node_modules/vite/bin/vite.js build --logLevel warn >&2)
  cp "$work/dist/$page.html" "$out/$page.html"
done
