//! What the recorded trace costs: runs in lockstep with it beside runs without.

use std::path::Path;
use std::time::Instant;

use slipstream_bus::trace::{self, EnvFilter};

use crate::{number, run};

/// Runs of each kind.
const TURNS: usize = 41;
const RECORDS: u32 = 200_000;

/// The table.
pub(crate) fn measure() {
    println!(
        "\nTrace: a record (ns): an event of four numbers, a span of as many, one filtered out"
    );
    let [event, span, none] = a_record();
    println!("{event:15.0} {span:8.0} {none:8.1}");
    println!(
        "\nTrace: loop of a recorded lockstep run of 15 s (ms): on, off, ratio of medians and of the best"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, place) in [
        ("in processes", &[][..]),
        ("in one process", &["--in-process"]),
    ] {
        let mut times = [Vec::new(), Vec::new()];
        let keys = ["recording.trace=true", "recording.trace=false"];
        // In turns, so that both see the same neighbours on the machine.
        for _ in 0..TURNS {
            for (times, key) in times.iter_mut().zip(keys) {
                times.push(loop_ms(folder.path(), &[&["--set", key], place].concat()));
            }
        }
        let [on, off] = times.map(|mut times| {
            times.sort_by(f64::total_cmp);
            [times[TURNS / 2], times[0]]
        });
        let [median, best] = [on[0] / off[0], on[1] / off[1]];
        println!(
            "{name:>15} {:8.1} {:8.1} {median:8.3} {best:8.3}",
            on[0], off[0]
        );
    }
}

fn loop_ms(folder: &Path, arguments: &[&str]) -> f64 {
    number(&run(folder, arguments), "loop_s") * 1e3
}

/// Nanoseconds for a record, the tape taken in as the bus does.
fn a_record() -> [f64; 3] {
    let _tracing = trace::begin("bench", EnvFilter::new("debug"));
    let mut bytes = 0;
    let mut each = |tell: &dyn Fn(u32)| {
        let begin = Instant::now();
        for i in 0..RECORDS {
            tell(i);
            if i % 16 == 0 {
                trace::drain(|_, piece| bytes += piece.len());
            }
        }
        begin.elapsed().as_secs_f64() * 1e9 / f64::from(RECORDS)
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
