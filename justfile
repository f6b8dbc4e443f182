# What CI runs.
ci:
    bash .ci/run

# Compare behaviour with an earlier commit: state hashes, and diagnoses of the practice recordings in PRACTICE.
same BASE PRACTICE="../shared/practice":
    bash tests/same.sh {{BASE}} {{PRACTICE}}

# Imports and sizes of every package; `--circles` lists files that import each other in a circle.
structure *OPTIONS:
    cargo run -q -p slipstream-tests --example structure -- . {{OPTIONS}}

# What a newcomer waits for: build program and Python module into an empty folder, RUNS times; prints wall time, CPU and size. Needs
# an idle machine.
cold RUNS="3":
    bash .ci/cold {{RUNS}}

# All benchmarks: plant, lockstep and latency, recordings, diagnosis.
bench:
    cargo bench --workspace

# Make the pictures of the README anew (needs Chromium).
pictures:
    cargo build --release -p slipstream
    python3 docs/pictures.py

# Long form of the tests of the Python module: all practice recordings, with the wheel that `pip install` makes.
python:
    SLIPSTREAM_LONG=1 PROFILE=release bash tools/python/test.sh

# Long form of the kill test: a thousand processes killed at random moments.
kill:
    SLIPSTREAM_KILLS=1000 cargo test --release -p slipstream --test kill -- --nocapture

# Long forms of the tests of a watch: ten hours in which nothing changes, and a day for memory and speed; then its delays and
# false alarms on the halves of real recordings. RECORDINGS: their folder.
watch RECORDINGS="../shared/recordings":
    cargo test --release -p slipstream-diagnose --test watch -- --ignored --nocapture
    cargo test --release -p slipstream-diagnose --lib watch::links -- --ignored --nocapture
    cargo build --release -p slipstream
    for recording in {{RECORDINGS}}/*/; do target/release/slipstream trial --on $recording --watch || true; done

# Long form of the hang test: each role hung a hundred times. Needs a quiet machine.
hang:
    SLIPSTREAM_HANGS=100 cargo test --release -p slipstream --test hang -- --nocapture --test-threads 1

# Long form of the tests that let disk, shared memory, descriptors and memory run out, and that let two runs
# share one recording.
full:
    SLIPSTREAM_FULL=20 cargo test --release -p slipstream --test full -- --nocapture

# Long forms of the tests of throughput and memory: ten million rows in and out, an hour at 1 kHz.
large:
    cargo test --release -p slipstream-recording --test bounded_memory -- --include-ignored --nocapture
    cargo test --release -p slipstream-trace --test bounded_memory -- --include-ignored --nocapture
    cargo test --release -p slipstream-recording --test large -- --include-ignored --nocapture

# Fuzz readers for so many seconds each, beginning with the kept seeds and what earlier runs found (needs a nightly toolchain and cargo-fuzz). OPTIONS of libFuzzer, for example -runs=1000000.
fuzz TARGETS="" SECONDS="300" *OPTIONS:
    bash tests/fuzz/run.sh "{{TARGETS}}" {{SECONDS}} {{OPTIONS}}

# Trial of the diagnosis on every effect at several sizes, on nothing, on pairs and on unknown physics: some 170 diagnoses.
battery:
    cargo build --release -p slipstream
    target/release/slipstream trial --plan battery --json target/battery.json --report target/battery.html

# Long form of the test that no verdict contradicts its numbers and no number breaks an invariant: all recordings beside the
# repository, as a table.
honest:
    SLIPSTREAM_LONG=1 cargo test --release -p slipstream-tests --test honest -- --nocapture

# Write the page of real robots, tests/real_robots (some minutes). RECORDINGS: the folder of their recordings.
real RECORDINGS="../shared/recordings":
    cargo run --release -p slipstream-tests --example real -- {{RECORDINGS}}

# Five small changes, made by somebody who had not seen the code, applied to a copy and tested: does the guide still hold?
stranger *NAMES:
    bash tests/stranger.sh {{NAMES}}

# Write the reference in docs/reference from the code, and build the site into target/book if mdbook is there.
docs:
    SLIPSTREAM_WRITE_REFERENCE=1 cargo test -q -p slipstream --test reference
    if command -v mdbook > /dev/null; then mdbook build docs; else echo "no mdbook (cargo install mdbook --locked): no site"; fi

# Licences, known faults, doubles and sources of the dependencies (needs cargo-deny).
deny:
    cargo deny check

# Try the upload to crates.io: every package that is published, packed and built from what was packed.
package:
    cargo publish --workspace --dry-run --locked

# Build the archives of a release and their hashes into target/dist, from a clean checkout.
release:
    .ci/release

# Tests of runs across hosts, with network namespaces (needs root; compiles Zenoh, some ten minutes the first time).
hosts:
    cargo test --release -p slipstream --features hosts --test hosts -- --nocapture

# Tests of runs with real robots, played by robots in boxes (compiles Zenoh, some ten minutes the first time).
real:
    cargo test --release -p slipstream --features hosts --test real -- --nocapture

# Long form of the test of faults: a thousand, some half an hour.
faults:
    SLIPSTREAM_FAULTS=1000 cargo test --release -p slipstream --features hosts --test real faults -- --nocapture
