#!/bin/bash
# What failed and was put right is done again, and nothing old passes for its result: a capture that
# breaks, a mask that is repainted, a checkpoint that cannot be read, a program that stops in between.
source "$(dirname "$0")/common.sh"

out=$work/out capture=$work/captures/room
quick="{name: quick, preset: fast, options: {init_points: 500, peak_gaussians: 1000, iterations: 40}}"
mask() { # NAME ROWS: masks of 48 x 36 pixels, of which the first ROWS are not used
  python3 - "$work/masks" "$capture" "$1" <<'PYTHON'
import os, struct, sys, zlib
folder, capture, rows = sys.argv[1], sys.argv[2], int(sys.argv[3])
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
lines = b"".join(b"\0" + bytes([0 if y < rows else 255]) * 48 for y in range(36))
png = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 48, 36, 8, 0, 0, 0, 0)) +
       chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b""))
for split in ("train", "test", "val"):
    for name in os.listdir(f"{capture}/{split}"):
        os.makedirs(f"{folder}/{split}", exist_ok=True)
        open(f"{folder}/{split}/{name}", "wb").write(png)
PYTHON
}
batch() { # OPTIONS OF INGEST
  write_batch "$out" "deterministic: true" "threads: 1" "exports: [tessera]" \
    "scenes: [{name: room, path: ../captures/room, ingest: [$1]}]" "presets: [$quick]"
}
place=room/quick/seed-1
everything=$(lines ingest/room train/$place evaluate/$place export/$place/tessera)
run=$out/runs/$place

make_capture room 1
mask 6
batch "--masks, ../masks"
check "a batch" run_batch "$out"
first=$(models "$out")

cp "$capture/train/r_003.png" "$work/kept.png"
mv "$capture/transforms_train.json" "$work" && echo "{" >"$capture/transforms_train.json"
check "a capture breaks: exit code 1" same 1 "$(exit_code run_batch "$out")"
check "and shows no results of before" grep -q '^room,,quick,[0-9]*,0,,,' "$out/report/report.csv"
mv "$work/transforms_train.json" "$capture"
cp "$capture/train/r_004.png" "$capture/train/r_003.png"
check "fixed: everything is to do" same "$everything" "$(planned "$out")"
check "runs" run_batch "$out"
second=$(models "$out")
check "another model" test "$first" != "$second"

mask 12
check "masks repainted: everything is to do" same "$everything" "$(planned "$out")"
check "runs" run_batch "$out"
check "another model" test "$second" != "$(models "$out")"

prepare() { # what is left by a batch that is killed after ingest
  "$TESSERA" job "$out" ingest/room >/dev/null 2>&1
}
cp "$work/kept.png" "$capture/train/r_003.png"
"$TESSERA" batch -o "$out" --profile slurm >/dev/null 2>&1 || true # writes the list, and has no cluster
prepare
check "stopped after ingest: the rest is to do" same \
  "$(grep -v ingest <<<"$everything")" "$(planned "$out")"
check "runs" run_batch "$out"

echo "no checkpoint" >"$run/checkpoint.ckpt"
rm "$run"/{train,metrics}.json
trained=$(models "$out")
check "a checkpoint that cannot be read, of a training that is done" run_batch "$out"
check "its model is the same" same "$trained" "$(models "$out")"
check "nothing was trained" grep -q '"finished"' "$run/train.json"
check "no failure is recorded" same "" "$(failures "$out")"
