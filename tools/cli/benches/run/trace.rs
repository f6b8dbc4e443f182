//! Cost of the trace: one record, and recorded lockstep runs with and without it.

use std::path::Path;
use std::time::Instant;

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;
use slipstream_ipc::trace;

use crate::{best, number, run};

/// Pairs of runs, one with the trace and one without.
const PAIRS: usize = 31;
/// Long enough that start-up and shutdown are negligible.
const DURATION: &str = "duration_s=60";
const RECORDS: u32 = 20_000;

/// Measures and prints the tables.
pub(crate) fn measure() {
    println!(
        "\nTrace, one record (ns): event with four numbers, span with four numbers, filtered out"
    );
    let [event, span, filtered] = measure_record();
    println!("{event:15.0} {span:8.0} {filtered:8.1}");
    println!(
        "\nTrace, recorded lockstep run of 60 s, {PAIRS} pairs (ms): with trace, without; ratio: median (quartiles)"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, mode) in [
        ("as processes", &[][..]),
        ("in one process", &["--in-process"]),
    ] {
        let pairs: Vec<[Cost; 2]> = (0..PAIRS).map(|k| pair(folder.path(), mode, k)).collect();
        let table: [(&str, Part); 2] = [
            ("loop, wall time", |cost| cost.loop_ms),
            ("command, CPU time", |cost| cost.cpu_ms),
        ];
        for (what, of) in table {
            let column = |index: usize| pairs.iter().map(|pair| of(&pair[index])).collect();
            let ratios = pairs.iter().map(|[on, off]| of(on) / of(off)).collect();
            let [[_, on, _], [_, off, _], [low, median, high]] =
                [column(0), column(1), ratios].map(quartiles);
            println!(
                "{name:>15}, {what:<17} {on:8.1} {off:8.1} {median:8.3} ({low:.3} to {high:.3})"
            );
        }
    }
}

/// One number of the cost.
type Part = fn(&Cost) -> f64;

/// Time that a run takes (ms).
struct Cost {
    /// Wall time of the simulation loop.
    loop_ms: f64,
    /// CPU time of all its processes, user and system; other work on the machine does not count.
    cpu_ms: f64,
}

/// A run with the trace and one without, in direct succession, so that other work on the machine affects both
/// alike. Each comes first equally often.
fn pair(folder: &Path, mode: &[&str], k: usize) -> [Cost; 2] {
    let cost = |key| cost(folder, &[&["--set", DURATION, "--set", key], mode].concat());
    let keys = ["recording.trace=true", "recording.trace=false"];
    if k.is_multiple_of(2) {
        keys.map(cost)
    } else {
        let [off, on] = [keys[1], keys[0]].map(cost);
        [on, off]
    }
}

/// Runs the experiment and measures its cost.
fn cost(folder: &Path, arguments: &[&str]) -> Cost {
    let before_ms = children_ms();
    let loop_ms = number(&run(folder, arguments), "loop_s") * 1e3;
    Cost {
        loop_ms,
        cpu_ms: children_ms() - before_ms,
    }
}

/// CPU time of all child processes that have ended and of their children (ms).
fn children_ms() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap();
    let ms = |time: TimeVal| time.tv_sec() as f64 * 1e3 + time.tv_usec() as f64 / 1e3;
    ms(usage.user_time()) + ms(usage.system_time())
}

fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[(values.len() - 1) * quarter / 4])
}

/// Time for one record (ns), with the buffer drained as in a run; the best of 20 series.
fn measure_record() -> [f64; 3] {
    let _tracing = trace::begin("bench", "debug".parse().unwrap());
    let mut bytes = 0;
    let mut time = |record: &dyn Fn(u32)| {
        best(20, |_| {
            let begin = Instant::now();
            for i in 0..RECORDS {
                record(i);
                trace::drain_if_long(|_, chunk| bytes += chunk.len());
            }
            begin.elapsed().as_secs_f64() * 1e9 / f64::from(RECORDS)
        })
    };
    let times = [
        time(&|i| tracing::debug!(name: "event", from = 1_u32, to = 2_u32, seq = i, t_ns = 5_i64)),
        time(&|i| {
            let (robot, due_ns) = (1_u32, 2_i64);
            drop(tracing::debug_span!("span", robot, due_ns, seq = i, message = i).entered());
        }),
        time(&|i| tracing::trace!(name: "fine", from = 1_u32, to = 2_u32, seq = i, t_ns = 5_i64)),
    ];
    assert!(bytes > 0);
    times
}
