#!/usr/bin/env bash
# Writes the source archive of a release: the tracked files of HEAD and the built web pages, so that
# building it needs neither Node.js nor a network. Twice from one commit it is the same to the bit, where
# the pages are.
# Usage: source_release.sh [PAGES] [FOLDER]
#   PAGES   the folder of the built pages (default: build/release/tools/web)
#   FOLDER  for tessera-VERSION.tar.gz (default: build); without the tag vVERSION at HEAD the name
#           ends with the commit
set -euo pipefail
cd "$(dirname "$0")/.."
pages=${1:-build/release/tools/web}
folder=${2:-build}

for page in player report; do
  if [ ! -s "$pages/$page.html" ]; then
    echo "source_release.sh: $pages/$page.html: no built page; build with -DTESSERA_PLAYER=ON, or name their folder" >&2
    exit 2
  fi
done
version=$(sed -n 's/^project(tessera VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name=tessera-$version
if ! git tag --points-at HEAD | grep -qx "v$version"; then
  name+=-$(git rev-parse --short HEAD)
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git archive --prefix="$name/" HEAD | tar -x -C "$work"
mkdir "$work/$name/tools/web/built"
cp "$pages/player.html" "$pages/report.html" "$work/$name/tools/web/built/"
mkdir -p "$folder"
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mode=u+rw,go=rX \
  --mtime="$(git log -1 --format=%cI)" -cf - "$name" | gzip -9n >"$folder/$name.tar.gz"
echo "$folder/$name.tar.gz"
