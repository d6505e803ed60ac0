#!/bin/bash
# Runs a batch as one job array, for clusters that allow few jobs and no driver on the login node.
# Each task runs all jobs of some scenes. Write the report afterwards: `tessera report OUT`.
# usage: cd OUT && sbatch --array=0-15 --cpus-per-task=8 --mem=32G --gres=gpu:1 --time=12:00:00 \
#          workflow/profiles/slurm/array.sh /path/to/tessera
# Any range of tasks will do. A task that is requeued goes on; to go on with those that failed, submit
# the same range again: what is done takes a second.
#SBATCH --requeue --open-mode=append
set -euo pipefail
trap : TERM INT USR1 # jobscript.sh says why
step=$SLURM_ARRAY_TASK_STEP
task=$(((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN) / step))
tasks=$(((SLURM_ARRAY_TASK_MAX - SLURM_ARRAY_TASK_MIN) / step + 1))
if ((tasks != SLURM_ARRAY_TASK_COUNT)); then
  echo "array.sh: tasks are no range, so that scenes would be left out; submit --array=0-15 or the like" >&2
  exit 2
fi
"${1:-tessera}" batch -o . --part "$task/$tasks"
