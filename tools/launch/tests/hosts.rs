//! A lockstep across hosts gives the states and reports of the run in one process, bit for bit, also over a network
//! that loses frames. Here all hosts are on one machine, each with shared memory of its own, and the network is a
//! pair of channels.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use slipstream_agents::NodeReport;
use slipstream_agents::process as agent;
use slipstream_bus::experiment::Protocol;
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_hosts::carrier::{Event, HostCarrier, PlantCarrier};
use slipstream_hosts::frame::{decode, encode};
use slipstream_hosts::hello::{Hello, RemoteHost, Welcome};
use slipstream_hosts::relay::Relay;
use slipstream_hosts::stand_in::{StandIn, StandInOutcome};
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::run_directory::{RunDirectory, RunLock};
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_launch::in_process;
use slipstream_sim::run::process as plant;

const VERSION: &str = "0.1.0 (test)";

/// A network that loses frames: one of `loses`, if that is not 0, and all while it is cut.
#[derive(Debug, Clone, Copy)]
struct Weather {
    loses: u32,
    /// Number of the frame at which the network is cut, and for how long.
    cut: Option<(u32, Duration)>,
}

const FINE: Weather = Weather {
    loses: 0,
    cut: None,
};

/// Decides which frames arrive.
struct Gate {
    weather: Weather,
    state: u32,
    frames: u32,
    cut_until: Option<Instant>,
}

impl Gate {
    fn new(weather: Weather) -> Self {
        Self {
            weather,
            state: 1,
            frames: 0,
            cut_until: None,
        }
    }

    fn passes(&mut self) -> bool {
        self.frames += 1;
        if let Some((frame, duration)) = self.weather.cut
            && frame == self.frames
        {
            self.cut_until = Some(Instant::now() + duration);
        }
        // A linear congruential generator.
        self.state = self
            .state
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let is_lost =
            self.weather.loses > 0 && (self.state >> 16).is_multiple_of(self.weather.loses);
        let is_cut = self.cut_until.is_some_and(|until| Instant::now() < until);
        !is_lost && !is_cut
    }
}

struct Home {
    events: Receiver<Event>,
    hosts: BTreeMap<String, Sender<Vec<u8>>>,
    gate: Gate,
}

impl PlantCarrier for Home {
    fn send(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError> {
        if self.gate.passes() {
            let _ = self.hosts[host].send(frame.to_vec());
        }
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Event>, BusError> {
        Ok(self.events.recv_timeout(timeout).ok())
    }
}

struct Away {
    name: String,
    frames: Receiver<Vec<u8>>,
    home: Sender<Event>,
    gate: Gate,
}

impl HostCarrier for Away {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        let (host, bytes) = (self.name.clone(), frame.to_vec());
        if self.gate.passes() {
            let _ = self.home.send(Event::Frame { host, bytes });
        }
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError> {
        Ok(self.frames.recv_timeout(timeout).ok())
    }
}

impl Away {
    /// Asks to join as `name`.
    fn ask(&self, version: &str, name: &str) -> Result<Welcome, String> {
        let (version, name) = (version.to_owned(), name.to_owned());
        let hello = encode(&Hello { version, name }).unwrap();
        let (sender, answers) = channel();
        let answer = Box::new(move |answer: Result<&[u8], &str>| {
            let _ = sender.send(answer.map(<[u8]>::to_vec).map_err(str::to_owned));
        });
        self.home.send(Event::Hello { hello, answer }).unwrap();
        answers.recv().unwrap().map(|bytes| decode(&bytes).unwrap())
    }
}

/// The shared memory of a host.
struct Host {
    directory: RunDirectory,
    page: WakePage,
    _lock: RunLock,
}

impl Host {
    fn new(experiment: &Experiment, local: Option<&[RobotIndex]>) -> Self {
        static HOSTS: AtomicU32 = AtomicU32::new(0);
        let number = HOSTS.fetch_add(1, Ordering::Relaxed);
        let identity = 0xd000_0000 | (std::process::id() & 0xf_ffff) << 8 | number;
        let (directory, lock) = RunDirectory::create(identity).unwrap();
        let bytes = postcard::to_allocvec(experiment).unwrap();
        std::fs::write(directory.experiment(), bytes).unwrap();
        let page = WakePage::create(&directory.wake_page(), experiment.robots.len()).unwrap();
        if let Some(local) = local {
            page.set_local(local);
        }
        Self {
            directory,
            page,
            _lock: lock,
        }
    }

    /// Starts the agents of these robots.
    fn agents<'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        robots: &[RobotIndex],
    ) -> Vec<(RobotIndex, ScopedJoinHandle<'scope, NodeReport>)> {
        let start = |&robot: &RobotIndex| {
            let folder = self.directory.folder();
            let run = move || agent::run(folder, Parent::now(), robot, false, false).unwrap();
            (robot, scope.spawn(move || run().report))
        };
        robots.iter().map(start).collect()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // If a test fails in one thread, the others end.
        self.page.stop();
        self.page.advance(Stage::Over);
        let _ = self.directory.remove();
    }
}

fn experiment(robots: u32, change: impl Fn(&mut Settings)) -> Experiment {
    let mut settings = Settings {
        duration_s: 4.0,
        ..Settings::default()
    };
    settings.robots.count = robots;
    change(&mut settings);
    settings.validate().unwrap();
    Experiment::new(settings, &RobotModel::paper_with_slip())
}

/// Runs an experiment with the agents of `hosts` on other hosts. Returns the state hash and the reports of all agents.
fn run_across(
    experiment: &Experiment,
    hosts: &[(&str, &[RobotIndex])],
    weather: Weather,
) -> (String, Vec<NodeReport>) {
    let remote: Vec<RemoteHost> = hosts
        .iter()
        .map(|&(name, robots)| RemoteHost {
            name: name.to_owned(),
            robots: robots.to_vec(),
        })
        .collect();
    let elsewhere = |robot: &RobotIndex| remote.iter().any(|host| host.robots.contains(robot));
    let all = 0..experiment.settings.robots.count;
    let here: Vec<RobotIndex> = all.filter(|robot| !elsewhere(robot)).collect();
    let (to_home, events) = channel();
    let mut home = Home {
        events,
        hosts: BTreeMap::new(),
        gate: Gate::new(weather),
    };
    let mut carriers = Vec::new();
    for host in &remote {
        let (sender, frames) = channel();
        home.hosts.insert(host.name.clone(), sender);
        carriers.push(Away {
            name: host.name.clone(),
            frames,
            home: to_home.clone(),
            gate: Gate::new(weather),
        });
    }
    let at_home = Host::new(experiment, None);
    let away: Vec<Host> = remote
        .iter()
        .map(|host| Host::new(experiment, Some(&host.robots)))
        .collect();
    thread::scope(|scope| {
        let folder = at_home.directory.folder();
        let plant = scope.spawn(move || plant::run(folder, Parent::now(), false).unwrap());
        let stand_in = StandInThread {
            folder,
            remote: &remote,
        };
        let stand_in = scope.spawn(move || stand_in.run(home));
        let mut agents = at_home.agents(scope, &here);
        let mut relays = Vec::new();
        for ((host, carrier), remote) in away.iter().zip(carriers).zip(&remote) {
            let welcome = carrier.ask(VERSION, &remote.name).unwrap();
            assert_eq!(welcome.robots, remote.robots);
            assert_eq!(
                welcome.experiment,
                postcard::to_allocvec(experiment).unwrap()
            );
            let mut carrier = carrier;
            relays.push(scope.spawn(move || {
                let relay = Relay {
                    folder: host.directory.folder(),
                    launcher: Parent::now(),
                    run: welcome.run,
                    left: &|_| Vec::new(),
                    failure: &|| None,
                };
                relay.run(&mut carrier).unwrap()
            }));
            agents.extend(host.agents(scope, &remote.robots));
        }
        agents.sort_by_key(|(robot, _)| *robot);
        let reports = agents.into_iter().map(|(_, agent)| agent.join().unwrap());
        let reports: Vec<NodeReport> = reports.collect();
        // What the launcher of a host does once its agents have ended.
        away.iter()
            .for_each(|host| host.page.advance(Stage::Drained));
        let outcome = plant.join().unwrap();
        assert_eq!(outcome.ended, ProcessStatus::Done);
        assert_eq!(stand_in.join().unwrap().ended, ProcessStatus::Done);
        for relay in relays {
            assert_eq!(relay.join().unwrap().ended, ProcessStatus::Done);
        }
        (outcome.report.state_hash, reports)
    })
}

struct StandInThread<'a> {
    folder: &'a std::path::Path,
    remote: &'a [RemoteHost],
}

impl StandInThread<'_> {
    fn run(&self, mut home: Home) -> StandInOutcome {
        let stand_in = StandIn {
            folder: self.folder,
            launcher: Parent::now(),
            hosts: self.remote,
            version: VERSION,
            run: 7,
            keys: String::new(),
            recording: false,
            keep: &|_, _, _| {},
        };
        stand_in.run(&mut home).unwrap()
    }
}

#[track_caller]
fn assert_same(experiment: &Experiment, hosts: &[(&str, &[RobotIndex])], weather: Weather) {
    let alone = in_process::run(experiment, true).unwrap();
    let (hash, reports) = run_across(experiment, hosts, weather);
    assert_eq!(hash, alone.plant.state_hash);
    assert_eq!(reports, alone.agents);
}

#[test]
fn one_other_host_changes_nothing() {
    assert_same(&experiment(1, |_| {}), &[("b", &[0])], FINE);
    let ring = experiment(3, |s| s.links.protocol = Protocol::Ring);
    assert_same(&ring, &[("b", &[1, 2])], FINE);
    let periodic = experiment(3, |s| {
        s.links.protocol = Protocol::Periodic;
        s.links.delay_s = 0.08;
        s.links.jitter_s = 0.05;
        s.links.loss = 0.1;
    });
    assert_same(&periodic, &[("b", &[0, 1, 2])], FINE);
}

#[test]
fn two_other_hosts_change_nothing() {
    let ring = experiment(10, |s| s.links.delay_s = 0.03);
    // Neighbours on one host, on two hosts, and with the plant; the robots of a group on all of them.
    assert_same(&ring, &[("b", &[1, 2, 6, 9]), ("c", &[3, 5, 7])], FINE);
}

#[test]
fn lost_frames_and_a_cut_change_nothing() {
    let experiment = experiment(3, |s| s.links.jitter_s = 0.02);
    let hosts: &[(&str, &[RobotIndex])] = &[("b", &[0]), ("c", &[2])];
    assert_same(
        &experiment,
        hosts,
        Weather {
            loses: 12,
            cut: None,
        },
    );
    let second = Duration::from_secs(1);
    assert_same(
        &experiment,
        hosts,
        Weather {
            loses: 0,
            cut: Some((100, second)),
        },
    );
}
