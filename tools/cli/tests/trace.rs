//! Latency, stage by stage: what was put into a run is found again in its recording.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::{read_json, run_json, slipstream};
use serde_json::Value;
use slipstream_bus::trace::{self, TraceRecord};
use slipstream_trace::{Fate, Message, follow};

/// Runs a platoon and traces it.
fn traced(folder: &Path, arguments: &[&str]) -> (Value, Value) {
    let run = run_json(folder, &[&["--out", "run.mcap"], arguments].concat());
    let output = slipstream(folder, &["trace", "run.mcap", "--json", "trace.json"]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    (run, read_json(&folder.join("trace.json")))
}

fn stage<'a>(hop: &'a Value, name: &str) -> &'a Value {
    let mut stages = hop["stages"].as_array().unwrap().iter();
    stages.find(|stage| stage["stage"] == name).unwrap()
}

/// Every message of a run in one process.
fn messages(arguments: &[&str]) -> Vec<Message> {
    let folder = tempfile::tempdir().unwrap();
    let mut all = vec!["--in-process", "--out", "run.mcap"];
    all.extend(arguments);
    run_json(folder.path(), &all);
    follow(
        &slipstream_trace::read(&folder.path().join("run.mcap"))
            .unwrap()
            .log,
    )
}

#[test]
fn a_constant_delay_is_found_to_the_nanosecond() {
    for place in [&["--in-process"][..], &[]] {
        let folder = tempfile::tempdir().unwrap();
        let delay = ["--set", "links.delay_s=0.08", "--set", "duration_s=6"];
        let (_, answer) = traced(folder.path(), &[&delay, place].concat());
        let hops = answer["hops"].as_array().unwrap();
        assert_eq!(hops.len(), 3);
        for hop in hops {
            assert!(hop["messages"].as_u64().unwrap() > 5);
            assert_eq!(hop["largest_sum_error_s"], 0.0);
            let injected = stage(hop, "injected_delay");
            for figure in ["p50_s", "p99_s", "max_s"] {
                assert_eq!(injected[figure], 0.08);
            }
            // Outer ticks come every 50 ms: 80 ms are used after 100.
            assert_eq!(stage(hop, "outer_wait")["max_s"], 0.02);
            assert_eq!(stage(hop, "transport")["max_s"], 0.0);
        }
    }
}

/// Chances of all kinds: each message is in one class, and the classes are what the run counted.
#[test]
fn every_message_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.12",
        "--set",
        "links.jitter_s=0.06",
        "--set",
        "links.loss=0.15",
        "--set",
        "links.burst=3",
    ];
    let (run, answer) = traced(folder.path(), &arguments);
    let hops = answer["hops"].as_array().unwrap();
    assert_eq!(hops.len(), 2);
    for (hop, link) in hops.iter().zip(run["links"].as_array().unwrap()) {
        assert_eq!([&hop["from"], &hop["to"]], [&link["from"], &link["to"]]);
        assert_eq!(hop["sent"], link["sent"]);
        let class = |name: &str| hop["incomplete"][name].as_u64().unwrap();
        assert_eq!(class("lost"), link["lost"].as_u64().unwrap());
        // The run counts a stale one as stale also where it came after the last outer tick.
        let stale = class("stale")..=class("stale") + class("under_way");
        assert!(stale.contains(&link["stale"].as_u64().unwrap()));
        assert!(class("lost") > 10 && class("stale") > 0 && class("superseded") > 0);
        assert_eq!(class("untold") + class("receiver_died"), 0);
        let others: u64 = hop["incomplete"]
            .as_object()
            .unwrap()
            .values()
            .map(|n| n.as_u64().unwrap())
            .sum();
        assert_eq!(
            others + hop["messages"].as_u64().unwrap(),
            hop["sent"].as_u64().unwrap()
        );
    }
}

/// The same sums from the records themselves, by plain search.
#[test]
fn the_sums_are_those_of_the_records() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--in-process",
        "--set",
        "links.delay_s=0.08",
        "--set",
        "links.jitter_s=0.03",
    ];
    traced(folder.path(), &arguments);
    let path = folder.path().join("run.mcap");
    let mut records: Vec<TraceRecord<'static>> = Vec::new();
    slipstream_recording::read_trace(&path, &mut |bytes| {
        let piece = Vec::leak(bytes.to_vec());
        trace::read(piece, |record| records.push(record)).is_ok()
    })
    .unwrap();
    let find = |name: &str, fits: &dyn Fn(&TraceRecord<'_>) -> bool, field: &str| {
        let mut records = records.iter();
        let found = records.find(|record| record.name == name && fits(record));
        found.and_then(|record| record.int(field)).unwrap()
    };
    let mut used = 0;
    for message in follow(&slipstream_trace::read(&path).unwrap().log) {
        let Fate::Used(way) = message.fate else {
            continue;
        };
        used += 1;
        let ours = |record: &TraceRecord<'_>| {
            [record.int("from"), record.int("seq")]
                == [message.from, message.seq].map(|number| Some(i64::from(number)))
        };
        let sampled_ns = find("sent", &ours, "sampled_ns");
        let tick_ns = find("taken", &ours, "tick_ns");
        let answers = |record: &TraceRecord<'_>| {
            record.int("robot") == Some(i64::from(message.to))
                && record.int("tick_ns") >= Some(tick_ns)
        };
        let first_torque_ns = find("applied", &answers, "t_ns");
        let stages = way.stages_ns();
        assert!(stages.iter().all(|&stage| stage >= 0), "{message:?}");
        assert_eq!(stages.iter().sum::<i64>(), first_torque_ns - sampled_ns);
    }
    assert!(used > 50, "{used}");
}

/// The largest distance between the delays' distribution and this one, times √n
/// (Kolmogorov–Smirnov: above 1.63 in one of a hundred samples).
fn distance(mut delays_s: Vec<f64>, cdf: impl Fn(f64) -> f64) -> f64 {
    delays_s.sort_by(f64::total_cmp);
    let n = delays_s.len() as f64;
    let gap = |(i, &delay_s): (usize, &f64)| {
        let share = cdf(delay_s);
        (share - i as f64 / n).max((i as f64 + 1.0) / n - share)
    };
    delays_s.iter().enumerate().map(gap).fold(0.0, f64::max) * n.sqrt()
}

/// The normal distribution's share below z, by Simpson's rule.
fn normal(z: f64) -> f64 {
    let density = |z: f64| (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let h = (z + 9.0) / 400.0;
    let piece = |i: i32| {
        let a = -9.0 + f64::from(i) * h;
        (density(a) + 4.0 * density(a + h / 2.0) + density(a + h)) * h / 6.0
    };
    (0..400).map(piece).sum()
}

#[test]
fn each_distribution_is_recovered() {
    let (mean, sd) = (0.2_f64, 0.04_f64);
    let normal_s = |s: f64| normal((s - mean) / sd);
    let uniform_s = |s: f64| ((s - mean) / (12f64.sqrt() * sd) + 0.5).clamp(0.0, 1.0);
    let spread = (1.0 + (sd / mean).powi(2)).ln().sqrt();
    let lognormal_s = |s: f64| normal((s.ln() - mean.ln()) / spread + spread / 2.0);
    let names = ["normal", "uniform", "lognormal"];
    let shares: [&dyn Fn(f64) -> f64; 3] = [&normal_s, &uniform_s, &lognormal_s];
    for (i, name) in names.iter().enumerate() {
        let key = format!("links.distribution={name}");
        let arguments = [
            "--set",
            "links.protocol=periodic",
            "--set",
            "links.delay_s=0.2",
            "--set",
            "links.jitter_s=0.04",
            "--set",
            "duration_s=100",
            "--set",
            &key,
        ];
        let messages = messages(&arguments);
        let delays = messages.iter().filter_map(|message| message.delay_ns);
        let delays_s: Vec<f64> = delays.map(|ns| ns as f64 / 1e9).collect();
        assert!(delays_s.len() > 3900, "{}", delays_s.len());
        for (j, share) in shares.iter().enumerate() {
            let d = distance(delays_s.clone(), share);
            assert_eq!(d < 1.63, i == j, "{name} against {}: {d}", names[j]);
        }
    }
}

#[test]
fn replayed_round_trips_give_their_halves() {
    let rtt_ms = [Some(150.0), Some(163.25), None, Some(40.5), Some(3.000002)];
    let rows = rtt_ms.iter().enumerate();
    let rows: Vec<String> = rows
        .map(|(seq, ms)| {
            format!(
                "{seq},{}",
                ms.map_or(String::new(), |ms: f64| ms.to_string())
            )
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rtt.csv");
    std::fs::write(&file, format!("seq,rtt_ms\n{}\n", rows.join("\n"))).unwrap();
    let key = format!("links.trace={}", file.display());
    let arguments = [
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.reorder=true",
        "--set",
        &key,
        "--set",
        "duration_s=6",
    ];
    let messages = messages(&arguments);
    assert!(messages.len() > 200);
    for message in messages.iter().filter(|message| message.seq < 100) {
        let half_ns =
            rtt_ms[message.seq as usize % rtt_ms.len()].map(|ms| (ms * 5e5).round() as i64);
        assert_eq!(message.delay_ns, half_ns, "{message:?}");
        assert_eq!(message.fate == Fate::Lost, half_ns.is_none(), "{message:?}");
    }
}

/// On the wall clock the delay line counts from sending: what the bus took is part of it.
#[test]
fn on_the_wall_clock_no_stage_is_negative() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--clock",
        "wall",
        "--set",
        "duration_s=3",
        "--set",
        "links.delay_s=0.08",
    ];
    let (_, answer) = traced(folder.path(), &arguments);
    let log = slipstream_trace::read(&folder.path().join("run.mcap"))
        .unwrap()
        .log;
    let mut used = 0;
    for message in follow(&log) {
        if let Fate::Used(way) = message.fate {
            used += 1;
            let stages = way.stages_ns();
            assert!(stages.iter().all(|&stage| stage >= 0), "{message:?}");
            assert_eq!(message.delay_ns, Some(80_000_000));
            assert!(stages[2] + stages[3] >= 80_000_000, "{message:?}");
        }
    }
    assert!(used > 20, "{used}");
    assert_eq!(answer["hops"].as_array().unwrap().len(), 3);
}

/// The delays of a run are replayed from its own export.
#[test]
fn the_circle_closes() {
    let folder = tempfile::tempdir().unwrap();
    let common = [
        "--in-process",
        "--set",
        "links.protocol=periodic",
        "--robots",
        "2",
    ];
    let chances = [
        "--set",
        "links.delay_s=0.12",
        "--set",
        "links.jitter_s=0.05",
        "--set",
        "links.loss=0.1",
    ];
    let log = |name: &str, arguments: &[&str]| {
        run_json(
            folder.path(),
            &[&["--out", name], &common[..], arguments].concat(),
        );
        slipstream_trace::read(&folder.path().join(name))
            .unwrap()
            .log
    };
    let first = log("a.mcap", &chances);
    let output = slipstream(folder.path(), &["trace", "a.mcap", "--rtt", "rtt.csv"]);
    assert!(output.status.success());
    let second = log("b.mcap", &["--set", "links.trace=rtt.csv", "--seed", "9"]);
    let (first, second) = (follow(&first), follow(&second));
    let lost = first
        .iter()
        .filter(|message| message.fate == Fate::Lost)
        .count();
    assert!(first.len() > 250 && lost > 10, "{} {lost}", first.len());
    assert_eq!(first, second);
}

/// Of two runs that differ in the links' delay alone, that stage alone differs: both arrive 20 ms
/// before an outer tick at which an inner one is due, too.
#[test]
fn the_stage_that_changed_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (name, delay) in [
        ("a.mcap", "links.delay_s=0.08"),
        ("b.mcap", "links.delay_s=0.18"),
    ] {
        run_json(
            folder.path(),
            &[
                "--in-process",
                "--out",
                name,
                "--set",
                delay,
                "--set",
                "duration_s=6",
            ],
        );
    }
    let arguments = [
        "trace",
        "b.mcap",
        "--against",
        "a.mcap",
        "--json",
        "trace.json",
        "--report",
        "r.html",
    ];
    let output = slipstream(folder.path(), &arguments);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let answer = read_json(&folder.path().join("trace.json"));
    let hops = answer["against"].as_array().unwrap();
    assert_eq!(hops.len(), 3);
    for hop in hops {
        for change in hop["stages"].as_array().unwrap() {
            let stage = change["stage"].as_str().unwrap();
            let expected = match stage {
                "injected_delay" | "end_to_end" => 0.1,
                _ => 0.0,
            };
            let difference = change["difference_s"].as_f64().unwrap();
            assert!((difference - expected).abs() < 1e-12, "{change}");
            assert_eq!(change["changed"], expected != 0.0, "{change}");
        }
    }
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    // A waterfall and a histogram for each link: constant stages have no histogram.
    assert_eq!(page.matches("<svg").count(), 6);
    assert!(page.contains("180.0000 ms"));
}

/// Each arrow starts, passes and ends where a tick is drawn; each stage that begins ends.
#[test]
fn arrows_of_the_timeline_hang_on_ticks() {
    let folder = tempfile::tempdir().unwrap();
    run_json(
        folder.path(),
        &[
            "--in-process",
            "--out",
            "run.mcap",
            "--set",
            "links.delay_s=0.08",
        ],
    );
    let output = slipstream(
        folder.path(),
        &["trace", "run.mcap", "--perfetto", "p.json"],
    );
    assert!(output.status.success());
    let timeline = read_json(&folder.path().join("p.json"));
    let events = timeline["traceEvents"].as_array().unwrap();
    let of = |ph: &str| {
        events
            .iter()
            .filter(|event| event["ph"] == ph)
            .collect::<Vec<_>>()
    };
    let place = |event: &Value| format!("{} {} {}", event["pid"], event["tid"], event["ts"]);
    let ticks: std::collections::BTreeSet<String> = of("X").into_iter().map(place).collect();
    let (starts, steps, ends) = (of("s"), of("t"), of("f"));
    assert!(starts.len() > 100);
    assert_eq!((steps.len(), ends.len()), (2 * starts.len(), starts.len()));
    for arrow in [starts, steps, ends].concat() {
        assert!(ticks.contains(&place(arrow)), "{arrow}");
    }
    assert_eq!(of("b").len(), of("e").len());
    let processes = of("M")
        .into_iter()
        .filter(|event| event["name"] == "process_name");
    let names: Vec<&str> = processes
        .map(|event| event["args"]["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["plant", "r1", "r2", "r3"]);
}

/// The trace sees and does not touch: with it, without it and at its finest the states are the same.
#[test]
fn the_trace_changes_no_state() {
    let folder = tempfile::tempdir().unwrap();
    let run = |set: &str, filter: Option<&str>, place: &[&str]| {
        let mut arguments = vec!["run", "--json", "result.json", "--out", "run.mcap"];
        arguments.extend([
            "--set",
            "duration_s=6",
            "--set",
            "links.jitter_s=0.05",
            "--set",
            set,
        ]);
        arguments.extend(place);
        let mut command = common::command(folder.path(), &arguments);
        if let Some(filter) = filter {
            command.env("RUST_LOG", filter);
        }
        assert!(command.status().unwrap().success());
        let mut names = std::collections::BTreeSet::new();
        let path = folder.path().join("run.mcap");
        let read = slipstream_recording::read_trace(&path, &mut |bytes| {
            let mut take = |record: TraceRecord<'_>| {
                names.insert(record.name.to_string());
            };
            trace::read(bytes, &mut take).is_ok()
        });
        assert_eq!(read.is_err(), names.is_empty());
        let hash = read_json(&folder.path().join("result.json"))["state_hash"].clone();
        (hash, names)
    };
    let [on, off] = ["recording.trace=true", "recording.trace=false"];
    let (hash, usual) = run(on, None, &[]);
    for name in [
        "outer", "inner", "sent", "arrived", "taken", "applied", "process", "started",
    ] {
        assert!(usual.contains(name), "{name} is missing in {usual:?}");
    }
    assert!(!usual.contains("reference"));
    for place in [&[][..], &["--in-process"]] {
        let (other, none) = run(off, None, place);
        assert_eq!(other, hash);
        assert!(none.is_empty(), "{none:?}");
        let (other, finest) = run(on, Some("slipstream=trace"), place);
        assert_eq!(other, hash);
        assert!(
            finest.contains("reference") && finest.contains("torque"),
            "{finest:?}"
        );
        let (other, coarse) = run(on, Some("slipstream=info"), place);
        assert_eq!(other, hash);
        assert!(!coarse.contains("outer"), "{coarse:?}");
    }
    let output = slipstream(folder.path(), &["trace", "run.mcap"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
}

#[test]
fn a_filter_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for place in [&["run"][..], &["run", "--in-process"]] {
        let mut command = common::command(folder.path(), place);
        let output = command.env("RUST_LOG", "slipstream=loud").output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.contains("RUST_LOG") && stderr.lines().count() == 1,
            "{stderr}"
        );
    }
}

/// An agent that is killed leaves messages that nobody takes up: they are counted as such.
#[test]
fn what_a_dead_agent_did_not_take_up_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run",
        "--clock",
        "wall",
        "--set",
        "duration_s=60",
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.4",
        "--out",
        "run.mcap",
    ];
    let child = common::command(folder.path(), &arguments).spawn().unwrap();
    let mut victim = None;
    common::wait_for("the agents", std::time::Duration::from_secs(20), || {
        let roles = common::roles(child.id());
        let agent = |role: &&common::Role| role.arguments.windows(2).any(|w| w == ["--robot", "1"]);
        victim = roles.iter().find(agent).map(|role| role.pid);
        let recorded = std::fs::metadata(folder.path().join("run.mcap"));
        victim.is_some() && recorded.is_ok_and(|file| file.len() > 20_000)
    });
    let pid = rustix::process::Pid::from_raw(i32::try_from(victim.unwrap()).unwrap()).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::KILL).unwrap();
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(1));
    let output = slipstream(
        folder.path(),
        &["trace", "run.mcap", "--json", "trace.json"],
    );
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let answer = read_json(&folder.path().join("trace.json"));
    let hops = answer["hops"].as_array().unwrap();
    let died = |from: &str| {
        let hop = hops.iter().find(|hop| hop["from"] == from).unwrap();
        hop["incomplete"]["receiver_died"].as_u64().unwrap()
    };
    // 20 messages a second, 0.4 s each under way.
    assert!((4..=20).contains(&died("r1")), "{}", died("r1"));
    assert_eq!(died("r2"), 0);
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.contains("whose receiver died"), "{table}");
    // Every loop is in the answer, the plant's step first.
    let loops = answer["loops"].as_array().unwrap();
    assert_eq!([&loops[0]["process"], &loops[0]["loop"]], ["plant", "step"]);
    assert_eq!(loops.len(), 7);
    for one in loops {
        assert!(one["jitter"]["max_s"].as_f64().unwrap() > 0.0, "{one}");
        assert!(one["missed"].is_u64(), "{one}");
    }
}

/// The missed deadlines of the trace are those that the run counted itself.
#[test]
fn missed_deadlines_are_those_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let (run, answer) = {
        let _load = common::Load::new();
        traced(folder.path(), &["--clock", "wall", "--set", "duration_s=3"])
    };
    for told in run["deadlines"].as_array().unwrap() {
        let mut loops = answer["loops"].as_array().unwrap().iter();
        let same = |one: &&Value| one["process"] == told["process"] && one["loop"] == told["loop"];
        let one = loops.find(same).unwrap();
        let count = |key: &str| one[key].as_u64().unwrap();
        assert_eq!(
            count("ticks") + count("left_out"),
            told["ticks"],
            "{one} {told}"
        );
        assert_eq!(
            count("missed") + count("left_out"),
            told["missed"],
            "{one} {told}"
        );
    }
}

/// Recordings from before the trace had a mark say so in one line.
#[test]
fn an_old_trace_is_refused_with_a_remedy() {
    use slipstream_recording::run_writer::{RunHeader, RunWriter};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mcap");
    let mut writer = RunWriter::create(&path, &RunHeader::default()).unwrap();
    // An inner tick as it used to be: the number of its kind first.
    writer.write_trace(0, &[6, 0, 0, 0, 0]).unwrap();
    writer.finish().unwrap();
    let output = slipstream(folder.path(), &["trace", "old.mcap"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("old.mcap") && stderr.contains("record it again"),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

#[test]
fn what_holds_no_trace_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("no.mcap"), "no").unwrap();
    for (what, why) in [
        ("no.mcap", "MCAP"),
        (".", "folder"),
        ("none.mcap", "No such file"),
    ] {
        let output = slipstream(folder.path(), &["trace", what]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(
            stderr.contains(why) && stderr.lines().count() == 1,
            "{stderr}"
        );
    }
}
