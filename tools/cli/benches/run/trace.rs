//! What the recorded trace costs: runs in lockstep with it beside runs without.

use std::path::Path;
use std::time::Instant;

use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeVal;
use slipstream_ipc::trace::{self, EnvFilter};

use crate::{best, number, run};

/// Pairs of runs, one with the trace and one without.
const PAIRS: usize = 31;
/// Long enough for start and end not to count.
const DURATION: &str = "duration_s=60";
const RECORDS: u32 = 20_000;

/// The table.
pub(crate) fn measure() {
    println!(
        "\nTrace: a record (ns): an event of four numbers, a span of as many, one filtered out"
    );
    let [event, span, none] = a_record();
    println!("{event:15.0} {span:8.0} {none:8.1}");
    println!(
        "\nTrace: a recorded lockstep run of 60 s with it and without, {PAIRS} pairs (ms), and their ratios: median, quartiles"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, place) in [
        ("in processes", &[][..]),
        ("in one process", &["--in-process"]),
    ] {
        let pairs: Vec<[Cost; 2]> = (0..PAIRS).map(|k| pair(folder.path(), place, k)).collect();
        let table: [(&str, Part); 2] = [
            ("loop, wall time", |cost| cost.loop_ms),
            ("command, CPU time", |cost| cost.cpu_ms),
        ];
        for (what, of) in table {
            let column = |way: usize| pairs.iter().map(|pair| of(&pair[way])).collect();
            let ratios = pairs.iter().map(|[on, off]| of(on) / of(off)).collect();
            let [[_, on, _], [_, off, _], [low, median, high]] =
                [column(0), column(1), ratios].map(quartiles);
            println!(
                "{name:>15}, {what:<17} {on:8.1} {off:8.1} {median:8.3} ({low:.3} to {high:.3})"
            );
        }
    }
}

/// A part of what a run took.
type Part = fn(&Cost) -> f64;

/// What a run took.
struct Cost {
    loop_ms: f64,
    /// Of all its processes, in their own and the system's code: what other work on the machine
    /// takes is not in it.
    cpu_ms: f64,
}

/// With the trace and without, one right after the other so that both see the same neighbours on the
/// machine, and each as often first.
fn pair(folder: &Path, place: &[&str], k: usize) -> [Cost; 2] {
    let cost = |key| {
        cost(
            folder,
            &[&["--set", DURATION, "--set", key], place].concat(),
        )
    };
    let keys = ["recording.trace=true", "recording.trace=false"];
    if k.is_multiple_of(2) {
        keys.map(cost)
    } else {
        let [off, on] = [keys[1], keys[0]].map(cost);
        [on, off]
    }
}

fn cost(folder: &Path, arguments: &[&str]) -> Cost {
    let before_ms = children_ms();
    let loop_ms = number(&run(folder, arguments), "loop_s") * 1e3;
    Cost {
        loop_ms,
        cpu_ms: children_ms() - before_ms,
    }
}

/// CPU time of all children that have ended, and of theirs (ms).
fn children_ms() -> f64 {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).unwrap();
    let ms = |time: TimeVal| time.tv_sec() as f64 * 1e3 + time.tv_usec() as f64 / 1e3;
    ms(usage.user_time()) + ms(usage.system_time())
}

fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[(values.len() - 1) * quarter / 4])
}

/// Nanoseconds for a record, the tape taken in as the bus does; the best of some series.
fn a_record() -> [f64; 3] {
    let _tracing = trace::begin("bench", EnvFilter::new("debug"));
    let mut bytes = 0;
    let mut each = |tell: &dyn Fn(u32)| {
        best(20, |_| {
            let begin = Instant::now();
            for i in 0..RECORDS {
                tell(i);
                trace::drain_if_long(|_, piece| bytes += piece.len());
            }
            begin.elapsed().as_secs_f64() * 1e9 / f64::from(RECORDS)
        })
    };
    let times = [
        each(&|i| tracing::debug!(name: "event", from = 1_u32, to = 2_u32, seq = i, t_ns = 5_i64)),
        each(&|i| {
            let (robot, due_ns) = (1_u32, 2_i64);
            drop(tracing::debug_span!("span", robot, due_ns, seq = i, message = i).entered());
        }),
        each(&|i| tracing::trace!(name: "fine", from = 1_u32, to = 2_u32, seq = i, t_ns = 5_i64)),
    ];
    assert!(bytes > 0);
    times
}
