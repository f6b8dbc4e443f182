# What CI runs.
ci:
    bash .ci/run

# All benchmarks: plant, lockstep and latency, recordings, diagnosis.
bench:
    cargo bench --workspace

# Processes killed at random moments, a hundred times over.
kill:
    SLIPSTREAM_KILLS=100 cargo test --release -p slipstream --test kill -- --nocapture

# Ten million rows in and out.
large:
    cargo test --release -p slipstream-recording --test large -- --include-ignored --nocapture

# Each reader fuzzed for five minutes (needs a nightly toolchain and cargo-fuzz).
fuzz:
    cd tools/recording/fuzz && for target in $(cargo +nightly fuzz list); do cargo +nightly fuzz run $target -- -max_total_time=300; done

# The diagnosis tried on every effect at several sizes, on nothing, on pairs and on what it does not
# know: minutes to make, and as long as the diagnosis takes for each of some 170 cases.
battery:
    cargo build --release -p slipstream
    target/release/slipstream trial --plan battery --json target/battery.json --report target/battery.html

# The page of results on real robots, tests/real_robots (some minutes): RECORDINGS holds their folders.
real RECORDINGS="../shared/recordings":
    cargo run --release -p slipstream-tests --example real -- {{RECORDINGS}}
