//! Damaged files: truncated, with flipped bits, empty, of another format. Everything intact is read,
//! losses are counted, and nothing panics.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex};

use slipstream_recording::recording::{
    LinkMessage, Links, Odometry, Recording, Robot, Stream, UnknownColumn, Wheels,
};
use slipstream_recording::run_writer::{RunHeader, RunWriter};
use slipstream_recording::{Import, mcap_bytes, read_mcap_from};

/// Rows of the test recording, enough for several chunks.
const ROWS: usize = 30_000;

fn recording(rows: usize) -> Recording {
    let t_s: Vec<f64> = (0..rows).map(|i| i as f64 * 0.02).collect();
    let mut robot = Robot::named("r1");
    robot.odometry = Some(Stream {
        t_s,
        values: Odometry {
            v_m_s: (0..rows).map(|i| (i as f64 * 0.7).sin()).collect(),
            w_rad_s: Some((0..rows).map(|i| (i as f64 * 0.3).cos()).collect()),
        },
        unknown: Vec::new(),
    });
    Recording {
        name: "damage".to_owned(),
        robots: vec![robot],
        ..Recording::default()
    }
}

fn as_mcap(recording: &Recording) -> Vec<u8> {
    mcap_bytes(recording, Path::new("damage.mcap")).unwrap()
}

fn read(bytes: &[u8]) -> Result<Import, String> {
    read_mcap_from(bytes, bytes.len() as u64, Path::new("damage.mcap")).map_err(|e| e.to_string())
}

/// Asserts that the recovered rows are the first ones, unchanged. Returns their number.
fn assert_prefix(import: &Import) -> usize {
    let Some(robot) = import.recording.robots.first() else {
        return 0;
    };
    let Some(stream) = &robot.odometry else {
        return 0;
    };
    let whole = recording(stream.len());
    let whole = whole.robots[0].odometry.as_ref().unwrap();
    // Without lossless rows, a time is rounded to whole nanoseconds.
    for (a, b) in stream.t_s.iter().zip(&whole.t_s) {
        assert!((a - b).abs() < 1e-9);
    }
    assert_eq!(stream.values.v_m_s, whole.values.v_m_s);
    assert_eq!(stream.values.w_rad_s, whole.values.w_rad_s);
    stream.len()
}

/// The forward speeds that were read.
fn speeds_of(import: &Import) -> Vec<f64> {
    let streams = import
        .recording
        .robots
        .iter()
        .filter_map(|robot| robot.odometry.as_ref());
    streams
        .flat_map(|stream| stream.values.v_m_s.clone())
        .collect()
}

/// Offset and opcode of each top-level record of the file.
fn records(bytes: &[u8]) -> Vec<(usize, u8)> {
    let mut at = 8;
    let mut found = Vec::new();
    while at + 9 <= bytes.len() - 8 {
        found.push((at, bytes[at]));
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        at += 9 + usize::try_from(length).unwrap();
    }
    found
}

const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0f;

#[test]
fn a_file_truncated_in_its_last_chunk_keeps_the_rows_before_it() {
    let bytes = as_mcap(&recording(ROWS));
    let records = records(&bytes);
    let chunks: Vec<usize> = records
        .iter()
        .filter(|r| r.1 == CHUNK)
        .map(|r| r.0)
        .collect();
    assert!(chunks.len() >= 3, "{} chunks", chunks.len());
    let last = *chunks.last().unwrap();
    let data_end = records.iter().find(|r| r.1 == DATA_END).unwrap().0;
    let before = assert_prefix(&read(&bytes[..last]).unwrap());
    assert!(0 < before && before < ROWS);
    let whole_last = records.iter().find(|r| r.0 > last).unwrap().0;
    // Reading a file of this size takes milliseconds; the test below tries every byte of a small one.
    let near = |cut: &usize, border: usize| cut.abs_diff(border) < 20;
    let cuts = (last..bytes.len()).filter(|cut| {
        cut % 10_007 == 0 || near(cut, last) || near(cut, whole_last) || near(cut, data_end)
    });
    for cut in cuts {
        let import = read(&bytes[..cut]).unwrap();
        let rows = assert_prefix(&import);
        // Of the last chunk, the rows before the cut are read.
        let at_least = if cut < whole_last { before } else { ROWS };
        assert!((at_least..=ROWS).contains(&rows), "cut at {cut}: {rows}");
        let loss = import.loss.unwrap();
        if cut < whole_last {
            assert_eq!(loss.bytes_at_end as usize, cut - last, "cut at {cut}");
        }
        assert!(
            loss.any() || cut == bytes.len(),
            "cut at {cut} is not detected"
        );
        assert!(!import.warnings.is_empty());
    }
}

/// A run of 50 rows in five chunks.
fn small_chunks() -> Vec<u8> {
    let header = RunHeader {
        description: recording(0),
        ..RunHeader::default()
    };
    let mut bytes = Vec::new();
    let mut run = RunWriter::to_sink(&mut bytes, Path::new("run.mcap"), &header).unwrap();
    let whole = recording(50);
    let odometry = whole.robots[0].odometry.as_ref().unwrap();
    for i in 0..50 {
        let w_rad_s = odometry.values.w_rad_s.as_ref().unwrap()[i];
        let velocity = [odometry.values.v_m_s[i], w_rad_s];
        run.write_odometry(0, i as i64 * 20_000_000, [0.0; 3], velocity)
            .unwrap();
        if i % 10 == 9 {
            run.flush().unwrap();
        }
    }
    run.finish().unwrap();
    bytes
}

#[test]
fn a_file_truncated_at_any_byte_keeps_the_rows_before_it() {
    let bytes = small_chunks();
    let chunks: Vec<usize> = {
        let records = records(&bytes);
        let next = |i: usize| records.get(i + 1).map_or(bytes.len(), |r| r.0);
        let is_chunk = |i: &usize| records[*i].1 == CHUNK;
        (0..records.len()).filter(is_chunk).map(next).collect()
    };
    assert_eq!(chunks.len(), 5);
    for cut in 0..bytes.len() {
        let whole_chunks = chunks.iter().filter(|end| **end <= cut).count();
        match read(&bytes[..cut]) {
            Ok(import) => {
                let rows = assert_prefix(&import);
                // Of the chunk that is cut, the rows before the cut may be read.
                let next = (whole_chunks + 1).min(5);
                assert!(
                    (10 * whole_chunks..=10 * next).contains(&rows),
                    "cut at {cut}"
                );
                let loss = import.loss.unwrap();
                assert_eq!(loss.messages_read as usize, rows);
                assert!(loss.any(), "cut at {cut} is not detected");
            }
            Err(error) => {
                assert_eq!(whole_chunks, 0, "cut at {cut}: {error}");
                assert!(!error.contains('\n') && error.contains("; "), "{error}");
            }
        }
    }
}

#[test]
fn no_wrong_row_is_read_whatever_bits_flip() {
    let bytes = small_chunks();
    let mut rows_read = 0;
    for at in 0..bytes.len() {
        let mut bytes = bytes.clone();
        for flip in [0x01, 0x80, 0xff] {
            bytes[at] ^= flip;
            if let Ok(import) = read(&bytes) {
                // Some bits, such as those of an index, do not affect the rows.
                let rows = speeds_of(&import);
                let whole = recording(50);
                let whole = whole.robots[0].odometry.as_ref().unwrap();
                let known = |v: &f64| whole.values.v_m_s.contains(v);
                assert!(rows.iter().all(known), "byte {at}");
                rows_read += rows.len();
            }
            bytes[at] ^= flip;
        }
    }
    assert!(rows_read > 0);
}

#[test]
fn a_damaged_chunk_is_skipped_and_its_messages_are_counted() {
    let mut bytes = as_mcap(&recording(ROWS));
    let records = records(&bytes);
    let chunks: Vec<usize> = records
        .iter()
        .filter(|r| r.1 == CHUNK)
        .map(|r| r.0)
        .collect();
    bytes[chunks[1] + 5_000] ^= 0x10;
    let import = read(&bytes).unwrap();
    let loss = import.loss.unwrap();
    let rows = import.recording.robots[0].odometry.as_ref().unwrap().len();
    assert_eq!(loss.damaged_chunks, 1);
    assert!(loss.messages_in_damaged_chunks > 1000);
    assert_eq!(
        (loss.messages_read + loss.messages_in_damaged_chunks) as usize % ROWS,
        0
    );
    assert!(rows < ROWS && rows > 1000);
    assert!(
        import.warnings[0].contains("1 damaged chunks with at least"),
        "{:?}",
        import.warnings
    );
}

#[test]
fn messages_out_of_order_are_sorted_with_their_unknown_columns() {
    let message = |t_sent_s: f64| LinkMessage {
        t_sent_s,
        t_received_s: Some(t_sent_s + 0.5),
        from: "r1".into(),
        to: "r2".into(),
        x_m: t_sent_s,
        y_m: 0.0,
        yaw_rad: 0.0,
        v_m_s: f64::NAN,
        w_rad_s: f64::NAN,
    };
    let times = [3.0, 1.0, 2.0, 1.0];
    let given = Recording {
        links: Some(Links {
            messages: times.map(message).to_vec(),
            with_velocity: false,
            unknown: vec![UnknownColumn {
                name: "note".to_owned(),
                cells: ["d", "a", "c", "b"].map(str::to_owned).to_vec(),
            }],
        }),
        ..Recording::default()
    };
    let links = read(&as_mcap(&given)).unwrap().recording.links.unwrap();
    let sent: Vec<f64> = links.messages.iter().map(|m| m.t_sent_s).collect();
    assert_eq!(sent, [1.0, 1.0, 2.0, 3.0]);
    assert_eq!(links.unknown[0].cells, ["a", "b", "c", "d"]);
}

#[test]
fn a_number_that_no_robot_has_is_an_empty_cell_with_a_warning() {
    let mut given = recording(40);
    let odometry = given.robots[0].odometry.as_mut().unwrap();
    odometry.values.v_m_s[3] = 1e300;
    odometry.values.v_m_s[5] = 1e-300;
    odometry.values.v_m_s[7] = f64::INFINITY;
    let import = read(&as_mcap(&given)).unwrap();
    assert_eq!(import.warnings.len(), 1);
    assert!(import.warnings[0].starts_with("r1/odometry: 1 numbers are larger than 1e9"));
    let speeds = speeds_of(&import);
    assert!(speeds[3].is_nan() && speeds[7].is_nan());
    assert_eq!(speeds[5], 1e-300);
}

#[test]
fn a_file_of_another_format_is_an_error_in_one_line() {
    let cases: [(&[u8], &str); 4] = [
        (
            b"",
            "damage.mcap: the file is empty; give a bag (MCAP, SQLite or ROS 1) or a folder with recording.toml",
        ),
        (
            b"t_s,x_m\n0,1\n",
            "damage.mcap: is not a bag of a known kind",
        ),
        (b"\x89MCAP", "damage.mcap: is not a complete MCAP file"),
        (
            b"\x89MCAP0\r\n\x06\xff\xff\xff\xff\xff\xff\xff\x7f",
            "damage.mcap: is not a complete MCAP file",
        ),
    ];
    for (bytes, message) in cases {
        let error = read(bytes).unwrap_err();
        assert!(error.starts_with(message), "{error}");
        assert!(!error.contains('\n'));
    }
}

/// A sink whose content can be read while it is written.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_killed_recorder_leaves_everything_up_to_its_last_flush() {
    let sink = Shared::default();
    let header = RunHeader {
        description: Recording {
            robots: vec![Robot::named("r1")],
            ..Recording::default()
        },
        ..RunHeader::default()
    };
    let mut run = RunWriter::to_sink(sink.clone(), Path::new("run.mcap"), &header).unwrap();
    for i in 0..100 {
        run.write_encoders(0, i * 20_000_000, [i, -i]).unwrap();
        if i == 59 {
            run.flush().unwrap();
        }
    }
    let written = sink.0.lock().unwrap().clone();
    let import = read(&written).unwrap();
    let wheels = import.recording.robots[0].wheels.as_ref().unwrap();
    let Wheels::Ticks { right, left } = &wheels.values else {
        panic!("no ticks");
    };
    assert_eq!(
        (right.len(), right[59], left[59]),
        (60, Some(59), Some(-59))
    );
    assert!(import.loss.unwrap().any());
}
