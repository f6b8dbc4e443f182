#!/usr/bin/env bash
# Does this checkout behave as BASE does? Compares, byte for byte,
#   - `state_hash` of the built-in experiments, in one process and (platoon) as processes;
#   - `diagnose --json` on the practice recordings.
# Usage: tests/same.sh BASE [PRACTICE]    BASE: a git revision; PRACTICE: folder of the recordings
set -euo pipefail
cd "$(dirname "$0")/.."
base=$(git rev-parse --verify "${1:?usage: tests/same.sh BASE [PRACTICE]}^{commit}")
practice=$(realpath "${2:-../shared/practice}")
test -d "$practice" || { echo "$practice: no practice recordings; name their folder" >&2; exit 2; }
work=$PWD/target/same
then_dir=$work/$base
mkdir -p "$work"

if [ ! -x "$then_dir/target/release/slipstream" ]; then
    test -d "$then_dir" || git worktree add --detach --force "$then_dir" "$base"
    (cd "$then_dir" && CARGO_TARGET_DIR=$then_dir/target cargo build --release -p slipstream)
fi

# answers BINARY OUT: everything that is compared, a file each
answers() {
    local binary=$1 out=$2 name
    mkdir -p "$out"
    for name in platoon single circle figure_eight lane_change; do
        "$binary" run "$name" --in-process --out "$out/run.mcap" --json "$out/run.json" > /dev/null
        grep -o '"state_hash": *"[^"]*"' "$out/run.json" > "$out/$name.hash"
        rm "$out/run.mcap" "$out/run.json"
    done
    "$binary" run --out "$out/run.mcap" --json "$out/run.json" > /dev/null
    grep -o '"state_hash": *"[^"]*"' "$out/run.json" > "$out/processes.hash"
    rm "$out/run.mcap" "$out/run.json"
    for recording in "$practice"/practice-*/; do
        name=$(basename "$recording")
        "$binary" diagnose "$recording" --robot "$practice/robots/$name.toml" \
            --json "$out/$name.json" > "$out/$name.txt" 2> /dev/null
    done
}

if [ ! -e "$then_dir/answers/done" ]; then
    answers "$then_dir/target/release/slipstream" "$then_dir/answers"
    touch "$then_dir/answers/done"
fi
cargo build --release -p slipstream
rm -rf "$work/now"
answers "$PWD/target/release/slipstream" "$work/now"

differ=0
for file in "$work"/now/*.hash "$work"/now/*.json; do
    name=$(basename "$file")
    if cmp -s "$file" "$then_dir/answers/$name"; then
        echo "same    $name"
    else
        echo "DIFFERS $name"
        differ=1
    fi
done
exit $differ
