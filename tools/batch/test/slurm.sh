#!/bin/bash
# The same batch through a real Slurm: results equal to those of one machine; a training that is
# stopped, requeued or loses its node goes on from its checkpoint.
source "$(dirname "$0")/common.sh"
export USER=${USER:-$(id -un)}
cluster=$test_folder/slurm_cluster.sh
on_exit() {
  local job
  for job in $(jobs -p); do # the driver, below its shell
    pkill -KILL -P "$job" || kill -KILL "$job" 2>/dev/null || true
  done
  "$cluster" stop "$work/slurm" 2>/dev/null || true
}
command -v slurmctld slurmd munged >/dev/null || PATH=$PATH:/usr/sbin
command -v slurmctld >/dev/null || { echo "skip  no slurmctld: apt-get install slurm-wlm" && exit 0; }
eval "$(NODE_CPUS=2 "$cluster" start "$work/slurm" 2>/dev/null)"

short="iterations: 40, init_points: 500, peak_gaussians: 1000"
long="iterations: 3000, init_points: 500, peak_gaussians: 1000, checkpoint_every: 20"
batch() { # OUT OPTIONS SCENES
  write_batch "$1" "deterministic: true" "threads: 1" "exports: [tessera]" "captures: [$3]" \
    "presets: [{name: quick, preset: fast, options: {$2}}]"
}
on_slurm() { PROFILE=slurm flow "$1" --latency-wait 5 >>"$1.log" 2>&1; }
for i in 1 2; do make_capture "room_$i" "$i"; done

batch "$work/local" "$short" "../captures/*/"
batch "$work/on_slurm" "$short" "../captures/*/"
check "on one machine" run_batch "$work/local"
check "on Slurm" on_slurm "$work/on_slurm"
check "ran there" test "$(find "$work/on_slurm/logs/slurm" -name '*.log' | wc -l)" -eq 10
check "bit-equal models" same "$(models "$work/local")" "$(models "$work/on_slurm")"
check "nothing is to do on one machine, either" same "" "$(planned "$work/on_slurm")"

batch "$work/calm" "$long" "../captures/room_1"
batch "$work/rough" "$long" "../captures/room_1"
check "a longer training on one machine" run_batch "$work/calm"
run=$work/rough/runs/room_1/quick/seed-1
log=$work/rough/logs/train/room_1.quick.seed-1.log
job() { squeue -h -t running -o '%i %j' | sed -n 's/ .*\.train\..*//p'; }
node() { scontrol -o show job "$(job)" | sed -n 's/.* NodeList=\([^ ]*\).*/\1/p'; }
starts() { grep -c 'attempt' "$log" 2>/dev/null || true; }
started() { # N: the Nth start of the training has written a checkpoint
  [[ $(starts) -ge $1 && -n $(job) && $run/checkpoint.ckpt -nt $work/mark ]]
}
after() { # N TEXT: the training's Nth start is at work; what was done so far
  check "$2: at work" wait_for 600 started "$1"
}
touch "$work/mark"
on_slurm "$work/rough" &
driver=$!
after 1 "first start"
touch "$work/mark"
check "scancel --signal=TERM" scancel --full --signal=TERM "$(job)"
after 2 "a new job after SIGTERM"
check "interrupted with a checkpoint" grep -q '"initialisation":"checkpoint"' "$run/log.jsonl"
first=$(job) && touch "$work/mark"
check "scontrol requeue" scontrol requeue "$first"
after 3 "the same job again"
check "by its number" same "$first" "$(job)"
lost=$(node) && touch "$work/mark"
check "its node $lost is set down" scontrol update "NodeName=$lost" State=DOWN Reason=test
after 4 "on another node"
check "not on $lost" test "$(node)" != "$lost"
check "the batch is done" wait "$driver"
check "every start but the first went on from a checkpoint" \
  same "$(($(starts) - 1))" "$(grep -c -e --resume "$log")"
check "the model is that of an undisturbed training" same "$(models "$work/calm")" "$(models "$work/rough")"
check "no failure is recorded" same "" "$(failures "$work/rough")"
