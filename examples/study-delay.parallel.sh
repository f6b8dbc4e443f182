#!/bin/bash
# A study of the delay in 8 shards by GNU parallel: on all cores of this machine, or on the machines of a list.
#
#     bash study-delay.parallel.sh                            # computes what is missing, then merges
#     bash study-delay.parallel.sh --sshloginfile hosts.txt   # on other machines, in this folder shared by all
#
set -euo pipefail
shards=${SHARDS:-8}

# The log remembers what has ended: what failed, or never began, is run at the next call.
# --threads 1: parallel starts one shard on each core.
parallel --joblog shards.log --resume-failed --workdir . "$@" \
    slipstream study delay \
    --robots 5 --runs 100 \
    --delay 0,0.025,0.05,0.075,0.1,0.15,0.2,0.25,0.3,0.4,0.5 \
    --jitter 0,0.02,0.05,0.1 --loss 0,0.05,0.1,0.2 --k-x 0.5,1,2,4 \
    --torque-limit none,inner,outer,adaptive --protocol ring,periodic \
    --threads 1 \
    --shard "{}/$shards" --json "shard-{}.json" --resume ::: $(seq "$shards")

slipstream study merge shard-*[0-9].json --json study.json --report study.html
