//! Long recordings: a round trip changes nothing, and memory is bounded by the size of the numbers.
//!
//! 200,000 rows always; ten million with `cargo test --release -p slipstream-recording --test large
//! -- --ignored`.

#![expect(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::time::Instant;

use slipstream_recording::recording::Wheels;
use slipstream_recording::{read, write_mcap};

/// Memory of a row of ticks: a time and two optional counts (bytes).
const ROW_BYTES: u64 = 8 + 2 * 16;

fn write_ticks(folder: &Path, rows: i64) {
    std::fs::create_dir_all(folder.join("r1")).unwrap();
    std::fs::write(folder.join("recording.toml"), "format = 1\n[robots.r1]\n").unwrap();
    let mut csv = BufWriter::new(File::create(folder.join("r1/wheels.csv")).unwrap());
    writeln!(csv, "t_s,ticks_right,ticks_left").unwrap();
    for i in 0..rows {
        writeln!(csv, "{}.{:03},{},{}", i / 1000, i % 1000, i * 7, -i).unwrap();
    }
    csv.flush().unwrap();
}

/// Peak memory of this process so far (bytes); `None` where the system does not report it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

fn round_trip(rows: i64) {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path().join("given");
    write_ticks(&folder, rows);
    let before = peak_memory();
    let started = Instant::now();
    let bag = scratch.path().join("bag.mcap");
    write_mcap(&read(&folder).unwrap().recording, &bag).unwrap();
    let imported = started.elapsed();
    let import = read(&bag).unwrap();
    eprintln!(
        "{rows} rows: imported in {imported:.1?}, read in {:.1?}",
        started.elapsed() - imported
    );
    assert_eq!(import.warnings, Vec::<String>::new());
    let wheels = import.recording.robots[0].wheels.as_ref().unwrap();
    let Wheels::Ticks { right, left } = &wheels.values else {
        panic!("no ticks");
    };
    assert_eq!(wheels.t_s.len(), usize::try_from(rows).unwrap());
    for i in (0..rows).step_by(997) {
        let row = usize::try_from(i).unwrap();
        assert_eq!((right[row], left[row]), (Some(i * 7), Some(-i)));
        assert_eq!(wheels.t_s[row], i as f64 / 1000.0);
    }
    if let (Some(before), Some(after)) = (before, peak_memory()) {
        // A list that grows needs up to three times its content while it is moved; the file is never
        // in memory as a whole.
        let bound = 3 * ROW_BYTES * rows.unsigned_abs() + (64 << 20);
        let taken = after - before;
        eprintln!("{rows} rows: {} MB at most", taken >> 20);
        assert!(taken < bound, "{taken} bytes of memory, {bound} allowed");
    }
}

#[test]
fn two_hundred_thousand_rows() {
    round_trip(200_000);
}

#[test]
#[ignore = "takes a minute and a gigabyte"]
fn ten_million_rows() {
    round_trip(10_000_000);
}
