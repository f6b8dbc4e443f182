//! Benchmarks of a run against a lower bound for the machine: `just bench`.
//!
//! Compare only numbers of the same table: they are measured together, in one run of this program.
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark may stop at the first error"
)]

mod agents;
mod events;
mod latency;
mod lockstep;
#[path = "../../tests/common/programs.rs"]
#[expect(dead_code, reason = "tests use more of it")]
mod programs;
mod trace;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use slipstream_ipc::clock::{Deadlines, Monotonic, RealTime, WallClock};
use slipstream_launch::{Request, in_process, resolve};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    match arguments.get(1).map(String::as_str) {
        Some("minimal-agent") => lockstep::minimal_agent(Path::new(&arguments[2]), &arguments[3]),
        Some("link-agent") => lockstep::link_agent(Path::new(&arguments[2]), &arguments[3]),
        Some("event-agent") => events::agent(Path::new(&arguments[2]), &arguments[3]),
        Some("lockstep") => lockstep::measure(),
        Some("trace") => trace::measure(),
        Some("agents") => agents::measure(),
        Some("echo") => latency::echo(&arguments[2], Path::new(&arguments[3])),
        _ => {
            lockstep::measure();
            latency::measure();
            start_up();
            real_time_factors();
            deadlines();
            memory();
            in_process_rate();
            trace::measure();
            agents::measure();
        }
    }
}

/// Starts this program in another role.
fn spawn_self(arguments: &[&str]) -> std::process::Child {
    Command::new(std::env::current_exe().unwrap())
        .args(arguments)
        .spawn()
        .unwrap()
}

/// Runs `slipstream run` and reads the JSON that it writes.
fn run(folder: &Path, arguments: &[&str]) -> Value {
    let status = Command::new(env!("CARGO_BIN_EXE_slipstream"))
        .current_dir(folder)
        .args(["run", "--json", "result.json"])
        .args(arguments)
        .stdout(Stdio::null())
        .status()
        .unwrap();
    assert!(status.success());
    serde_json::from_str(&std::fs::read_to_string(folder.join("result.json")).unwrap()).unwrap()
}

fn number(result: &Value, key: &str) -> f64 {
    result[key].as_f64().unwrap()
}

/// The smallest of several measurements, which other work on the machine disturbs least.
fn best(count: u32, measure: impl FnMut(u32) -> f64) -> f64 {
    (0..count).map(measure).fold(f64::INFINITY, f64::min)
}

fn start_up() {
    println!("\nStart-up until all processes are connected; whole run of 1 ms (ms)");
    let folder = tempfile::tempdir().unwrap();
    for robots in ["3", "10", "100"] {
        let measure = |key: &str| {
            best(3, |_| {
                let arguments = ["--robots", robots, "--set", "duration_s=0.001"];
                number(&run(folder.path(), &arguments), key) * 1e3
            })
        };
        println!(
            "{robots:>6} {:8.1} {:8.1}",
            measure("start_up_s"),
            measure("wall_s")
        );
    }
}

fn real_time_factors() {
    println!("\nReal-time factor of the simulation loop, platoon: with recording, without");
    let folder = tempfile::tempdir().unwrap();
    for robots in ["3", "10", "100"] {
        let factor = |more: &[&str]| {
            let arguments = [&["--robots", robots], more].concat();
            15.0 / best(5, |_| number(&run(folder.path(), &arguments), "loop_s"))
        };
        println!(
            "{robots:>6} {:8.0} {:8.0}",
            factor(&[]),
            factor(&["--no-recording"])
        );
    }
}

/// The plant's loop of 1 kHz on the wall clock, compared with a loop that only sleeps.
fn deadlines() {
    const SECONDS: i64 = 15;
    println!(
        "\nWall clock, {SECONDS} s at 1 kHz: missed steps, latest wake-up (ms), real-time scheduling"
    );
    let folder = tempfile::tempdir().unwrap();
    let duration = format!("duration_s={SECONDS}");
    let result = run(folder.path(), &["--clock", "wall", "--set", &duration]);
    let plant = &result["deadlines"][0];
    let (missed, latest_ms) = (
        plant["missed"].as_u64().unwrap(),
        number(plant, "latest_s") * 1e3,
    );
    println!(
        " plant {missed:6} {latest_ms:8.2} {}",
        result["real_time"]["fifo"]
    );
    let missed: u64 = result["deadlines"]
        .as_array()
        .unwrap()
        .iter()
        .skip(1)
        .map(|loops| loops["missed"].as_u64().unwrap())
        .sum();
    println!("agents {missed:6}");
    // In a thread of its own, so that only this thread gets real-time scheduling.
    let (deadlines, fifo) = std::thread::spawn(move || {
        let fifo = RealTime::request(30).fifo;
        let clock = WallClock::new(Monotonic::now());
        let mut deadlines = Deadlines::default();
        for due_ns in (1..=SECONDS * 1000).map(|k| k * 1_000_000) {
            clock.sleep_until(due_ns);
            let now_ns = clock.now_ns();
            deadlines.count(due_ns, now_ns, now_ns, 1_000_000);
        }
        (deadlines, fifo)
    })
    .join()
    .unwrap();
    let latest_ms = deadlines.latest_ns as f64 / 1e6;
    println!(" sleep {:6} {latest_ms:8.2} {fifo}", deadlines.missed);
}

/// Memory of the plant and of an agent during a run, from /proc.
fn memory() {
    println!("\nMemory, [resident, anonymous] (MB): plant, agent");
    let folder = tempfile::tempdir().unwrap();
    for robots in ["3", "100"] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_slipstream"))
            .current_dir(folder.path())
            .args(["run", "--robots", robots, "--set", "duration_s=100000"])
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        let children = format!("/proc/{0}/task/{0}/children", child.id());
        let pids = std::fs::read_to_string(children).unwrap();
        let pids: Vec<&str> = pids.split_whitespace().collect();
        let [plant, agent] = [pids[0], pids[2]].map(|pid| [mb(pid, "VmRSS"), mb(pid, "RssAnon")]);
        println!("{robots:>6} {plant:5.1?} {agent:5.1?}");
        let pid = i32::try_from(child.id()).unwrap();
        let pid = rustix::process::Pid::from_raw(pid).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
        child.wait().unwrap();
    }
}

/// A memory size from /proc/PID/status (MB).
fn mb(pid: &str, key: &str) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find(|line| line.starts_with(key)).unwrap();
    line.split_whitespace()
        .nth(1)
        .unwrap()
        .parse::<f64>()
        .unwrap()
        / 1024.0
}

fn in_process_rate() {
    println!("\nRuns of 15 s in one process, per second on one core: with state hash, without");
    let experiment = resolve(&Request::default()).unwrap().experiment;
    let rate = |hashing| {
        1.0 / best(20, |_| {
            let begin = Instant::now();
            in_process::run(&experiment, hashing).unwrap();
            begin.elapsed().as_secs_f64()
        })
    };
    println!("{:15.0} {:8.0}", rate(true), rate(false));
}
