//! On the wall clock the clocks of the hosts are known, and latencies between hosts are measured.

use std::path::Path;
use std::time::Duration;

use slipstream_bus::time::NS_PER_S;
use slipstream_bus::trace;
use slipstream_recording::read_trace;
use slipstream_trace::{Fate, STAGES, follow};

use crate::cable::{ADDRESS, Cable};
use crate::common::{read_json, slipstream};
use crate::failures::pid_of;
use crate::{Started, alone, assert_done, is_root, signal, stderr};

/// Starts a run of three robots with r2 and r3 on other hosts. Returns the plant's host and the others.
fn start(cable: &Cable, folder: &Path, settings: &[&str]) -> (Started, [Started; 2]) {
    let mut run = vec![
        "run",
        "--clock",
        "wall",
        "--listen",
        ADDRESS,
        "--insecure",
        "--host",
        "b=r2",
        "--host",
        "c=r3",
        "--json",
        "run.json",
        "--out",
        "run.mcap",
    ];
    for setting in settings {
        run.extend(["--set", setting]);
    }
    let plant = cable.plant(folder, &run);
    std::thread::sleep(Duration::from_millis(300));
    let join = |name| cable.other(folder, &["join", ADDRESS, "--insecure", "--name", name]);
    (plant, ["b", "c"].map(join))
}

/// Runs and expects that all hosts are done.
fn run(folder: &Path, settings: &[&str], meanwhile: impl FnOnce(&Cable)) {
    let cable = Cable::new();
    let (plant, others) = start(&cable, folder, settings);
    meanwhile(&cable);
    others.map(Started::wait).iter().for_each(assert_done);
    assert_done(&plant.wait());
    assert_eq!(read_json(&folder.join("run.json"))["lost_records"], 0);
}

/// What the recording holds of the clocks: offset, bound and error (ns).
fn clocks(recording: &Path) -> Vec<[i64; 3]> {
    let mut clocks = Vec::new();
    read_trace(recording, &mut |bytes| {
        let each = |record: trace::TraceRecord<'_>| {
            if record.name == "clock" {
                let fields = ["offset_ns", "bound_ns", "error_ns"];
                clocks.push(fields.map(|name| record.int(name).unwrap()));
            }
        };
        trace::read(bytes, each).is_ok()
    })
    .unwrap();
    clocks
}

#[test]
fn the_known_offset_is_within_the_bound_in_every_second_and_every_sum_is_exact() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["duration_s=53", "links.delay_s=0.02"], |_| {});
    let recording = folder.join("run.mcap");
    let clocks = clocks(&recording);
    assert!(clocks.len() >= 100, "{}", clocks.len());
    let mut largest_ns = [0; 2];
    for [offset_ns, bound_ns, error_ns] in &clocks {
        let off_ns = (offset_ns - 1000 * NS_PER_S).abs();
        assert!(off_ns <= *bound_ns, "{off_ns} {bound_ns}");
        assert!(bound_ns <= error_ns, "{bound_ns} {error_ns}");
        largest_ns = [largest_ns[0].max(off_ns), largest_ns[1].max(*bound_ns)];
    }
    let [off_ns, bound_ns] = largest_ns;
    println!(
        "{} windows: off by {off_ns} ns at most, largest bound {bound_ns} ns",
        clocks.len()
    );

    let reading = slipstream_trace::read(&recording).unwrap();
    let mut used = 0;
    for message in follow(&reading.log) {
        // The delay counts in the time of the plant's host, whatever the network takes.
        assert_eq!(
            message.delay_ns.unwrap_or(20_000_000),
            20_000_000,
            "{message:?}"
        );
        if let Fate::Used(chain) = message.fate {
            used += 1;
            assert_eq!(chain.stages_ns().iter().sum::<i64>(), chain.end_to_end_ns());
        }
    }
    assert!(used > 500, "{used}");
    let answer = slipstream_trace::answer(&reading.log, &reading.robots);
    let uncertain: Vec<Vec<&str>> = answer
        .hops
        .iter()
        .map(|hop| {
            assert_eq!(hop.largest_sum_error_s, 0.0);
            let stages = hop
                .stages
                .iter()
                .filter(|stage| !stage.uncertainty_s.is_exact());
            stages.map(|stage| &*stage.stage).collect()
        })
        .collect();
    let [sample_wait, _, transport, _, _, _, apply_wait] = STAGES;
    assert_eq!(
        uncertain,
        [
            vec![transport, apply_wait],
            vec![sample_wait, transport, apply_wait],
            vec![sample_wait, transport]
        ]
    );
    let shown = slipstream(folder, &["trace", "run.mcap"]);
    assert_done(&shown);
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(text.contains("Clocks of the other hosts"), "{text}");
}

#[test]
fn a_cut_of_a_second_makes_positions_late_and_loses_some() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let settings = ["duration_s=8", "links.protocol=periodic"];
    run(folder.path(), &settings, |cable| {
        std::thread::sleep(Duration::from_secs(3));
        cable.set("down");
        std::thread::sleep(Duration::from_secs(1));
        cable.set("up");
    });
    let reading = slipstream_trace::read(&folder.path().join("run.mcap")).unwrap();
    let answer = slipstream_trace::answer(&reading.log, &reading.robots);
    let longest_s = answer.platoon.iter().map(|age| age.figures.max_s);
    let longest_s = longest_s.fold(0.0, f64::max);
    assert!(longest_s > 0.5, "{answer:?}");
    let run = read_json(&folder.path().join("run.json"));
    let links = run["links"].as_array().unwrap();
    assert_eq!((links.len(), answer.hops.len()), (2, 2));
    for (hop, link) in answer.hops.iter().zip(links) {
        assert_eq!(hop.largest_sum_error_s, 0.0);
        assert!(hop.messages > 50, "{hop:?}");
        // The summary and the trace count what the network lost in different ways.
        assert_eq!(link["lost"], hop.incomplete.lost, "{hop:?}");
    }
}

#[test]
fn a_run_goes_on_without_a_host_that_dies() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let cable = Cable::new();
    let settings = ["duration_s=6", "on_death=continue"];
    let (plant, [b, c]) = start(&cable, folder.path(), &settings);
    std::thread::sleep(Duration::from_secs(3));
    signal(pid_of("slipstream relay .*--name c"), "-KILL");
    let c = c.wait();
    assert_eq!(c.status.code(), Some(1), "{}", stderr(&c));
    assert_done(&b.wait());
    let plant = plant.wait();
    let text = stderr(&plant);
    assert_eq!(plant.status.code(), Some(1), "{text}");
    for said in ["host c: its process is gone", "the run goes on without r3"] {
        assert!(text.contains(said), "{said}: {text}");
    }
    let run = read_json(&folder.path().join("run.json"));
    assert_eq!(run["duration_s"], 6.0);
    let robots = run["robots"].as_array().unwrap();
    let lost: Vec<bool> = robots
        .iter()
        .map(|robot| robot["final_odometry"].is_null())
        .collect();
    assert_eq!(lost, [false, false, true]);
}
