#!/usr/bin/env bash
# Fuzzes each of TARGETS (all, if empty) for SECONDS: bash tests/fuzz/run.sh "TARGETS" SECONDS [libFuzzer options]
# New inputs are kept in tests/fuzz/corpus, an input that fails in tests/fuzz/artifacts.
set -euo pipefail
cd "$(dirname "$0")"
targets=${1:-} seconds=${2:-300}
shift $(($# > 2 ? 2 : $#))
: "${targets:=$(cargo +nightly fuzz list --fuzz-dir .)}"
for target in $targets; do
    mkdir -p "corpus/$target"
    # The readers have no unsafe code: the address sanitizer would only slow them down.
    cargo +nightly fuzz run --fuzz-dir . --sanitizer none --features libfuzzer "$target" \
        "corpus/$target" "seeds/$target" -- \
        -max_total_time="$seconds" -max_len=16384 -timeout=20 -print_final_stats=1 "$@"
done
