//! Programs of one's own as agents: the same states as the built-in controller, parameters, topologies, and what is said when
//! one goes wrong.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::programs::{example, example_in_c, faulty};
use common::{run_json, slipstream};
use serde_json::Value;

/// Runs of the built-in controller whose states programs have to reproduce.
const RUNS: [&[&str]; 5] = [
    &[],
    &["--set", "links.protocol=periodic"],
    &[
        "--set",
        "links.delay_s=0.1",
        "--set",
        "links.jitter_s=0.03",
        "--set",
        "links.loss=0.1",
    ],
    &["--robots", "20"],
    &[
        "--robots",
        "20",
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.1",
        "--set",
        "links.jitter_s=0.03",
        "--set",
        "links.loss=0.1",
    ],
];

fn state_hash(folder: &Path, arguments: &[&str]) -> Value {
    run_json(folder, &[arguments, &["--no-recording"]].concat())["state_hash"].take()
}

#[test]
fn the_papers_law_has_the_same_states_as_a_program_in_rust_and_in_c() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let programs = [example("paper_law"), example_in_c("paper_law", folder)];
    for run in RUNS {
        let built_in = state_hash(folder, run);
        for program in &programs {
            let own = [run, &["--agent", program]].concat();
            assert_eq!(state_hash(folder, &own), built_in, "{run:?} {program}");
        }
    }
    // One robot alone, and one that has the built-in controller beside programs.
    let built_in = state_hash(folder, &[]);
    let one = format!("r2={}", programs[0]);
    assert_eq!(state_hash(folder, &["--agent", &one]), built_in);
    let all_but_one = ["--agent", &programs[1], "--agent", "r2="];
    assert_eq!(state_hash(folder, &all_but_one), built_in);
}

#[test]
fn an_experiment_names_programs_beside_itself_and_their_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::create_dir(folder.join("lab")).unwrap();
    std::fs::copy(example("paper_law"), folder.join("lab/law")).unwrap();
    let text =
        "[agents]\n\"*\" = \"./law\"\n[controller.\"*\"]\nk_x = 2\n[controller.r3]\nk_x = 0.5\n";
    std::fs::write(folder.join("lab/mine.toml"), text).unwrap();
    let listed = slipstream(folder, &["run", "lab/mine.toml", "--dry-run"]);
    let listed = String::from_utf8(listed.stdout).unwrap();
    let line = |key: &str| {
        let found = listed
            .lines()
            .find(|line| line.starts_with(&format!("{key} = ")));
        found
            .unwrap_or_default()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ")
    };
    assert_eq!(
        line("controller.r2.k_x"),
        "controller.r2.k_x = 2.0 # lab/mine.toml:4"
    );
    assert_eq!(
        line("controller.r3.k_x"),
        "controller.r3.k_x = 0.5 # lab/mine.toml:6"
    );
    assert_eq!(
        line("controller.r3.k_y"),
        "controller.r3.k_y = 15.0 # default of ./law"
    );
    // Parameters for all are for all that have a program.
    let one = ["--agent", "r2=lab/law", "--set", "controller.*.k_x=1"];
    assert_eq!(state_hash(folder, &one), state_hash(folder, &[]));
    let own = state_hash(folder, &["lab/mine.toml", "--set", "controller.r3.k_x=2"]);
    assert_eq!(own, state_hash(folder, &["--set", "control.k_x=2"]));
}

#[test]
fn robots_that_all_hear_each_other_spread_around_a_circle() {
    let folder = tempfile::tempdir().unwrap();
    let program = example("consensus");
    let run = [
        "--agent",
        &program,
        "--robots",
        "5",
        "--set",
        "links.topology=all",
    ];
    let more = [
        "--set",
        "links.protocol=periodic",
        "--set",
        "links.delay_s=0.05",
        "--set",
        "duration_s=90",
    ];
    let out = ["--out", "circle.mcap"];
    let result = run_json(folder.path(), &[&run[..], &more, &out].concat());
    let links = result["links"].as_array().unwrap();
    assert_eq!(links.len(), 20);
    assert!(links.iter().all(|link| link["sent"] == 1800));
    let angle = |robot: &Value| {
        let pose = &robot["final_odometry"];
        let [x, y] = [0, 1].map(|i| pose[i].as_f64().unwrap());
        y.atan2(x).to_degrees()
    };
    let angles: Vec<f64> = result["robots"]
        .as_array()
        .unwrap()
        .iter()
        .map(angle)
        .collect();
    for pair in angles.windows(2) {
        let between = (pair[1] - pair[0]).rem_euclid(360.0);
        assert!((between - 72.0).abs() < 2.0, "{angles:?}");
    }
    let trace = slipstream(
        folder.path(),
        &["trace", "circle.mcap", "--json", "trace.json"],
    );
    assert!(trace.status.success());
    let trace = common::read_json(&folder.path().join("trace.json"));
    let hops = trace["hops"].as_array().unwrap();
    assert_eq!(hops.len(), 20);
    for hop in hops {
        assert!(hop["messages"].as_u64().unwrap() > 1790, "{hop}");
        assert_eq!(hop["largest_sum_error_s"], 0.0);
        assert_eq!(hop["stages"][3]["p50_s"], 0.05);
    }
}

#[test]
fn links_of_other_topologies_are_those_of_their_name() {
    let folder = tempfile::tempdir().unwrap();
    for (topology, protocol, links) in [
        ("predecessor", "periodic", "r1>r2 r2>r3 r3>r4"),
        ("predecessor", "ring", "r1>r2 r2>r3 r3>r4 r4>r1"),
        (
            "leader_predecessor",
            "periodic",
            "r1>r2 r1>r3 r1>r4 r2>r3 r3>r4",
        ),
        (
            "two_predecessors",
            "ring",
            "r1>r2 r1>r3 r2>r3 r2>r4 r3>r4 r4>r1",
        ),
        ("ring", "periodic", "r1>r2 r2>r3 r3>r4 r4>r1"),
        (
            "r1>r2 r2>r3 r3>r4 r4>r2",
            "periodic",
            "r1>r2 r2>r3 r3>r4 r4>r2",
        ),
    ] {
        let topology = format!("links.topology={topology}");
        let protocol = format!("links.protocol={protocol}");
        let run = [
            "--robots",
            "4",
            "--no-recording",
            "--set",
            &topology,
            "--set",
            &protocol,
        ];
        let result = run_json(folder.path(), &run);
        let name = |link: &Value| {
            assert!(link["delivered"].as_u64().unwrap() > 0, "{link}");
            let [from, to] = ["from", "to"].map(|end| link[end].as_str().unwrap());
            format!("{from}>{to}")
        };
        let found: Vec<String> = result["links"]
            .as_array()
            .unwrap()
            .iter()
            .map(name)
            .collect();
        assert_eq!(found.join(" "), links);
        let in_process = run_json(folder.path(), &[&run[..], &["--in-process"]].concat());
        assert_eq!(result["state_hash"], in_process["state_hash"]);
        assert_eq!(result["links"], in_process["links"]);
    }
}

/// What a run with this program for r2 says, and its exit code. Nothing of it is left.
fn failure(folder: &Path, program: &str, more: &[&str]) -> (String, Option<i32>) {
    let agent = format!("r2={program}");
    let run = [
        "run",
        "--no-recording",
        "--agent",
        &agent,
        "--set",
        "watchdog_s=1",
    ];
    let output = slipstream(folder, &[&run[..], more].concat());
    assert_eq!(common::faults::processes_in(folder), [0; 0], "{program}");
    let said = String::from_utf8(output.stderr).unwrap();
    (said, output.status.code())
}

#[test]
fn a_program_that_goes_wrong_is_told_with_robot_and_time() {
    let folder = tempfile::tempdir().unwrap();
    for (fault, expected) in [
        (
            "error",
            "its outer loop failed at 3.250 s: the gain is lost",
        ),
        (
            "nan",
            "its outer loop failed at 3.250 s: it gave v = NaN m/s, w = 0 rad/s",
        ),
        (
            "torque",
            "its inner loop failed at 3.220 s: it gave torques of",
        ),
        (
            "no torque",
            "its inner loop failed at 3.220 s: it gave torques of NaN and 0 N m",
        ),
        (
            "panic",
            "its controller panicked at 3.250 s: index out of order (tools/cli/tests/programs/faulty_agent.rs:",
        ),
        ("exit", "ended with exit code 3 at 3.2"),
        ("leave", "ended by itself at 3.2"),
        ("hang", "hangs at 3.2"),
    ] {
        let (said, code) = failure(folder.path(), &faulty(fault), &[]);
        let first = said.lines().next().unwrap_or_default();
        assert!(first.starts_with("slipstream: r2 (pid "), "{fault}: {said}");
        assert!(first.contains(expected), "{fault}: {said}");
        assert!(first.contains("faulty_agent"), "{fault}: {said}");
        assert_eq!(code, Some(1), "{fault}: {said}");
    }
}

#[test]
fn a_program_that_is_no_agent_is_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let old = format!(
        "#!/bin/sh\nshift 3\nexec {} agent --protocol 0.0.1/1 \"$@\"\n",
        example("paper_law")
    );
    std::fs::write(folder.join("old.sh"), old).unwrap();
    let law = example("paper_law");
    for (program, more, expected) in [
        (
            "true",
            &[][..],
            "the program of r2 (true): ended with exit code 0 and described no controller",
        ),
        (
            "./nowhere",
            &[],
            "the program of r2 (./nowhere): is not found",
        ),
        (
            "sh old.sh",
            &[],
            "its program is of another version of slipstream",
        ),
        (
            &faulty("refuse"),
            &[],
            "there is no such law; correct the program",
        ),
        (
            &law,
            &["--set", "controller.r2.gain=1"],
            "--set controller.r2.gain=1: controller.r2.gain is no parameter of the controller of r2",
        ),
        (
            &law,
            &["--set", "controller.*.k_x=fast"],
            "controller.*.k_x is not a number",
        ),
        (&law, &["--in-process"], "--in-process: has no processes"),
        (
            &law,
            &["--agent", "r7=true"],
            "agents.r7 names no robot of the run",
        ),
    ] {
        let (said, code) = failure(folder, program, more);
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with("slipstream: "), "{program}: {said}");
        assert!(last.contains(expected), "{program}: {said}");
        assert_eq!(code, Some(2), "{program}: {said}");
    }
}

/// Cooperative adaptive cruise control is string stable where the paper's law is not: speeds do not grow along the platoon.
#[test]
fn a_sweep_compares_a_law_of_ones_own_with_the_papers() {
    let folder = tempfile::tempdir().unwrap();
    let values = format!("agents.*=,{}", example("cacc"));
    let sweep = [
        "study",
        "sweep",
        "--robots",
        "6",
        "--set",
        &values,
        "--set",
        "links.delay_s=0,0.1",
    ];
    let more = [
        "--set",
        "controller.*.headway_s=0.5,1",
        "--json",
        "sweep.json",
    ];
    let output = slipstream(folder.path(), &[&sweep[..], &more].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.starts_with("agents.*"), "{table}");
    assert_eq!(table.lines().count(), 9, "{table}");
    let sweep = common::read_json(&folder.path().join("sweep.json"));
    let points = sweep["points"].as_array().unwrap();
    let gain = |point: &Value| point["speed_gain"].as_f64().unwrap();
    let (paper, cacc): (Vec<_>, Vec<_>) =
        points.iter().partition(|own| own["set"]["agents.*"] == "");
    assert_eq!((paper.len(), cacc.len()), (4, 4));
    assert!(paper.iter().all(|own| gain(own) > 1.1), "{paper:?}");
    assert!(cacc.iter().all(|own| gain(own) < 1.06), "{cacc:?}");
}

/// The commands of the page that need what cargo builds, word by word. The Python tests have the others.
#[test]
fn the_page_on_own_controllers_shows_this_study() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/how-to/my-controller.md");
    let page = std::fs::read_to_string(page).unwrap();
    let begin = page.find("$ slipstream study sweep --robots 6").unwrap();
    let (block, _) = page[begin..].split_once("```").unwrap();
    let (command, shown) = block.split_once('\n').unwrap();
    let arguments: Vec<&str> = command.split_whitespace().skip(2).collect();
    let folder = tempfile::tempdir().unwrap();
    let examples = folder.path().join("target/release/examples");
    std::fs::create_dir_all(&examples).unwrap();
    std::os::unix::fs::symlink(example("cacc"), examples.join("cacc")).unwrap();
    let output = slipstream(folder.path(), &arguments);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), shown);
}
