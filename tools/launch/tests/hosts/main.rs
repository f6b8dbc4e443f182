//! A lockstep across hosts gives the states and reports of the run in one process, bit for bit, also over a network
//! that loses frames. Here all hosts are on one machine, each with shared memory of its own, and the network is a
//! pair of channels.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod harness;

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use slipstream_bus::experiment::{Clock, OnDeath, Protocol};
use slipstream_bus::message::{DriveCommand, RobotIndex};
use slipstream_bus::trace::{self, TraceRecord};
use slipstream_bus::transport::BusError;
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_hosts::carrier::{Event, HostCarrier, PlantCarrier};
use slipstream_hosts::frame::{Answer, Down, Report, Up, decode, encode};
use slipstream_hosts::hello::{Hello, RemoteHost, Welcome};
use slipstream_hosts::stand_in::StandInOutcome;
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::record_pipe::{Entry, decode_chunk};
use slipstream_launch::in_process;
use slipstream_sim::run::process as plant;

use harness::{Host, RUN, VERSION, experiment, remote, run_across, run_recorded, stand_in};

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

const LOSSY: Weather = Weather {
    loses: 40,
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

/// The network between the plant's host and others.
fn network(remote: &[RemoteHost], weather: Weather) -> (Home, Vec<Away>) {
    let (to_home, events) = channel();
    let mut home = Home {
        events,
        hosts: BTreeMap::new(),
        gate: Gate::new(weather),
    };
    let mut away = Vec::new();
    for host in remote {
        let (sender, frames) = channel();
        home.hosts.insert(host.name.clone(), sender);
        away.push(Away {
            name: host.name.clone(),
            frames,
            home: to_home.clone(),
            gate: Gate::new(weather),
        });
    }
    (home, away)
}

/// The ends of a network as [`run_across`] wants them.
type BoxedNetwork = (
    Box<dyn PlantCarrier + Send>,
    Vec<Box<dyn HostCarrier + Send>>,
);

fn boxed_network(remote: &[RemoteHost], weather: Weather) -> BoxedNetwork {
    let (home, away) = network(remote, weather);
    let boxed = |away| -> Box<dyn HostCarrier + Send> { Box::new(away) };
    (Box::new(home), away.into_iter().map(boxed).collect())
}

#[track_caller]
fn assert_same(experiment: &Experiment, hosts: &[(&str, &[RobotIndex])], weather: Weather) {
    let alone = in_process::run(experiment, true).unwrap();
    let remote = remote(hosts);
    let (home, away) = boxed_network(&remote, weather);
    let (outcome, reports) = run_across(experiment, &remote, home, away);
    assert_eq!(outcome.report.state_hash, alone.plant.state_hash);
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
fn other_topologies_are_the_same_across_hosts() {
    for topology in ["all", "leader_predecessor", "two_predecessors"] {
        let all = experiment(10, |s| {
            s.links.topology = topology.parse().unwrap();
            s.links.protocol = Protocol::Periodic;
            s.links.delay_s = 0.03;
            s.links.loss = 0.1;
        });
        assert_same(&all, &[("b", &[1, 2, 6, 9]), ("c", &[3, 5, 7])], FINE);
    }
    let ring = experiment(4, |s| s.links.topology = "all".parse().unwrap());
    assert_same(&ring, &[("b", &[1, 2])], FINE);
}

#[test]
fn lost_frames_and_a_cut_change_nothing() {
    let experiment = experiment(3, |s| s.links.jitter_s = 0.02);
    let hosts: &[(&str, &[RobotIndex])] = &[("b", &[0]), ("c", &[2])];
    assert_same(&experiment, hosts, LOSSY);
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

/// The plant's host alone, with a stand-in that waits for the hosts `b` and `c`. `play`: what the other hosts do.
fn with_stand_in<T>(
    change: impl Fn(&mut Settings),
    play: impl FnOnce(&Sender<Event>, &BTreeMap<String, Receiver<Vec<u8>>>) -> T,
) -> (T, StandInOutcome) {
    let experiment = experiment(2, change);
    let remote = remote(&[("b", &[0]), ("c", &[1])]);
    let (home, away) = network(&remote, FINE);
    let to_home = away[0].home.clone();
    let frames: BTreeMap<String, Receiver<Vec<u8>>> = away
        .into_iter()
        .map(|away| (away.name, away.frames))
        .collect();
    let at_home = Host::new(&experiment, None);
    thread::scope(|scope| {
        let folder = at_home.folder();
        let plant = scope.spawn(move || plant::run(folder, Parent::now(), false));
        let remote = &remote;
        let stand_in = scope.spawn(move || stand_in(folder, remote, Box::new(home), false));
        let played = play(&to_home, &frames);
        let outcome = stand_in.join().unwrap();
        // As the launcher does when a process fails.
        at_home.page.stop();
        let _ = plant.join().unwrap();
        (played, outcome)
    })
}

fn patient(settings: &mut Settings) {
    settings.host_timeout_s = 30.0;
}

fn greet(home: &Sender<Event>, version: &str, name: &str) -> Result<Welcome, String> {
    let (_, frames) = channel();
    let away = Away {
        name: name.to_owned(),
        frames,
        home: home.clone(),
        gate: Gate::new(FINE),
    };
    away.ask(version, name)
}

fn send(home: &Sender<Event>, host: &str, frame: &Up) {
    let (host, bytes) = (host.to_owned(), encode(frame).unwrap());
    home.send(Event::Frame { host, bytes }).unwrap();
}

fn reason(outcome: StandInOutcome) -> String {
    match outcome.ended {
        ProcessStatus::Failed(reason) => reason,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_host_that_may_not_join_is_told_why() {
    let (_, outcome) = with_stand_in(patient, |home, _| {
        let refused = |version: &str, name: &str| greet(home, version, name).unwrap_err();
        let other = refused("0.1.0 (other)", "b");
        assert!(
            other.contains("use the same build on both hosts"),
            "{other}"
        );
        let unknown = refused(VERSION, "d");
        assert_eq!(unknown, "the run waits for no host d, but for b, c");
        let welcome = greet(home, VERSION, "b").unwrap();
        assert_eq!((welcome.run, welcome.robots), (RUN, vec![0]));
        assert_eq!(refused(VERSION, "b"), "a host b has joined already");
        let hello = vec![1, 2, 3];
        let (sender, answers) = channel();
        let answer = Box::new(move |answer: Result<&[u8], &str>| {
            sender.send(answer.is_ok()).unwrap();
        });
        home.send(Event::Hello { hello, answer }).unwrap();
        assert!(!answers.recv().unwrap());
        send(home, "b", &Up::Failed("r1 was killed".to_owned()));
    });
    assert_eq!(reason(outcome), "host b: r1 was killed");
}

#[test]
fn a_host_that_falls_silent_or_is_gone_ends_the_run_in_words() {
    let ready = |home: &Sender<Event>| {
        for host in ["b", "c"] {
            greet(home, VERSION, host).unwrap();
            send(home, host, &Up::Ready(RUN));
        }
    };
    // Waits until the run has begun for a host.
    let await_round = |frames: &Receiver<Vec<u8>>| {
        while !matches!(decode(&frames.recv().unwrap()), Ok(Down::Round(_))) {}
    };
    let (begin, outcome) = with_stand_in(
        |s| s.host_timeout_s = 1.0,
        |home, frames| {
            ready(home);
            await_round(&frames["c"]);
            Instant::now()
        },
    );
    let text = reason(outcome);
    assert!(text.contains("it has been silent for 1."), "{text}");
    assert!(begin.elapsed() < Duration::from_secs(3));
    let (_, outcome) = with_stand_in(patient, |home, frames| {
        ready(home);
        await_round(&frames["c"]);
        let host = "c".to_owned();
        home.send(Event::Gone { host }).unwrap();
    });
    let text = reason(outcome);
    assert!(text.starts_with("host c: its process is gone"), "{text}");
}

#[test]
fn an_answer_for_robots_of_another_host_is_refused() {
    let (_, outcome) = with_stand_in(patient, |home, frames| {
        for host in ["b", "c"] {
            greet(home, VERSION, host).unwrap();
            send(home, host, &Up::Ready(RUN));
        }
        let round = loop {
            if let Ok(Down::Round(round)) = decode(&frames["b"].recv().unwrap()) {
                break round;
            }
        };
        let commands = vec![DriveCommand {
            robot: 1,
            ..DriveCommand::default()
        }];
        send(
            home,
            "b",
            &Up::Answer(Answer {
                number: round.number,
                commands,
                positions: Vec::new(),
                records: Vec::new(),
            }),
        );
    });
    let text = reason(outcome);
    assert_eq!(text, "host b: it answers for other robots than its own");
}

#[test]
fn on_the_wall_clock_encoders_torques_and_positions_cross() {
    let experiment = experiment(3, |s| {
        s.clock = Clock::Wall;
        s.links.delay_s = 0.05;
    });
    let experiment = Experiment::new(experiment.settings, &RobotModel::default());
    let remote = remote(&[("b", &[1]), ("c", &[2])]);
    for weather in [FINE, LOSSY] {
        let (home, away) = boxed_network(&remote, weather);
        let (outcome, reports) = run_across(&experiment, &remote, home, away);
        for (robot, report) in outcome.report.robots.iter().zip(&reports) {
            // No wheel can slip, so odometry is the truth but for the resolution of the encoders. It includes the last
            // encoders of the run, which are sent until they have come.
            let [x, y, _] = robot.final_true;
            let [odometry_x, odometry_y, _] = report.final_odometry;
            let error_m = (x - odometry_x).hypot(y - odometry_y);
            assert!(error_m < 0.001, "{robot:?} {report:?}");
        }
        let distance_m =
            |robot: usize, start_m: f64| outcome.report.robots[robot].final_true[0] - start_m;
        for (robot, start_m) in [0.6096, 0.0, -0.6096].into_iter().enumerate() {
            assert!(distance_m(robot, start_m) > 0.1, "{:?}", outcome.report);
        }
        for link in 0..2 {
            let (_, sent) = reports[link].sent[0];
            let received = reports[link + 1].received[0].1.received;
            // The last ones may be under way at the end.
            let least = if weather.loses == 0 {
                sent - 2
            } else {
                sent / 2
            };
            assert!((least..=sent).contains(&received), "{received} of {sent}");
        }
    }
}

/// Calls `each` with every trace record of these chunks.
fn each_trace_record(chunks: &[Vec<u8>], mut each: impl FnMut(TraceRecord<'_>)) {
    for chunk in chunks {
        let mut entry = |_, entry: Entry<'_>| {
            if let Entry::Trace { bytes, .. } = entry {
                let with_format = [&[trace::FORMAT], bytes].concat();
                trace::read(&with_format, &mut each).unwrap();
            }
        };
        decode_chunk(chunk, &mut entry).unwrap();
    }
}

#[test]
fn on_the_wall_clock_the_trace_has_clocks_and_crossings_of_all_hosts() {
    let experiment = experiment(3, |s| s.clock = Clock::Wall);
    let remote = remote(&[("b", &[1]), ("c", &[2])]);
    let (home, away) = boxed_network(&remote, LOSSY);
    let (_, reports, chunks) = run_recorded(&experiment, &remote, home, away, true);
    let (mut hosts, mut clocks) = (Vec::new(), BTreeMap::<String, u32>::new());
    let (mut crossed, mut received) = ([0; 3], [0; 3]);
    each_trace_record(&chunks, |record| match &*record.name {
        "host" => hosts.push((
            record.text("host").unwrap().to_owned(),
            record.int("robot").unwrap(),
        )),
        "clock" => {
            let int = |name: &str| record.int(name).unwrap();
            // All hosts of this test have one clock.
            assert!(int("offset_ns").abs() <= int("bound_ns"), "{record:?}");
            assert!(int("error_ns") >= int("bound_ns"), "{record:?}");
            *clocks
                .entry(record.text("host").unwrap().to_owned())
                .or_default() += 1;
        }
        "crossed" => crossed[record.int("to").unwrap() as usize] += 1,
        "arrived" => received[record.int("to").unwrap() as usize] += 1,
        _ => {}
    });
    assert_eq!(hosts, [("b".to_owned(), 1), ("c".to_owned(), 2)]);
    let names: Vec<&str> = clocks.keys().map(String::as_str).collect();
    assert_eq!(names, ["b", "c"]);
    for (robot, report) in reports.iter().enumerate() {
        let counts = report.received[0].1;
        assert_eq!(received[robot], counts.received, "no record is lost");
        // A position that comes after the last tick crosses, but no agent takes it.
        assert!(
            crossed[robot] >= counts.received,
            "{robot}: {crossed:?} {counts:?}"
        );
    }
}

#[test]
fn on_the_wall_clock_a_run_can_go_on_without_a_host() {
    let goes_on = |s: &mut Settings| {
        s.clock = Clock::Wall;
        s.on_death = OnDeath::Continue;
        s.host_timeout_s = 1.0;
    };
    let (_, outcome) = with_stand_in(goes_on, |home, frames| {
        for host in ["b", "c"] {
            greet(home, VERSION, host).unwrap();
            send(home, host, &Up::Ready(RUN));
        }
        // The host c is silent from here on. The host b beats and reports.
        loop {
            match decode(&frames["b"].recv().unwrap()).unwrap() {
                Down::Over(_) => send(home, "b", &Up::Report(Report::default())),
                Down::Received => break,
                _ => send(home, "b", &Up::Beat),
            }
        }
        send(home, "b", &Up::Bye);
    });
    assert_eq!(outcome.ended, ProcessStatus::Done);
    let [failure] = &outcome.failures[..] else {
        panic!("{outcome:?}");
    };
    assert!(
        failure.starts_with("host c: it has been silent for 1."),
        "{failure}"
    );
}
