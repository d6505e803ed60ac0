#!/bin/bash
# A training that dies of memory begins again with fewer Gaussians and more memory, and the report says
# so; one that dies of something else goes on from its checkpoint as it was asked for. A program that
# plays this, and the kernel's count, stands before the real one.
source "$(dirname "$0")/common.sh"

make_capture room 1
real=$TESSERA
cat >"$work/program" <<PROGRAM
#!/bin/bash
[[ \$1 == train && -d \$2 ]] || exec "$real" "\$@"
count=\$(cat "$work/count" 2>/dev/null || echo 0)
echo \$((count + 1)) >"$work/count"
case \$(cat "$work/fault") in
memory) [[ \$* == *--peak-gaussians* ]] || {
    "$real" "\$@" --stop-after 10
    echo "tessera: out of memory; try a smaller --scale" >&2
    exit 1
  } ;;
kernel) ((count > 0)) || {
    "$real" "\$@" --stop-after 10
    echo "oom_kill 8" >"$work/counters"
    kill -KILL \$\$
  } ;;
killed) ((count > 0)) || { "$real" "\$@" --stop-after 10 && kill -KILL \$\$; } ;;
lost) ((count > 0)) || { "$real" "\$@" --stop-after 10 && kill -KILL \$PPID \$\$; } ;;
other) ((count > 0)) || { "$real" "\$@" --stop-after 10 && exit 1; } ;;
esac
exec "$real" "\$@"
PROGRAM
chmod +x "$work/program"
TESSERA=$work/program
export TESSERA_KERNEL_COUNTERS=$work/counters

value() { # FILE KEYS...: of a JSON file
  python3 -c 'import functools, json, sys
print(functools.reduce(lambda v, k: v[k], sys.argv[2:], json.load(open(sys.argv[1]))))' "$@"
}
try() { # FAULT
  echo "$1" >"$work/fault"
  rm -f "$work/count"
  echo "oom_kill 7" >"$work/counters"
  write_batch "$work/$1" "captures: [../captures/*/]" "exports: []" \
    "presets: [{name: quick, preset: fast, options: {iterations: 40, init_points: 500}}]"
  check "$1: done at the second attempt" run_batch "$work/$1"
  run=$work/$1/runs/room/quick/seed-1
  mapfile -t asked < <(sed -n 's/^exec.*job\.py train.*--mem-mb \([0-9]*\)$/\1/p' "$work/$1.log")
  check "$1: two attempts, the second asked for more memory" \
    test "${#asked[@]}" -eq 2 -a "${asked[1]:-0}" -gt "${asked[0]:-0}"
}
whole=$(try none 2>/dev/null | head -1) || true
check "a batch without faults" test "${whole%% *}" = ok
peak=$(value "$work/none/runs/room/quick/seed-1/config.json" options peak_gaussians)
for fault in memory kernel; do
  try "$fault"
  check "$fault: half of $peak Gaussians" \
    same "$((peak / 2))" "$(value "$run/config.json" options peak_gaussians)"
  check "$fault: begun anew" same "" "$(grep '"initialisation":"checkpoint"' "$run/log.jsonl" || true)"
  check "$fault: the report says so" \
    grep -q "trained again with peak_gaussians = $((peak / 2))" "$work/$fault/report/report.json"
done
for fault in killed lost other; do
  try "$fault"
  check "$fault: as many Gaussians" same "$peak" "$(value "$run/config.json" options peak_gaussians)"
  check "$fault: from its checkpoint" grep -q '"initialisation":"checkpoint"' "$run/log.jsonl"
done
