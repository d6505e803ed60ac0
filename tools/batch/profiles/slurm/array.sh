#!/bin/bash
# What: a batch as one job array, each task some of the scenes from the first stage to the last, where
#       a cluster wants few jobs and no driver on its login node. Not: the report: `tessera report OUT`.
# usage: cd OUT && sbatch --array=0-15 --cpus-per-task=8 --mem=32G --gres=gpu:1 --time=12:00:00 \
#          workflow/profiles/slurm/array.sh
# Any number of tasks will do. A task that is requeued goes on; to go on with all, submit it again.
#SBATCH --requeue --open-mode=append
set -euo pipefail
trap : TERM INT USR1  # jobscript.sh says why
mkdir -p logs
snakemake finished --snakefile workflow/Snakefile --profile workflow/profiles/local --directory . \
  --cores "${SLURM_CPUS_PER_TASK:-1}" \
  --config part="$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
