//! The stages of each link: an injected delay is found again, and nothing else.

use serde_json::Value;
use slipstream_trace::{Fate, follow};

use crate::common::{read_json, run_json, slipstream};
use crate::helpers::traced;

/// The stage of this name of a link.
fn stage<'a>(hop: &'a Value, name: &str) -> &'a Value {
    let mut stages = hop["stages"].as_array().unwrap().iter();
    stages.find(|stage| stage["stage"] == name).unwrap()
}

#[test]
fn a_constant_delay_is_found_to_the_nanosecond() {
    for mode in [&["--in-process"][..], &[]] {
        let folder = tempfile::tempdir().unwrap();
        let delay = ["--set", "links.delay_s=0.08", "--set", "duration_s=6"];
        let (_, answer) = traced(folder.path(), &[&delay, mode].concat());
        let hops = answer["hops"].as_array().unwrap();
        assert_eq!(hops.len(), 3);
        for hop in hops {
            assert!(hop["messages"].as_u64().unwrap() > 5);
            assert_eq!(hop["largest_sum_error_s"], 0.0);
            let injected = stage(hop, "injected_delay");
            for figure in ["p50_s", "p99_s", "max_s"] {
                assert_eq!(injected[figure], 0.08);
            }
            // Outer ticks come every 50 ms: a message delayed by 80 ms is used after 100 ms.
            assert_eq!(stage(hop, "outer_wait")["max_s"], 0.02);
            assert_eq!(stage(hop, "transport")["max_s"], 0.0);
        }
    }
}

/// On the wall clock the delay counts from the time of sending, so that it includes the transport.
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
        if let Fate::Used(chain) = message.fate {
            used += 1;
            let stages = chain.stages_ns();
            assert!(stages.iter().all(|&stage| stage >= 0), "{message:?}");
            assert_eq!(message.delay_ns, Some(80_000_000));
            assert!(stages[2] + stages[3] >= 80_000_000, "{message:?}");
        }
    }
    assert!(used > 20, "{used}");
    assert_eq!(answer["hops"].as_array().unwrap().len(), 3);
}

/// Two runs that differ only in the delay of the links differ only in that stage. In both, messages arrive
/// 20 ms before an outer tick that coincides with an inner tick.
#[test]
fn against_finds_the_stage_that_changed() {
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
    // The delay of each run, and the age of the position that each follower uses.
    assert!(page.contains("Beside the other run") && page.contains("Link delay, set"));
    assert_eq!(page.matches("class=\"fr\"").count(), 2);
    let hops = answer["hops"].as_array().unwrap().iter();
    let mut totals: Vec<f64> = hops
        .map(|hop| {
            let mean_s = |own: &Value| own["mean_s"].as_f64().unwrap();
            let sum: f64 = hop["stages"].as_array().unwrap().iter().map(mean_s).sum();
            let total = mean_s(&hop["end_to_end"]);
            // means of whole nanoseconds: what is left is the rounding of their sum
            assert!((sum - total).abs() < 1e-12, "{sum} {total}");
            1000.0 * total
        })
        .collect();
    totals.sort_by(f64::total_cmp);
    let sentence = format!(
        "A position takes {:.0} ms from encoder to torque",
        totals[1]
    );
    assert!(page.contains(&sentence), "{sentence}");
}
