#!/usr/bin/env bash
# Writes the source archive of a release: the tracked files of HEAD and the built page of the web
# player, so that building it needs neither npm nor a network. Twice from one commit it is the same
# to the bit, where the page is.
# Usage: source_release.sh [PAGE] [FOLDER]
#   PAGE    the built page (default: build/release/tools/player/player.html)
#   FOLDER  for tessera-VERSION.tar.gz (default: build); without the tag vVERSION at HEAD the name
#           ends with the commit
set -euo pipefail
cd "$(dirname "$0")/.."
page=${1:-build/release/tools/player/player.html}
folder=${2:-build}

if [ ! -s "$page" ]; then
  echo "source_release.sh: $page: no built page of the player; build with -DTESSERA_PLAYER=ON, or name one" >&2
  exit 2
fi
version=$(sed -n 's/^project(tessera VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
name=tessera-$version
if ! git tag --points-at HEAD | grep -qx "v$version"; then
  name+=-$(git rev-parse --short HEAD)
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
git archive --prefix="$name/" HEAD | tar -x -C "$work"
cp "$page" "$work/$name/tools/player/player.html"
mkdir -p "$folder"
tar -C "$work" --sort=name --owner=0 --group=0 --numeric-owner --mode=u+rw,go=rX \
  --mtime="$(git log -1 --format=%cI)" -cf - "$name" | gzip -9n >"$folder/$name.tar.gz"
echo "$folder/$name.tar.gz"
