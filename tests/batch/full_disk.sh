#!/bin/bash
# A batch on a disk that fills up: it ends with the reason and no exit code of success, whatever it was
# writing; with room again the same command continues to the model of a batch without it.
if [[ -z ${OWN_MOUNTS:-} ]]; then
  own=(unshare --mount --propagation private)
  ((EUID == 0)) || own+=(--map-root-user)
  "${own[@]}" true 2>/dev/null || { echo "skip  this machine allows no mounts" && exit 77; }
  OWN_MOUNTS=1 exec "${own[@]}" "$0"
fi
source "$(dirname "$0")/common.sh"

disk=$work/disk out=$work/disk/out log=$work/log
mkdir "$disk"
on_exit() { umount "$disk" 2>/dev/null || true; }
mount -t tmpfs -o size=256m tmpfs "$disk"
leave() { # KB of room
  local used
  used=$(df --block-size=1K --output=used "$disk" | tail -1)
  mount -o "remount,size=$((used + $1))k" "$disk"
}
batch() { # OUT
  "$TESSERA" batch "$work/captures/room" -o "$1" --preset fast --iterations 40 --init-points 500 \
    --peak-gaussians 1000 --exports tessera --deterministic true --threads 1 --jobs 1 >>"$log" 2>&1
}

make_capture room 1
check "a batch" batch "$work/whole"
leave 4
check "no room for its own files: exit code 1" same 1 "$(exit_code batch "$out" 2>/dev/null)"
check "and one line that says why" grep -q 'cannot be written (No space left on device)' "$log"
failed=0
for room in 16 48 128 256 512 1024 4096; do
  leave "$room"
  if batch "$out"; then break; fi
  failed=$((failed + 1))
done
check "$failed batches without room end as failures" test "$failed" -ge 3
leave 262144
check "with room it continues" batch "$out"
check "to the same model" same "$(models "$work/whole")" "$(models "$out")"
