#!/bin/bash
# Prints the state of a Slurm job for Snakemake: running, success or failed. Needs no accounting.
# Without an answer from Slurm it prints running, and Snakemake calls it again.
if ! shown=$(timeout 20 scontrol -o show job "$1" 2>&1); then
  # forgotten (older than MinJobAge): it ended long ago and its output would have been seen
  if [[ $shown == *"Invalid job id"* ]]; then echo failed; else echo running; fi
  exit 0
fi
[[ $shown =~ JobState=([A-Z_]+) ]]
case ${BASH_REMATCH[1]:-} in
  COMPLETED) echo success ;;
  BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | REVOKED | TIMEOUT)
    echo failed ;;
  *) echo running ;; # also PENDING, REQUEUED, COMPLETING
esac
