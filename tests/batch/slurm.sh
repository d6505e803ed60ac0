#!/bin/bash
# The same batch through a real Slurm: results equal to those of one machine; a training that is
# stopped, requeued or loses its node resumes from its checkpoint.
source "$(dirname "$0")/common.sh"
need_snakemake
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
command -v slurmctld >/dev/null || skip "no slurmctld: apt-get install slurm-wlm"
eval "$(NODE_CPUS=2 "$cluster" start "$work/slurm" 2>/dev/null)"

short="iterations: 40, init_points: 500, peak_gaussians: 1000"
long="iterations: 3000, init_points: 500, peak_gaussians: 1000, checkpoint_every: 20"
batch() { # OUT OPTIONS SCENES
  write_batch "$1" "deterministic: true" "threads: 1" "exports: [tessera]" "captures: [$3]" \
    "presets: [{name: quick, preset: fast, options: {$2}}]"
}
on_slurm() { PROFILE=$work/slurm_profile flow "$1" >>"$1.log" 2>&1; }
for i in 1 2; do make_capture "room_$i" "$i"; done

mkdir "$work/program" && ln -s "$TESSERA" "$work/program/tessera" && PATH=$work/program:$PATH
profile() { # a copy, which waits for files of nodes less long
  mkdir -p "$work/slurm_profile"
  cp "$test_folder"/../../tools/batch/profiles/slurm/* "$work/slurm_profile"
  sed -i 's/^latency-wait: .*/latency-wait: 5/' "$work/slurm_profile/config.yaml"
}
profile

batch "$work/local" "$short" "../captures/*/"
batch "$work/on_slurm" "$short" "../captures/*/"
check "on one machine" run_batch "$work/local"
check "on Slurm" on_slurm "$work/on_slurm"
check "ran there" test "$(find "$work/on_slurm/logs/slurm" -name '*.log' | wc -l)" -eq 8
check "bit-equal models" same "$(models "$work/local")" "$(models "$work/on_slurm")"
check "nothing is to do on one machine, either" same "" "$(planned "$work/on_slurm")"

batch "$work/array" "$short" "../captures/*/"
check "as a job array" sbatch --quiet --wait --array=5-7:2 --cpus-per-task=1 --mem=1000 \
  --chdir="$work/array" --output="$work/array.%a.log" "$work/slurm_profile/array.sh" "$TESSERA"
check "bit-equal models" same "$(models "$work/local")" "$(models "$work/array")"
for task in 5 7; do
  check "task $task: one scene" same 1 "$(grep -c 'of 4 jobs are to do' "$work/array.$task.log")"
done
check "nothing is to do" same "" "$(planned "$work/array")"
check "the report is written afterwards" "$TESSERA" report "$work/array"
printf '#!/bin/sh\necho "$CUDA_VISIBLE_DEVICES"\n' >"$work/card.sh"
card=$(cd "$work/array" && "$work/slurm_profile/submit.sh" card 1 100 1 1 "$TESSERA" "$work/card.sh")
refused=$(cd "$work/array" && TESSERA_SLURM_PARTITION=moon exit_code \
  "$work/slurm_profile/submit.sh" tag.train/room_1/quick/seed-1 1 100 1 0 "$TESSERA" "$work/card.sh" 2>/dev/null)
check "a job that Slurm refuses" same "1" "$refused"
check "is recorded with its word" grep -qi "sbatch: error: .*partition" "$work/array/jobs/train/room_1/quick/seed-1.json"
check "a job that wants a GPU has one" wait_for 60 grep -sqx 0 "$work/array/logs/slurm/$card.log"

batch "$work/calm" "$long" "../captures/room_1"
batch "$work/rough" "$long" "../captures/room_1"
check "a longer training on one machine" run_batch "$work/calm"
run=$work/rough/runs/room_1/quick/seed-1
job() { squeue -h -t running -o '%i %j' | sed -n 's# .*\.train/.*##p'; }
node() { scontrol -o show job "$(job)" | sed -n 's/.* NodeList=\([^ ]*\).*/\1/p'; }
starts() { grep -c '"event":"start"' "$run/log.jsonl" 2>/dev/null || true; }
begun() { [[ $(starts) -ge $1 && -n $(job) ]]; }
saved() { [[ $run/checkpoint.ckpt -nt $work/mark ]]; }
after() { # N TEXT: the training's Nth start is at work and has written a checkpoint
  check "$2: begun" wait_for 300 begun "$1"
  touch "$work/mark"
  check "$2: a checkpoint" wait_for 300 saved
}
on_slurm "$work/rough" &
driver=$!
after 1 "first start"
check "scancel --signal=TERM" scancel --full --signal=TERM "$(job)"
after 2 "a new job after SIGTERM"
first=$(job)
check "scontrol requeue" scontrol requeue "$first"
after 3 "the same job again"
check "by its number" same "$first" "$(job)"
lost=$(node)
check "its node $lost is set down" scontrol update "NodeName=$lost" State=DOWN Reason=test
after 4 "on another node"
check "not on $lost" test "$(node)" != "$lost"
check "the batch is done" wait "$driver"
check "SIGTERM let trainings save and leave" test "$(grep -c '"left":true' "$run/log.jsonl")" -ge 2
check "every start but the first went on from a checkpoint" \
  same "$(($(starts) - 1))" "$(grep -c '"initialisation":"checkpoint"' "$run/log.jsonl")"
check "the model is that of an undisturbed training" same "$(models "$work/calm")" "$(models "$work/rough")"
check "no failure is recorded" same "" "$(failures "$work/rough")"
