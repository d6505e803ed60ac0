#!/bin/sh
# properties = {properties}
# Slurm sends SIGTERM to all processes of a job before it kills them (scancel, requeue, time limit,
# lost node). A shell would die of it at once, and Slurm would kill the rest without any grace: this
# one outlives it, and the training writes its checkpoint.
trap : TERM INT USR1
{exec_job}
