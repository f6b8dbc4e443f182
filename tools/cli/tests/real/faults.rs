//! Whatever fails, every robot stands within `control.watchdog_s` and 50 ms, and is never told more than its limits.

use std::io::Read as _;
use std::process::Child;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use rustix::process::Signal;
use slipstream_ipc::clock::{Monotonic, WallClock};

use crate::common::faults::{count, random_time, signal};
use crate::common::programs::faulty;
use crate::common::{command, read_json, roles, wait_for};
use crate::lab::{LIMITS, Lab, Takes};
use crate::proxy::{self, Cut};

/// `control.watchdog_s`, and the time after which a box stands by itself (s).
const WATCHDOG_S: f64 = 0.4;
/// What is beyond it allowed (s).
const MARGIN_S: f64 = 0.05;
/// The same on a machine that does other things as well, for the short form of the test (s).
const BUSY_MARGIN_S: f64 = 1.0;
/// Labs at the same time.
const AT_ONCE: usize = 3;

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    AgentKilled,
    AgentHung,
    RobotsKilled,
    RobotsHung,
    LauncherKilled,
    Interrupted,
    LinkCut,
    BoxSilent,
    NoNumber,
    /// No fault of a process: an agent wants what no robot can do. The run ends by itself.
    Wild,
}

const FAULTS: [Fault; 10] = [
    Fault::AgentKilled,
    Fault::AgentHung,
    Fault::RobotsKilled,
    Fault::RobotsHung,
    Fault::LauncherKilled,
    Fault::Interrupted,
    Fault::LinkCut,
    Fault::BoxSilent,
    Fault::NoNumber,
    Fault::Wild,
];

#[test]
fn every_fault_leaves_all_robots_standing() {
    let faults = count("SLIPSTREAM_FAULTS", FAULTS.len());
    let margin_s = if faults > FAULTS.len() {
        MARGIN_S
    } else {
        BUSY_MARGIN_S
    };
    let next = AtomicUsize::new(0);
    let found = thread::scope(|scope| {
        let work = || {
            let mut found = Vec::new();
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= faults {
                    return found;
                }
                let fault = FAULTS[number % FAULTS.len()];
                found.push((fault, suffer(fault)));
            }
        };
        let workers: Vec<_> = (0..AT_ONCE).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .flat_map(|own| own.join().unwrap())
            .collect::<Vec<_>>()
    });
    let mut late = 0;
    for fault in FAULTS {
        let own = found.iter().filter(|(other, _)| *other == fault);
        let mut times: Vec<f64> = own.map(|(_, stood_s)| *stood_s).collect();
        times.sort_by(f64::total_cmp);
        let beyond = times
            .iter()
            .filter(|own| **own > WATCHDOG_S + margin_s)
            .count();
        late += beyond;
        let (median, last) = (times.get(times.len() / 2), times.last());
        eprintln!(
            "{fault:?}: {} times, stood after {median:?} s (median), {last:?} s (latest); {beyond} too late",
            times.len()
        );
    }
    assert_eq!(late, 0);
}

/// Lets it fail once. Returns how long the last robot moved after it (s); negative if all stood before.
fn suffer(fault: Fault) -> f64 {
    let cut = Cut::default();
    let timeout = WATCHDOG_S.to_string();
    let arguments = ["--command-timeout-s", &timeout];
    let mut lab = Lab::start(Takes::Twists, &["", ""], "", &arguments, |port| {
        proxy::listen(port, &cut)
    });
    let at_s = 1.0 + random_time(Duration::from_millis(1000)).as_secs_f64();
    let (mut launcher, start_ns) = drive(&lab, fault, at_s);
    let clock = WallClock::new(Monotonic::from_shared(start_ns));
    clock.sleep_until((at_s * 1e9) as i64);
    let failed_ns = match fault {
        Fault::NoNumber => start_ns + (at_s * 1e9) as i64,
        Fault::Wild => start_ns + 3_000_000_000,
        _ => {
            let failed_ns = Monotonic::now().to_shared();
            strike(fault, &launcher, &cut);
            failed_ns
        }
    };
    thread::sleep(Duration::from_secs_f64(WATCHDOG_S + 0.6));
    if fault == Fault::Wild {
        thread::sleep(Duration::from_secs(2));
    }
    end(fault, &mut launcher);
    lab.end_boxes();
    let last_ns = (0..2).filter_map(|robot| {
        let log = lab.log(robot);
        assert!(!log.is_empty(), "{fault:?}: r{} never moved", robot + 1);
        check_limits(fault, &lab, robot);
        let &(t_ns, twist) = log.last()?;
        assert_eq!(twist, [0.0; 2], "{fault:?}: r{} moves", robot + 1);
        Some(t_ns)
    });
    (last_ns.max().unwrap() - failed_ns) as f64 * 1e-9
}

/// Starts a run that drives for three seconds and waits until its time 0 is known (ns of the monotonic clock).
fn drive(lab: &Lab, fault: Fault, at_s: f64) -> (Child, i64) {
    let agent = match fault {
        Fault::NoNumber => format!("r2={} {at_s}", faulty("nan")),
        Fault::Wild => format!("*={} 0.2", faulty("wild")),
        _ => String::new(),
    };
    let watchdog = format!("control.watchdog_s={WATCHDOG_S}");
    let mut all = vec![
        "run",
        "platoon",
        "--clock",
        "wall",
        "--real",
        "robots.toml",
        "--arm",
    ];
    all.extend([
        "--no-recording",
        "--set",
        &watchdog,
        "--set",
        "duration_s=3",
    ]);
    all.extend(["--set", "formation.start_s=0.5"]);
    if !agent.is_empty() {
        all.extend(["--agent", &agent]);
    }
    let mut launcher = command(lab.folder(), &all).spawn().unwrap();
    let mut start_ns = 0;
    wait_for("the start of the run", Duration::from_secs(60), || {
        if let Some(status) = launcher.try_wait().unwrap() {
            let mut said = String::new();
            launcher
                .stderr
                .take()
                .unwrap()
                .read_to_string(&mut said)
                .unwrap();
            panic!("{fault:?}: the run ended before it began, {status}: {said}");
        }
        let Some(role) = roles(launcher.id())
            .into_iter()
            .find(|role| role.is("robots"))
        else {
            return false;
        };
        let page = std::path::Path::new(role.folder()).join("wake_page");
        let page = slipstream_ipc::wake_page::WakePage::open(&page);
        start_ns = page.map_or(0, |page| page.start_ns());
        start_ns != 0
    });
    (launcher, start_ns)
}

/// Lets it happen.
fn strike(fault: Fault, launcher: &Child, cut: &Cut) {
    let process = |name: &str| {
        let processes = roles(launcher.id());
        processes.iter().find(|role| role.is(name)).unwrap().pid
    };
    match fault {
        Fault::AgentKilled => signal(process("r1"), Signal::KILL),
        Fault::AgentHung => signal(process("r2"), Signal::STOP),
        Fault::RobotsKilled => signal(process("robots"), Signal::KILL),
        Fault::RobotsHung => signal(process("robots"), Signal::STOP),
        Fault::LauncherKilled => signal(launcher.id(), Signal::KILL),
        Fault::Interrupted => signal(launcher.id(), Signal::INT),
        Fault::LinkCut => {
            cut.down.store(true, Ordering::Relaxed);
            cut.up.store(true, Ordering::Relaxed);
        }
        Fault::BoxSilent => cut.up.store(true, Ordering::Relaxed),
        Fault::NoNumber | Fault::Wild => {}
    }
}

/// Ends the launcher.
fn end(fault: Fault, launcher: &mut Child) {
    wait_for(
        &format!("the end of a run with {fault:?}"),
        Duration::from_secs(30),
        || launcher.try_wait().unwrap().is_some(),
    );
}

/// What a box was told is within its limits, and follows each other within them.
fn check_limits(fault: Fault, lab: &Lab, robot: usize) {
    let seen = read_json(&lab.file(&format!("r{}.json", robot + 1)));
    let number = |key: &str, place: usize| seen[key][place].as_f64().unwrap();
    for place in 0..2 {
        let largest = number("largest", place);
        assert!(largest <= LIMITS[place], "{fault:?}: {seen}");
        // Two periods of the outer loop at most.
        let step = LIMITS[2 + place] * 0.1 + 1e-9;
        assert!(number("largest_step", place) <= step, "{fault:?}: {seen}");
    }
}
