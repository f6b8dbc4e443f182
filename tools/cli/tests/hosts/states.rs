//! In lockstep the states are those of a run in one process.

use std::time::Duration;

use crate::cable::{ADDRESS, Cable};
use crate::common::programs::example;
use crate::common::{command, read_json, run_json, slipstream};
use crate::{Started, alone, assert_done, hash_alone, is_root, port};

/// Runs an experiment with the robots `b` on one other host, or with `c` on a second one too, and cuts the cable for
/// `cut`. Its hash is that of the run in one process.
fn assert_same(arguments: &[&str], hosts: &[&str], cut: Option<Duration>) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let cable = Cable::new();
    let mut run = vec![
        "run",
        "--listen",
        ADDRESS,
        "--insecure",
        "--json",
        "run.json",
    ];
    run.extend(arguments);
    for host in hosts {
        run.extend(["--host", host]);
    }
    let plant = cable.plant(folder, &run);
    let others: Vec<Started> = hosts
        .iter()
        .map(|host| {
            let (name, _) = host.split_once('=').unwrap();
            let join = ["join", ADDRESS, "--insecure", "--name", name];
            std::thread::sleep(Duration::from_millis(300));
            cable.other(folder, &join)
        })
        .collect();
    if let Some(cut) = cut {
        std::thread::sleep(Duration::from_millis(700));
        cable.set("down");
        std::thread::sleep(cut);
        cable.set("up");
    }
    for other in others {
        assert_done(&other.wait());
    }
    assert_done(&plant.wait());
    let run = read_json(&folder.join("run.json"));
    assert_eq!(
        run["state_hash"],
        hash_alone(folder, arguments),
        "{arguments:?} {hosts:?}"
    );
}

#[test]
fn on_one_computer_the_recording_is_that_of_a_run_without_hosts() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let address = format!("tcp/127.0.0.1:{}", port());
    let run = [
        "run", "--listen", &address, "--host", "b=r2", "--host", "c=r3", "--json", "run.json",
        "--out", "far.mcap",
    ];
    let plant = Started::new(&mut command(folder, &run));
    let join = |name| Started::new(&mut command(folder, &["join", &address, "--name", name]));
    let others = [join("b"), join("c")];
    for other in others {
        let output = other.wait();
        assert_done(&output);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains("in platoon for 15 s as host"), "{said}");
    }
    assert_done(&plant.wait());
    let alone = run_json(folder, &["--out", "near.mcap"]);
    let far = read_json(&folder.join("run.json"));
    for key in ["state_hash", "robots", "links", "lost_records"] {
        assert_eq!(far[key], alone[key], "{key}");
    }
    let hosts: Vec<&str> = far["processes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|process| process["host"].as_str())
        .collect();
    assert_eq!(hosts, ["b", "c"]);
    let answer = |name: &str| {
        let json = format!("{name}.json");
        let output = slipstream(folder, &["trace", &format!("{name}.mcap"), "--json", &json]);
        assert_done(&output);
        let mut answer = read_json(&folder.join(json));
        answer.as_object_mut().unwrap().remove("recording");
        answer
    };
    assert_eq!(answer("far"), answer("near"), "latency, stage by stage");
}

/// A host starts programs that it was given itself, and nothing that another host names.
#[test]
fn programs_of_ones_own_run_on_both_computers() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let address = format!("tcp/127.0.0.1:{}", port());
    let program = example("paper_law");
    let run = [
        "run",
        "--listen",
        &address,
        "--host",
        "b=r2,r4",
        "--json",
        "run.json",
        "--robots",
        "4",
        "--no-recording",
        "--set",
        "links.topology=all",
        "--set",
        "links.protocol=periodic",
        "--agent",
        &program,
    ];
    let plant = Started::new(&mut command(folder, &run));
    let join = ["join", &address, "--name", "b"];
    let refused = slipstream(folder, &join);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("--agent: is missing: the run has"), "{said}");
    drop(plant);
    let address = format!("tcp/127.0.0.1:{}", port());
    let run = run.map(|word| {
        if word.starts_with("tcp/") {
            &address
        } else {
            word
        }
    });
    let plant = Started::new(&mut command(folder, &run));
    let join = ["join", &address, "--name", "b", "--agent", &program];
    assert_done(&Started::new(&mut command(folder, &join)).wait());
    assert_done(&plant.wait());
    let arguments = [
        "--robots",
        "4",
        "--set",
        "links.topology=all",
        "--set",
        "links.protocol=periodic",
    ];
    let run = read_json(&folder.join("run.json"));
    assert_eq!(run["state_hash"], hash_alone(folder, &arguments));
}

#[test]
fn states_are_those_of_one_process() {
    let _one = alone();
    if !is_root() {
        return;
    }
    assert_same(&["--robots", "1"], &["b=r1"], None);
    for protocol in ["ring", "periodic"] {
        let protocol = format!("links.protocol={protocol}");
        let fine = ["--set", &protocol];
        assert_same(&fine, &["b=r2"], None);
        let poor = [
            "--set",
            "links.delay_s=0.08",
            "--set",
            "links.jitter_s=0.04",
            "--set",
            "links.loss=0.1",
        ];
        let poor = [&fine[..], &poor].concat();
        assert_same(&poor, &["b=r1", "c=r2,r3"], None);
        let ten = [&poor[..], &["--robots", "10"]].concat();
        assert_same(&ten, &["b=r2,r3,r7", "c=r5,r6"], None);
    }
}

#[test]
fn a_hundred_robots_on_three_hosts_have_the_states_of_one_process() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let names = |range: std::ops::RangeInclusive<u32>| {
        let names: Vec<String> = range.map(|robot| format!("r{robot}")).collect();
        names.join(",")
    };
    let (b, c) = (
        format!("b={}", names(11..=40)),
        format!("c={}", names(70..=100)),
    );
    let arguments = [
        "--robots",
        "100",
        "--set",
        "duration_s=4",
        "--set",
        "links.delay_s=0.05",
    ];
    assert_same(&arguments, &[&b, &c], None);
}

#[test]
fn a_cable_that_is_cut_for_less_than_the_timeout_changes_nothing() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let arguments = ["--set", "duration_s=300"];
    assert_same(&arguments, &["b=r2,r3"], Some(Duration::from_secs(1)));
    let patient = [&arguments[..], &["--set", "host_timeout_s=40"]].concat();
    assert_same(&patient, &["b=r2,r3"], Some(Duration::from_secs(12)));
}
