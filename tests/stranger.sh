#!/usr/bin/env bash
# Applies each of the five small changes of tests/stranger to a copy of the last commit, writes the reference anew and runs the
# tests that the change names.
# Usage: tests/stranger.sh [NAME...]
set -euo pipefail
cd "$(dirname "$0")/.."
changes=$PWD/tests/stranger
copy=$PWD/target/stranger
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
[ $# -gt 0 ] || set -- effect stream command key column
git worktree remove --force "$copy" 2> /dev/null || true
git worktree add --quiet --detach --force "$copy"
trap 'git worktree remove --force "$copy"' EXIT
for name; do
    change=$changes/$name.patch
    git -C "$copy" reset --quiet --hard
    git -C "$copy" clean --quiet -fd
    git -C "$copy" apply -C1 "$change"
    begin=$SECONDS
    (cd "$copy" && SLIPSTREAM_WRITE_REFERENCE=1 cargo test --quiet -p slipstream --test reference)
    sed -n 's/^Run: //p' "$change" | while read -r command; do
        (cd "$copy" && $command --quiet < /dev/null)
    done
    echo "$name: $(grep -c '^diff ' "$change") files, $((SECONDS - begin)) s"
done
