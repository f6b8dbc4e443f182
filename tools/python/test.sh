#!/usr/bin/env bash
# Builds the wheel, installs it into an empty environment, and runs the tests and the notebook there.
# The wheel shares its build with `cargo test`; PROFILE=release builds it as `pip install` does.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/tools" "$work/empty"
"$work/tools/bin/pip" install -q --disable-pip-version-check "maturin>=1.9,<2"
cargo build -q -p slipstream
CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}" "$work/tools/bin/maturin" build -q --profile "${PROFILE:-dev}" --out "$work/wheels"
"$work/empty/bin/pip" install -q --disable-pip-version-check "$(echo "$work"/wheels/*.whl)[tests]"
cd "$work"
"$work/empty/bin/python" -m pytest -q -p no:cacheprovider "$root/tools/python/tests" "$@"
