//! The memory of import, export and check does not grow with the length of the recording.
//!
//! 40 s against 160 s at 1 kHz always; a quarter of an hour against an hour with `just large`.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Mutex;

use slipstream_recording::{Map, read_spooled};

/// By how much the peaks of two lengths may differ: buffers of the allocator and the list of blocks
/// (bytes).
const MAX_GROWTH_BYTES: u64 = 6 << 20;

/// Only one test at a time measures the memory of this process.
static MEASURING: Mutex<()> = Mutex::new(());

/// A robot with wheels, pose and IMU at 1 kHz, and
/// position messages at 50 Hz.
fn write_recording(folder: &Path, rows: u32) {
    std::fs::create_dir_all(folder.join("r1")).unwrap();
    std::fs::write(folder.join("recording.toml"), "format = 1\n[robots.r1]\n").unwrap();
    let open = |name: &str, header: &str| {
        let mut csv = BufWriter::new(File::create(folder.join(name)).unwrap());
        writeln!(csv, "{header}").unwrap();
        csv
    };
    let mut wheels = open("r1/wheels.csv", "t_s,ticks_right,ticks_left");
    let mut pose = open("r1/pose.csv", "t_s,x_m,y_m,yaw_rad");
    let mut imu = open("r1/imu.csv", "t_s,ax_m_s2,gz_rad_s,note");
    let mut links = open("links.csv", "t_sent_s,t_received_s,from,to,x_m,y_m,yaw_rad");
    for i in 0..rows {
        let (t_s, phase) = (f64::from(i) * 1e-3, f64::from(i) * 1e-4);
        let (x, y) = (phase.sin(), phase.cos());
        writeln!(wheels, "{t_s},{},{}", i / 3, i / 4).unwrap();
        writeln!(pose, "{t_s},{x},{y},{}", -phase % 3.0).unwrap();
        writeln!(imu, "{t_s},{x},{y},{}", i % 10).unwrap();
        if i % 20 == 0 {
            writeln!(links, "{t_s},{},r1,r2,{x},{y},{phase}", t_s + 0.01 * y * y).unwrap();
        }
    }
    [wheels, pose, imu, links]
        .iter_mut()
        .for_each(|csv| csv.flush().unwrap());
}

/// Peak memory of this process during `work` (bytes); `None` where the system does not report it.
fn peak_memory(work: impl FnOnce()) -> Option<u64> {
    // Resets the peak.
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    work();
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

/// Peak memory of importing, checking and exporting a recording of this length (bytes).
fn peaks(rows: u32) -> Option<[u64; 3]> {
    let scratch = tempfile::tempdir().unwrap();
    let [given, bag, back] = ["given", "bag.mcap", "back"].map(|name| scratch.path().join(name));
    write_recording(&given, rows);
    Some([
        peak_memory(|| {
            read_spooled(&given, &Map::None, &[])
                .unwrap()
                .write_mcap(&bag)
                .unwrap()
        })?,
        peak_memory(|| {
            let report = read_spooled(&bag, &Map::None, &[])
                .unwrap()
                .check(None)
                .unwrap();
            assert_eq!(report.robots[0].streams[0].rows, rows as usize);
        })?,
        peak_memory(|| {
            read_spooled(&bag, &Map::None, &[])
                .unwrap()
                .write_folder(&back)
                .unwrap()
        })?,
    ])
}

fn memory_is_that_of_a_quarter(rows: u32) {
    let guard = MEASURING.lock();
    let (Some(short), Some(long)) = (peaks(rows / 4), peaks(rows)) else {
        return;
    };
    drop(guard);
    for (what, (short, long)) in ["import", "check", "export"]
        .iter()
        .zip(short.iter().zip(long))
    {
        eprintln!(
            "{what}: {} kB, four times as long {} kB",
            short >> 10,
            long >> 10
        );
        assert!(
            long < short + MAX_GROWTH_BYTES,
            "{what}: {short} and {long} bytes"
        );
    }
}

#[test]
fn minutes_need_no_more_memory_than_seconds() {
    memory_is_that_of_a_quarter(160_000);
}

#[test]
#[ignore = "takes minutes and a gigabyte of disk"]
fn an_hour_needs_no_more_memory_than_a_quarter() {
    memory_is_that_of_a_quarter(3_600_000);
}
