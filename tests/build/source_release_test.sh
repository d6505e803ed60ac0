#!/usr/bin/env bash
# A source archive has the page of the player, is configured without npm, knows its commit, and is
# the same when it is written again.
# Usage: source_release_test.sh FOLDER
# Bugs put back, each seen to fail: the page left out; times of the archive's files those of now; the
# commit asked of git alone.
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)
work=$1
if ! git -C "$source" rev-parse HEAD >/dev/null 2>&1; then
  echo "skipped: not a git checkout"
  exit 77
fi
rm -rf "$work"
mkdir -p "$work"
cd "$work"
echo "<!doctype html><title>a page</title>" >page.html
fail() {
  echo "$1" >&2
  exit 1
}

if "$source/scripts/source_release.sh" "$work/absent.html" "$work" 2>message; then
  fail "an archive without a page"
fi
grep -q "absent.html: no built page" message || fail "the message names no page: $(cat message)"

archive=$("$source/scripts/source_release.sh" "$work/page.html" "$work/first")
again=$("$source/scripts/source_release.sh" "$work/page.html" "$work/second")
cmp "$archive" "$again"
tar -xzf "$archive"
name=$(basename "$archive" .tar.gz)
cmp page.html "$name/tools/player/player.html"

mkdir bin  # a PATH without node and npm
for program in cmake ninja c++ g++ cc gcc ld as ar ranlib pkg-config git sh env uname; do
  ln -s "$(command -v "$program")" bin/
done
PATH=$work/bin cmake -G Ninja -S "$name" -B build -DTESSERA_TESTS=OFF -DTESSERA_CUDA=OFF \
  -DTESSERA_PLAYER=ON -DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=OFF >configure.log 2>&1 ||
  fail "$(tail -n 20 configure.log)"
grep -q "tools/player/CMakeFiles/tessera_player.dir/player_page.cpp.o" build/build.ninja ||
  fail "built without the page"
commit=$(git -C "$source" rev-parse --short HEAD)
grep -q "kCommitText = \"$commit\"" build/generated/tools/session/version.h ||
  fail "not of $commit: $(grep kCommitText build/generated/tools/session/version.h)"
