//! A recording across hosts, in words, JSON, timeline and page: robot r1 beside the plant, r2 on host b.

use std::borrow::Cow;
use std::path::Path;

use serde_json::Value as Json;
use slipstream_bus::trace::{CallSite, Entry, FORMAT, RecordData, Value};
use slipstream_recording::run_writer::{RunHeader, RunWriter};

use crate::common::{read_json, slipstream};

/// A record: process, name, begin and end (ns), fields.
type Record = (
    &'static str,
    &'static str,
    i64,
    Option<i64>,
    Vec<(&'static str, Value<'static>)>,
);

fn ints<const N: usize>(fields: [(&'static str, i64); N]) -> Vec<(&'static str, Value<'static>)> {
    let fields = fields.into_iter();
    fields
        .map(|(name, value)| (name, Value::Int(value)))
        .collect()
}

fn text(name: &'static str, value: &'static str) -> (&'static str, Value<'static>) {
    (name, Value::Text(value.into()))
}

/// What the processes record of the message `seq`, which needs 0.1 ms plus `extra_ns` in the network. The
/// clock of b is 0.15 ms ahead.
fn message(seq: i64, extra_ns: i64) -> Vec<Record> {
    let at = |ms: f64| seq * 50_000_000 + (ms * 1e6) as i64;
    let on_b = |ms: f64| at(ms) + 150_000 + extra_ns;
    let (due_ns, message) = (at(0.0), [("from", 0), ("to", 1), ("seq", seq)]);
    let [from, to, seq_field] = message;
    let tick = |robot, extra| ints([("robot", robot), ("due_ns", due_ns), extra]);
    let mut taken = ints([from, to, seq_field, ("tick_ns", due_ns)]);
    taken.push(text("fate", "used"));
    let sent = [("sampled_ns", at(0.1)), ("tick_ns", due_ns)];
    let [sampled, of_tick] = sent;
    let [sent, queued] = [("sent_ns", at(0.3)), ("queued_ns", at(0.31))];
    let sent = ints([from, to, seq_field, sampled, of_tick, sent, queued]);
    let applied = [("robot", 1), ("tick_ns", due_ns)];
    vec![
        ("r1", "outer", at(0.2), Some(at(0.3)), tick(0, ("other", 0))),
        ("r1", "sent", at(0.3), None, sent),
        ("relay", "crossed", on_b(0.4), None, ints(message)),
        (
            "r2",
            "arrived",
            on_b(3.4),
            None,
            ints([from, to, seq_field, ("available_ns", on_b(3.4))]),
        ),
        ("r2", "taken", due_ns, None, taken),
        (
            "r2",
            "outer",
            on_b(4.0),
            Some(on_b(4.1)),
            tick(1, ("message", seq)),
        ),
        (
            "r2",
            "inner",
            on_b(4.2),
            Some(on_b(4.3)),
            tick(1, ("outer_ns", due_ns)),
        ),
        ("plant", "applied", at(4.3) + extra_ns, None, ints(applied)),
    ]
}

/// What the host of the plant records of the clock of b, which it knows to 0.2 ms.
fn clocks() -> Vec<Record> {
    let clock = |second: i64| {
        let mut fields = ints([
            ("offset_ns", 1_000_000_000_123_400 + 12_000 * second),
            ("bound_ns", 50_000),
            ("round_trip_ns", 95_000),
            ("error_ns", 200_000),
        ]);
        fields.push(text("host", "b"));
        fields.extend((second > 0).then_some(("drift_ppb", Value::Int(12_000))));
        ("hosts", "clock", second * 1_000_000_000, None, fields)
    };
    (-1..6).map(clock).collect()
}

/// Writes a recording of 100 messages.
fn write(path: &Path, extra_ns: i64, clocks: Vec<Record>) {
    let mut host = ints([("robot", 1)]);
    host.push(text("host", "b"));
    let mut records: Vec<Record> = vec![
        ("hosts", "host", -1_000_000_000, None, host),
        ("relay", "ready", -1_000_000_000, None, Vec::new()),
    ];
    records.extend(clocks);
    records.extend((0..100).flat_map(|seq| message(seq, extra_ns)));
    let mut chunk = vec![FORMAT];
    let mut entry = |entry: &Entry<'_>| chunk.extend(postcard::to_stdvec(entry).unwrap());
    let mut before_ns = 0;
    for (call_site, (process, name, begin_ns, end_ns, fields)) in (0..).zip(records) {
        entry(&Entry::CallSite(CallSite {
            process: process.into(),
            level: 4,
            name: name.into(),
            fields: fields.iter().map(|(name, _)| Cow::from(*name)).collect(),
        }));
        let values = fields.into_iter().map(|(_, value)| value);
        entry(&Entry::Record(RecordData {
            call_site,
            since_previous_ns: begin_ns - before_ns,
            duration_ns: end_ns.map(|end_ns| end_ns - begin_ns),
            fields: (0..).zip(values).collect(),
        }));
        before_ns = begin_ns;
    }
    let mut writer = RunWriter::create(path, &RunHeader::default()).unwrap();
    writer.write_trace(0, &chunk).unwrap();
    writer.finish().unwrap();
}

/// Runs `slipstream trace` with these arguments; what it prints, and what it warns of.
fn trace(folder: &Path, arguments: &[&str]) -> [String; 2] {
    let output = slipstream(folder, &[&["trace"], arguments].concat());
    let [out, err] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(output.status.success(), "{err}");
    [out.into_owned(), err.into_owned()]
}

/// The line of a table that begins with these words.
fn line<'a>(text: &'a str, begin: &str) -> &'a str {
    let line = text
        .lines()
        .find(|line| line.trim_start().starts_with(begin));
    line.unwrap_or_else(|| panic!("no {begin} in {text}"))
}

#[test]
fn the_table_says_what_the_clocks_leave_open() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("run.mcap"), 0, clocks());
    let [table, warnings] = trace(folder.path(), &["run.mcap"]);
    assert_eq!(warnings, "");
    assert!(
        table.contains("max (ms)  ± of p50, by the clocks (ms)"),
        "{table}"
    );
    let transport = "0.250      0.250      0.250       ± 0.2000";
    assert!(line(&table, "transport").ends_with(transport), "{table}");
    // The torque is applied 0.1 ms after the tick, which b stamps 0.15 ms too late.
    let apply_wait =
        "-0.0500    -0.0500    -0.0500       ± 0.2000 (less than the clocks tell apart)";
    assert!(line(&table, "apply_wait").ends_with(apply_wait), "{table}");
    for exact in ["sample_wait", "compute", "injected_delay", "end to end"] {
        assert!(!line(&table, exact).contains('±'), "{table}");
    }
    assert!(
        line(&table, "end to end").ends_with(" 4.20       4.20       4.20"),
        "{table}"
    );
    let age = "4.05       4.05       4.05       ± 0.2000";
    assert!(line(&table, "r1, used by r2").contains("4.20"), "{table}");
    assert!(table.lines().any(|line| line.ends_with(age)), "{table}");
    let mut host = line(&table, "b ").split_whitespace();
    let figures = [
        "1000000.0001834",
        "12.000",
        "0.0500",
        "0.2000",
        "0.0950",
        "7",
        "r2",
    ];
    assert!(host.by_ref().skip(1).eq(figures), "{table}");
    let units = [
        "offset (s)",
        "drift (ppm)",
        "bound (ms)",
        "error (ms)",
        "round trip (ms)",
    ];
    assert!(
        units
            .iter()
            .all(|unit| line(&table, "host ").contains(unit)),
        "{table}"
    );
}

#[test]
fn a_clock_that_is_not_recorded_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("run.mcap"), 0, Vec::new());
    let [table, warnings] = trace(folder.path(), &["run.mcap", "--against", "run.mcap"]);
    let own = "run.mcap: holds no estimate of the clock of host b: how wrong its time stamps are is unknown";
    assert_eq!(
        warnings.lines().filter(|line| line.contains(own)).count(),
        2,
        "{warnings}"
    );
    assert!(line(&table, "transport").ends_with("± unknown"), "{table}");
    assert!(!line(&table, "compute").contains('±'), "{table}");
    let host = line(&table, "b ").split_whitespace();
    assert_eq!(host.filter(|word| *word == "unknown").count(), 5, "{table}");
    assert!(table.contains("(error of a clock unknown)"), "{table}");
}

/// A run whose network needs 0.3 ms more is within the error of the clocks; 0.5 ms more are a change.
#[test]
fn against_knows_the_clocks_of_both_runs() {
    let folder = tempfile::tempdir().unwrap();
    write(&folder.path().join("a.mcap"), 0, clocks());
    for (extra_ns, changed) in [(300_000, ""), (500_000, "changed")] {
        write(&folder.path().join("b.mcap"), extra_ns, clocks());
        let arguments = ["b.mcap", "--against", "a.mcap", "--json", "b.json"];
        let [table, _] = trace(folder.path(), &arguments);
        let answer = read_json(&folder.path().join("b.json"));
        let stages = answer["against"][0]["stages"].as_array().unwrap();
        let transport = stages
            .iter()
            .find(|stage| stage["stage"] == "transport")
            .unwrap();
        assert_eq!(transport["changed"], !changed.is_empty(), "{transport}");
        assert_eq!(
            stages[7]["changed"], true,
            "both ends of the chain are on the plant's host"
        );
        let low = extra_ns as f64 / 1e6 - 0.4;
        let line = table
            .lines()
            .rfind(|line| line.contains("transport"))
            .unwrap();
        assert!(
            line.contains(&format!("({low:+.4} … ")) && line.ends_with(changed),
            "{line}"
        );
    }
}

#[test]
fn the_json_conforms_and_timeline_and_page_have_the_hosts() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write(&path("run.mcap"), 0, clocks());
    write(&path("other.mcap"), 0, Vec::new());
    let files = [
        "--json",
        "a.json",
        "--perfetto",
        "p.json",
        "--report",
        "r.html",
    ];
    trace(
        folder.path(),
        &[&["run.mcap", "--against", "other.mcap"], &files[..]].concat(),
    );
    let schema = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/trace.schema.json");
    let schema = jsonschema::validator_for(&read_json(&schema)).unwrap();
    let violations = |answer: &Json| {
        let errors = schema.iter_errors(answer);
        errors
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect::<Vec<_>>()
    };
    let mut answer = read_json(&path("a.json"));
    assert_eq!(violations(&answer), Vec::<String>::new());
    assert_eq!(answer["hops"][0]["stages"][2]["uncertainty_s"], 0.0002);
    let host = serde_json::json!({
        "host": "b", "robots": ["r2"], "windows": 7, "offset_s": 1_000_000.000_183_4,
        "drift_ppm": 12.0, "bound_s": 5e-5, "error_s": 0.0002, "round_trip_s": 9.5e-5,
    });
    assert_eq!(answer["hosts"], serde_json::json!([host]));
    assert_eq!(answer["against"][0]["stages"][2]["ci95_s"], Json::Null);
    answer["hosts"][0]["windows"] = "many".into();
    assert_eq!(violations(&answer).len(), 1);
    // The clocks are no instants of the timeline; what the relay says stands on a track of its own.
    let timeline = read_json(&path("p.json"));
    let events = timeline["traceEvents"].as_array().unwrap();
    let named = |name: &str| {
        events
            .iter()
            .filter(|event| event["name"] == name)
            .collect::<Vec<_>>()
    };
    assert!(
        ["clock", "host", "crossed"]
            .iter()
            .all(|name| named(name).is_empty())
    );
    let processes = named("process_name");
    let names: Vec<_> = processes
        .iter()
        .map(|event| event["args"]["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["plant", "relay", "r2"]);
    assert_eq!(named("ready")[0]["pid"], processes[1]["pid"]);
    let page = std::fs::read_to_string(path("r.html")).unwrap();
    assert!(page.contains("Clocks of the other hosts") && page.contains("± clocks"));
    assert!(!page.contains("width:-"));
}
