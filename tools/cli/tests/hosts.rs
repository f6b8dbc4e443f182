//! Runs across hosts as a user starts them. The hosts are two network namespaces with a cable between them; the second
//! has a time namespace whose monotonic clock is 1,000 s ahead.
//!
//! Needs the feature `hosts` (`just hosts`); the tests with namespaces need root.
#![cfg(feature = "hosts")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use common::{command, read_json, run_json, slipstream, wait_for};

/// Time in which a host ends after another has failed, with `host_timeout_s` at its default of 3 s.
const LIMIT: Duration = Duration::from_secs(5);

fn is_root() -> bool {
    let root = rustix::process::geteuid().is_root();
    if !root {
        eprintln!("SKIPPED: needs root");
    }
    root
}

fn ip(arguments: &str) {
    let status = Command::new("ip").args(arguments.split(' ')).status();
    assert!(status.unwrap().success(), "ip {arguments}");
}

/// The tests run one after the other: one of them kills processes that it finds by name.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A free port of this computer.
fn port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

/// Two network namespaces, `a` with 10.77.0.1 and `b` with 10.77.0.2.
struct Cable {
    a: String,
    b: String,
}

impl Cable {
    fn new() -> Self {
        static CABLES: AtomicU32 = AtomicU32::new(0);
        let number = CABLES.fetch_add(1, Ordering::Relaxed);
        let name = |end: char| format!("ss{}{number}{end}", std::process::id());
        let (a, b) = (name('a'), name('b'));
        ip(&format!("netns add {a}"));
        ip(&format!("netns add {b}"));
        ip(&format!(
            "link add va netns {a} type veth peer name vb netns {b}"
        ));
        for (name, end, address) in [(&a, "va", "10.77.0.1/24"), (&b, "vb", "10.77.0.2/24")] {
            ip(&format!("-n {name} addr add {address} dev {end}"));
            ip(&format!("-n {name} link set {end} up"));
            ip(&format!("-n {name} link set lo up"));
        }
        Self { a, b }
    }

    /// Cuts the cable, or mends it.
    fn set(&self, state: &str) {
        ip(&format!("-n {} link set vb {state}", self.b));
    }

    /// Starts slipstream on the plant's host.
    fn plant(&self, folder: &Path, arguments: &[&str]) -> Child {
        start(folder, &["ip", "netns", "exec", &self.a], arguments)
    }

    /// Starts slipstream on the other host, whose clock is 1,000 s ahead.
    fn other(&self, folder: &Path, arguments: &[&str]) -> Child {
        let ahead = [
            "unshare",
            "--time",
            "--monotonic",
            "1000",
            "--fork",
            "--kill-child",
        ];
        let namespace = ["ip", "netns", "exec", &self.b];
        start(folder, &[&namespace[..], &ahead].concat(), arguments)
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        for name in [&self.a, &self.b] {
            let _ = Command::new("ip").args(["netns", "del", name]).status();
        }
    }
}

/// Starts slipstream with `arguments`, behind the words of `before`.
fn start(folder: &Path, before: &[&str], arguments: &[&str]) -> Child {
    let mut command = Command::new(before[0]);
    command
        .args(&before[1..])
        .arg(env!("CARGO_BIN_EXE_slipstream"))
        .args(arguments)
        .current_dir(folder)
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command.spawn().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_done(output: &Output) {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
}

/// The state hash of the run in one process.
fn hash_alone(folder: &Path, arguments: &[&str]) -> String {
    let alone = run_json(
        folder,
        &[arguments, &["--in-process", "--no-recording"]].concat(),
    );
    alone["state_hash"].as_str().unwrap().to_owned()
}

/// Runs an experiment with the robots `b` on one other host, or with `c` on a second one too, and cuts the cable for
/// `cut`. Its hash is that of the run in one process.
fn assert_same(arguments: &[&str], hosts: &[&str], cut: Option<Duration>) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let cable = Cable::new();
    let mut run = vec![
        "run",
        "--listen",
        "tcp/10.77.0.1:7447",
        "--insecure",
        "--json",
        "run.json",
    ];
    run.extend(arguments);
    for host in hosts {
        run.extend(["--host", host]);
    }
    let plant = cable.plant(folder, &run);
    let others: Vec<Child> = hosts
        .iter()
        .map(|host| {
            let (name, _) = host.split_once('=').unwrap();
            let join = ["join", "tcp/10.77.0.1:7447", "--insecure", "--name", name];
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
        assert_done(&other.wait_with_output().unwrap());
    }
    assert_done(&plant.wait_with_output().unwrap());
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
    let plant = command(folder, &run).spawn().unwrap();
    let join = |name| {
        command(folder, &["join", &address, "--name", name])
            .spawn()
            .unwrap()
    };
    let others = [join("b"), join("c")];
    for other in others {
        let output = other.wait_with_output().unwrap();
        assert_done(&output);
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(said.contains("in platoon for 15 s as host"), "{said}");
    }
    assert_done(&plant.wait_with_output().unwrap());
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
fn a_cable_that_is_cut_for_a_second_changes_nothing() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let arguments = ["--set", "duration_s=300"];
    assert_same(&arguments, &["b=r2,r3"], Some(Duration::from_secs(1)));
}

/// A run that goes on for long, with the robots r2 and r3 on the other host. Returns the plant's host and the other.
fn long_run(cable: &Cable, folder: &Path) -> (Child, Child) {
    let plant = cable.plant(
        folder,
        &[
            "run",
            "--listen",
            "tcp/10.77.0.1:7447",
            "--insecure",
            "--host",
            "b=r2,r3",
            "--no-recording",
            "--set",
            "duration_s=100000",
        ],
    );
    std::thread::sleep(Duration::from_millis(300));
    let join = ["join", "tcp/10.77.0.1:7447", "--insecure", "--name", "b"];
    let other = cable.other(folder, &join);
    std::thread::sleep(Duration::from_millis(1500));
    (plant, other)
}

/// Pid of the process of the other host with these arguments.
fn pid_of(pattern: &str) -> u32 {
    let mut pid = None;
    wait_for(pattern, Duration::from_secs(5), || {
        let output = Command::new("pgrep")
            .args(["-f", pattern])
            .output()
            .unwrap();
        pid = String::from_utf8_lossy(&output.stdout)
            .lines()
            .last()
            .and_then(|own| own.parse().ok());
        pid.is_some()
    });
    pid.unwrap()
}

fn signal(pid: u32, name: &str) {
    let status = Command::new("kill").args([name, &pid.to_string()]).status();
    assert!(status.unwrap().success());
}

fn assert_fails(child: Child, since: Instant, said: &[&str]) {
    let output = child.wait_with_output().unwrap();
    let (text, taken) = (stderr(&output), since.elapsed());
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(taken < LIMIT, "{taken:?}: {text}");
    for said in said {
        assert!(text.contains(said), "{said}: {text}");
    }
}

#[test]
fn a_host_that_dies_or_stands_still_ends_the_run_in_words_on_both_sides() {
    let _one = alone();
    if !is_root() {
        return;
    }
    type Harm = fn(&Cable);
    let cases: [(Harm, &[&str], &[&str]); 5] = [
        (
            |_| signal(pid_of("slipstream agent .*--robot 2"), "-KILL"),
            &["host b: r3 (pid", "was killed by signal 9"],
            &["r3 (pid", "was killed by signal 9"],
        ),
        (
            |_| signal(pid_of("slipstream relay"), "-KILL"),
            &["host b: its process is gone"],
            &["relay (pid", "was killed by signal 9"],
        ),
        (
            |_| signal(pid_of("slipstream relay"), "-STOP"),
            &["host b: "],
            &["relay (pid"],
        ),
        (
            |_| signal(pid_of("slipstream hosts"), "-KILL"),
            &["hosts (pid", "was killed by signal 9"],
            &["the plant's host: its run is gone"],
        ),
        (
            |cable| cable.set("down"),
            &["host b: it has been silent for 3."],
            &["the plant's host: it has been silent for 3."],
        ),
    ];
    for (harm, at_plant, at_other) in cases {
        let folder = tempfile::tempdir().unwrap();
        let cable = Cable::new();
        let (plant, other) = long_run(&cable, folder.path());
        let begin = Instant::now();
        harm(&cable);
        assert_fails(plant, begin, at_plant);
        assert_fails(other, begin, at_other);
    }
}

#[test]
fn certificates_of_the_run_are_accepted_and_all_others_refused() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["keys", "other-keys"] {
        assert_done(&slipstream(folder, &["keys", name]));
    }
    let again = slipstream(folder, &["keys", "keys"]);
    assert_eq!(again.status.code(), Some(2), "{}", stderr(&again));
    let cable = Cable::new();
    let address = "tcp/10.77.0.1:7447";
    let run = [
        "run", "--listen", address, "--tls", "keys", "--host", "b=r2", "--json", "run.json",
    ];
    let plant = cable.plant(folder, &run);
    std::thread::sleep(Duration::from_millis(500));
    for (protection, said) in [
        (
            &["--tls", "other-keys"][..],
            "give both hosts the same folder of slipstream keys",
        ),
        (&["--insecure"], "tcp/10.77.0.1:7447"),
        (&[], "leaves this computer without protection"),
    ] {
        let join = [&["join", address, "--name", "b"][..], protection].concat();
        let output = cable.other(folder, &join).wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(
            stderr(&output).contains(said),
            "{said}: {}",
            stderr(&output)
        );
    }
    let join = ["join", address, "--name", "b", "--tls", "keys"];
    assert_done(&cable.other(folder, &join).wait_with_output().unwrap());
    assert_done(&plant.wait_with_output().unwrap());
    let run = read_json(&folder.join("run.json"));
    assert_eq!(run["state_hash"], hash_alone(folder, &[]));
    std::fs::write(folder.join("keys/valid-until"), "1000000000").unwrap();
    let expired = slipstream(folder, &["join", address, "--name", "b", "--tls", "keys"]);
    assert_eq!(expired.status.code(), Some(2));
    assert!(
        stderr(&expired).contains("has certificates that expired"),
        "{}",
        stderr(&expired)
    );
}

/// Asserts that slipstream refuses arguments with exit code 2 and a sentence.
#[track_caller]
fn assert_refused(folder: &Path, arguments: &[&str], said: &str) {
    let begin = Instant::now();
    let output = slipstream(folder, arguments);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(text.contains(said), "{arguments:?}: {said}: {text}");
    assert!(begin.elapsed() < Duration::from_secs(10), "{arguments:?}");
}

/// A stand-in for ssh that runs the command here: it keeps the arguments, and in place of a tunnel puts the address where
/// the tunnel would lead.
const SSH: &str = r#"#!/bin/sh
echo "$@" >> ssh-arguments
for last; do :; done
tunnel=$(echo "$*" | sed 's/.* -R \([0-9]*\):\([^ ]*\) .*/s#127.0.0.1:\1#\2#/')
command=$(echo "$last" | sed "$tunnel")
PATH=$JOIN_PATH exec sh -c "$command"
"#;

/// Runs with `slipstream join` started over ssh, which finds slipstream in `path`.
fn run_over_ssh(folder: &Path, path: &Path) -> Output {
    let bin = folder.join("bin");
    std::fs::create_dir_all(&bin).unwrap();
    std::fs::write(bin.join("ssh"), SSH).unwrap();
    std::fs::set_permissions(bin.join("ssh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let paths = |first: &Path| format!("{}:/usr/bin:/bin", first.display());
    command(
        folder,
        &[
            "run",
            "--host",
            "b=r2,r3",
            "--ssh",
            "b=robot@lab-2",
            "--json",
            "run.json",
            "--no-recording",
        ],
    )
    .env("PATH", paths(&bin))
    .env("JOIN_PATH", paths(path))
    .output()
    .unwrap()
}

#[test]
fn a_host_is_started_over_ssh() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let program = Path::new(env!("CARGO_BIN_EXE_slipstream"));
    assert_done(&run_over_ssh(folder, program.parent().unwrap()));
    let run = read_json(&folder.join("run.json"));
    assert_eq!(run["state_hash"], hash_alone(folder, &[]));
    let arguments = std::fs::read_to_string(folder.join("ssh-arguments")).unwrap();
    assert!(
        arguments.contains("ExitOnForwardFailure=yes -R "),
        "{arguments}"
    );
    assert!(arguments.contains(":127.0.0.1:"), "{arguments}");
    assert!(
        arguments.contains("robot@lab-2 slipstream join tcp/127.0.0.1:"),
        "{arguments}"
    );
    let begin = Instant::now();
    let output = run_over_ssh(folder, Path::new("/nowhere"));
    assert_eq!(output.status.code(), Some(1));
    let text = stderr(&output);
    assert!(
        text.contains("host b: ssh robot@lab-2: ")
            && text.contains("slipstream must be in the PATH"),
        "{text}"
    );
    assert!(begin.elapsed() < LIMIT);
}

#[test]
fn what_cannot_be_joined_or_listened_at_is_said() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let free = format!("tcp/127.0.0.1:{}", port());
    assert_refused(
        folder,
        &["join", "nowhere", "--name", "b"],
        "is not an address",
    );
    assert_refused(
        folder,
        &["join", &free, "--name", "b c"],
        "is not the name of a host",
    );
    assert_refused(
        folder,
        &["join", &free, "--name", "b"],
        "nobody listens there",
    );
    assert_refused(
        folder,
        &["join", "tcp/192.0.2.1:7447", "--name", "b"],
        "leaves this computer",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r9"],
        "has no robot \"r9\"",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--host", "c=r2"],
        "names r2 again",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--host", "b=r3"],
        "names b again",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "r2"],
        "is not a host with its robots",
    );
    assert_refused(
        folder,
        &[
            "run", "--listen", &free, "--host", "b=r2", "--clock", "wall",
        ],
        "virtual clock only",
    );
    assert_refused(
        folder,
        &["run", "--listen", "tcp/0.0.0.0:1", "--host", "b=r2"],
        "leaves this computer",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--tls", "none"],
        "has no authority.pem",
    );
}

#[test]
fn a_port_that_is_taken_and_a_host_that_is_not_waited_for_are_refused() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let free = format!("tcp/127.0.0.1:{}", port());
    // A port that somebody else listens at, and a run that waits for others.
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp/{}", taken.local_addr().unwrap());
    let output = slipstream(
        folder,
        &[
            "run",
            "--listen",
            &address,
            "--host",
            "b=r2",
            "--no-recording",
        ],
    );
    assert_ne!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains(&address), "{}", stderr(&output));
    let run = [
        "run",
        "--listen",
        &free,
        "--host",
        "b=r2",
        "--no-recording",
        "--set",
        "duration_s=100000",
    ];
    let plant = command(folder, &run).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert_refused(
        folder,
        &["join", &free, "--name", "d"],
        "the run waits for no host d, but for b",
    );
    let mut other = command(folder, &["join", &free, "--name", "b"])
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert_refused(
        folder,
        &["join", &free, "--name", "b"],
        "a host b has joined already",
    );
    signal(plant.id(), "-INT");
    let output = plant.wait_with_output().unwrap();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{text}");
    for said in [
        "refused a host that asked to join: the run waits for no host d",
        "refused a host that asked to join: a host b has joined already",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
    let begin = Instant::now();
    assert_eq!(other.wait().unwrap().code(), Some(1));
    assert!(begin.elapsed() < LIMIT);
}
