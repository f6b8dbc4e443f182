#!/bin/bash
# A trial of the diagnosis in 8 shards by GNU parallel: on all cores of this machine, or on the machines of a list.
#
#     bash trial.parallel.sh                            # computes what is missing, then merges
#     bash trial.parallel.sh --sshloginfile hosts.txt   # on other machines, in this folder shared by all
#
set -euo pipefail
shards=${SHARDS:-8}

# The log remembers what has ended: what failed, or never began, is run at the next call.
# One thread for each diagnosis: parallel starts one shard on each core.
export RAYON_NUM_THREADS=1
parallel --joblog shards.log --resume-failed --workdir . --env RAYON_NUM_THREADS "$@" \
    slipstream trial --plan battery --seed 1 \
    --shard "{}/$shards" --json "shard-{}.json" --resume ::: $(seq "$shards")

slipstream trial merge shard-*[0-9].json --json trial.json --report trial.html
