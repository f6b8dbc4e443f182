//! Throughput of writing and reading a run, compared with the `mcap` crate alone and encoded messages.
//!
//! Bytes count the messages before compression. `cargo bench -p slipstream-recording`.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark may stop at the first error"
)]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use divan::Bencher;
use divan::counter::BytesCount;
use mcap::records::MessageHeader;
use slipstream_recording::recording::{Recording, Robot};
use slipstream_recording::run_writer::{RunHeader, RunWriter};
use slipstream_recording::{mcap_bytes, read_mcap_from};

/// Number of times at which the run writes four messages each.
const TIME_STEPS: i64 = 50_000;

fn main() {
    divan::main();
}

fn write_run() -> Vec<u8> {
    let header = RunHeader {
        description: Recording {
            robots: vec![Robot::named("r1")],
            ..Recording::default()
        },
        ..RunHeader::default()
    };
    let mut bytes = Vec::new();
    let mut run = RunWriter::to_sink(&mut bytes, Path::new("run.mcap"), &header).unwrap();
    for i in 0..TIME_STEPS {
        let t_ns = i * 20_000_000;
        let x = (i as f64 * 0.7).sin();
        run.write_torque_command(0, t_ns, [x, -x]).unwrap();
        run.write_encoders(0, t_ns, [i, -i]).unwrap();
        run.write_camera(0, t_ns, [x, 2.0 * x, 3.0 * x]).unwrap();
        run.write_imu(0, t_ns, [x, 0.1 * x, 0.2 * x]).unwrap();
    }
    run.finish().unwrap();
    bytes
}

/// An encoded message: channel, log time (ns), bytes.
type Encoded = (u16, u64, Vec<u8>);

/// The encoded messages of a file.
fn encoded_messages(file: &[u8]) -> Vec<Encoded> {
    let messages = mcap::MessageStream::new(file).unwrap().map(Result::unwrap);
    messages
        .map(|m| (m.channel.id, m.log_time, m.data.into_owned()))
        .collect()
}

fn size(messages: &[Encoded]) -> BytesCount {
    BytesCount::new(
        messages
            .iter()
            .map(|(_, _, data)| data.len())
            .sum::<usize>(),
    )
}

#[divan::bench]
fn write_slipstream(bencher: Bencher<'_, '_>) {
    let size = size(&encoded_messages(&write_run()));
    bencher.counter(size).bench(write_run);
}

#[divan::bench]
fn write_mcap_alone(bencher: Bencher<'_, '_>) {
    let messages = encoded_messages(&write_run());
    bencher.counter(size(&messages)).bench(|| {
        let options = mcap::WriteOptions::new()
            .compression(Some(mcap::Compression::Lz4))
            .chunk_size(Some(768 * 1024));
        let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
        let channels: Vec<u16> = (0..4)
            .map(|i| {
                let topic = format!("/{i}");
                writer
                    .add_channel(0, &topic, "cdr", &BTreeMap::new())
                    .unwrap()
            })
            .collect();
        for (channel, log_time, data) in &messages {
            let header = MessageHeader {
                channel_id: channels[usize::from(*channel - 1)],
                sequence: 0,
                log_time: *log_time,
                publish_time: *log_time,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        }
        writer.finish().unwrap();
        writer.into_inner()
    });
}

#[divan::bench]
fn read_slipstream(bencher: Bencher<'_, '_>) {
    let file = write_run();
    let path = Path::new("run.mcap");
    let size = size(&encoded_messages(&file));
    bencher
        .counter(size)
        .bench(|| read_mcap_from(&file[..], file.len() as u64, path).unwrap());
}

#[divan::bench]
fn read_mcap_alone(bencher: Bencher<'_, '_>) {
    let file = write_run();
    let size = size(&encoded_messages(&file));
    bencher.counter(size).bench(|| {
        let messages = mcap::MessageStream::new(&file).unwrap();
        messages
            .map(|message| message.unwrap().data.len())
            .sum::<usize>()
    });
}

/// Writing an imported recording: standard messages, and lossless rows where needed.
#[divan::bench]
fn rewrite_slipstream(bencher: Bencher<'_, '_>) {
    let file = write_run();
    let path = Path::new("run.mcap");
    let recording = read_mcap_from(&file[..], file.len() as u64, path)
        .unwrap()
        .recording;
    let size = size(&encoded_messages(&file));
    bencher
        .counter(size)
        .bench(|| mcap_bytes(&recording, path).unwrap());
}
