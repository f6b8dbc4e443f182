//! The memory of an answer does not grow with the length of the run.
//!
//! 8 minutes against 33 at an inner loop of 200 Hz always; a quarter of an hour against an hour at 1 kHz
//! with `just large`.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::sync::Mutex;

use slipstream_bus::record::Fate;
use slipstream_trace::{Log, Step, answer};

/// By how much the peaks of two lengths may differ: one read buffer for each part that is merged, up to 64,
/// and the list of blocks
/// (bytes).
const MAX_GROWTH_BYTES: u64 = 8 << 20;

/// Only one test at a time measures the memory of this process.
static MEASURING: Mutex<()> = Mutex::new(());

/// Adds what happens in the outer tick `seq` of the robots 0 and 1, with `inner` inner ticks each.
fn one_tick(log: &mut Log, seq: u32, inner: u32) {
    let due_ns = i64::from(seq) * 50_000_000;
    let (from, to) = (0, 1);
    for robot in [from, to] {
        log.take(Step::Outer {
            robot,
            due_ns,
            began_ns: due_ns + i64::from(seq % 1000),
            done_ns: due_ns + 2000,
            message: (robot == to).then_some(seq.saturating_sub(1)),
        });
        for i in 0..inner {
            let tick_ns = due_ns + i64::from(i) * 50_000_000 / i64::from(inner);
            log.take(Step::Inner {
                robot,
                due_ns: tick_ns,
                began_ns: tick_ns + i64::from(seq % 77),
                done_ns: tick_ns + 100,
                outer_ns: due_ns,
            });
            log.take(Step::Applied {
                robot,
                tick_ns,
                taken_ns: tick_ns + 1000,
            });
        }
    }
    log.take(Step::Sent {
        from,
        to,
        seq,
        sampled_ns: due_ns,
        tick_ns: due_ns,
        sent_ns: due_ns + 2000,
        queued_ns: due_ns + 3000,
    });
    log.take(Step::Arrived {
        from,
        to,
        seq,
        available_ns: Some(due_ns + 20_000_000 + i64::from(seq % 9)),
    });
    log.take(Step::Taken {
        from,
        to,
        seq,
        tick_ns: due_ns + 50_000_000,
        fate: Fate::Used,
    });
}

/// Peak memory of answering a run of this many outer ticks (bytes); `None` where the system does not
/// report it.
fn peak(ticks: u32, inner: u32) -> Option<u64> {
    // Resets the peak.
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    let mut log = Log::default();
    (0..ticks).for_each(|seq| one_tick(&mut log, seq, inner));
    let answer = answer(&log, &[]);
    log.check().unwrap();
    assert_eq!(answer.hops[0].messages, u64::from(ticks) - 1);
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

fn memory_is_that_of_a_quarter(ticks: u32, inner: u32) {
    let guard = MEASURING.lock();
    let (Some(short), Some(long)) = (peak(ticks / 4, inner), peak(ticks, inner)) else {
        return;
    };
    drop(guard);
    eprintln!("{} kB, four times as long {} kB", short >> 10, long >> 10);
    assert!(long < short + MAX_GROWTH_BYTES, "{short} and {long} bytes");
}

#[test]
fn a_run_needs_no_more_memory_than_a_quarter() {
    memory_is_that_of_a_quarter(40_000, 10);
}

#[test]
#[ignore = "takes a minute and two gigabytes of disk"]
fn an_hour_needs_no_more_memory_than_a_quarter() {
    memory_is_that_of_a_quarter(72_000, 50);
}
