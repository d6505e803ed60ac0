#!/bin/bash
# Submits one job to Slurm and prints its id. The Snakefile computes the resources of the job.
# usage: submit.sh TAG.JOB CORES MEM_MB MINUTES GPUS TESSERA JOBSCRIPT
set -euo pipefail
name=$1 cores=$2 mem=$3 minutes=$4 gpus=$5 tessera=$6 script=$7

# --- your cluster -------------------------------------------------------------------------------
account=${TESSERA_SLURM_ACCOUNT:-}                      # empty: your default
cpu_partition=${TESSERA_SLURM_PARTITION:-}              # empty: the cluster's default
gpu_partition=${TESSERA_SLURM_GPU_PARTITION:-$cpu_partition}
gpu=${TESSERA_SLURM_GPU:-gpu}                           # the gres: gpu, or gpu:a100
longest=${TESSERA_SLURM_MINUTES:-2880}                  # the partition's time limit
# ------------------------------------------------------------------------------------------------

partition=$cpu_partition options=()
if ((gpus > 0)); then partition=$gpu_partition options+=("--gres=$gpu:$gpus"); fi
[[ -z $account ]] || options+=("--account=$account")
[[ -z $partition ]] || options+=("--partition=$partition")
mkdir -p logs/slurm
# singleton: when the driver was killed and started again, a job waits for its living twin.
# requeue: a job whose node is lost starts again, a training from its checkpoint.
refusal=$(mktemp)
trap 'rm -f "$refusal"' EXIT
sbatch --parsable --requeue --dependency=singleton --open-mode=append \
  --job-name="$name" --output="logs/slurm/%j.log" --cpus-per-task="$cores" --mem="$mem" \
  --time="$((minutes < longest ? minutes : longest))" "${options[@]}" "$script" 2>"$refusal" && exit 0
"$tessera" job . "${name#*.}" --refused "$(tail -n 1 "$refusal")"
