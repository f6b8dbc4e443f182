//! A run across hosts in one process: each host has shared memory of its own, and threads take the parts of its
//! processes.

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::Duration;

use slipstream_agents::process as agent;
use slipstream_agents::{AgentContext, BuiltIn, NodeReport};
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_hosts::carrier::{HostCarrier, PlantCarrier};
use slipstream_hosts::hello::RemoteHost;
use slipstream_hosts::relay::Relay;
use slipstream_hosts::stand_in::{StandIn, StandInOutcome};
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::part::Membership;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::record_pipe::RecordReceiver;
use slipstream_ipc::run_directory::{RunDirectory, RunLock};
use slipstream_ipc::trace::{self, Tracing};
use slipstream_ipc::wake_page::{Member, Stage, WakePage};
use slipstream_sim::run::process::{self as plant, PlantOutcome};

pub(crate) const VERSION: &str = "0.1.0 (test)";
/// Number of the run.
pub(crate) const RUN: u64 = 7;

/// The shared memory of a host.
pub(crate) struct Host {
    directory: RunDirectory,
    pub(crate) page: WakePage,
    _lock: RunLock,
}

impl Host {
    pub(crate) fn new(experiment: &Experiment, local: Option<&[RobotIndex]>) -> Self {
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

    pub(crate) fn folder(&self) -> &Path {
        self.directory.folder()
    }

    /// Starts the agents of these robots.
    fn agents<'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        robots: &[RobotIndex],
        recording: bool,
    ) -> Vec<(RobotIndex, ScopedJoinHandle<'scope, NodeReport>)> {
        let start = |&robot: &RobotIndex| {
            let membership = Membership {
                run: self.folder().to_owned(),
                launcher: Parent::now(),
                recording,
                trace: recording,
            };
            let run = move || {
                let _trace = recording.then(|| traced(&robot_name(robot)));
                let made = |context: &AgentContext<'_>| Ok(BuiltIn::new(context)?);
                agent::run(&membership, robot, false, made).unwrap()
            };
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

/// A platoon on slippery wheels for 4 s.
pub(crate) fn experiment(robots: u32, change: impl Fn(&mut Settings)) -> Experiment {
    let mut settings = Settings {
        duration_s: 4.0,
        ..Settings::default()
    };
    settings.robots.count = robots;
    change(&mut settings);
    settings.validate().unwrap();
    Experiment::new(settings, &RobotModel::paper_with_slip())
}

/// Traces what the thread does as this process.
fn traced(process: &str) -> Tracing {
    trace::begin(process, "debug".parse().unwrap())
}

/// Receives the chunks of records of a run until all its processes have ended.
fn record(folder: &Path) -> Vec<Vec<u8>> {
    let joined = JoinedRun::new(folder, Member::Recorder, Parent::now()).unwrap();
    let receiver = RecordReceiver::new(
        &joined.services("recorder").unwrap(),
        joined.presence.clone(),
    )
    .unwrap();
    joined.wake_page().signal_ready();
    let mut chunks = Vec::new();
    loop {
        let is_last = joined.wake_page().stage() >= Stage::Drained;
        while let Some(chunk) = receiver.poll_chunk(<[u8]>::to_vec).unwrap() {
            chunks.push(chunk);
        }
        if is_last {
            return chunks;
        }
        thread::sleep(Duration::from_millis(1));
    }
}

/// Runs an experiment with the agents of `remote` on other hosts, over these networks. Returns the plant's outcome and
/// the reports of all agents.
pub(crate) fn run_across(
    experiment: &Experiment,
    remote: &[RemoteHost],
    home: Box<dyn PlantCarrier + Send>,
    carriers: Vec<Box<dyn HostCarrier + Send>>,
) -> (PlantOutcome, Vec<NodeReport>) {
    let (outcome, reports, _) = run_recorded(experiment, remote, home, carriers, false);
    (outcome, reports)
}

/// As [`run_across`], also returns the chunks of records if it is `recording`.
pub(crate) fn run_recorded(
    experiment: &Experiment,
    remote: &[RemoteHost],
    home: Box<dyn PlantCarrier + Send>,
    carriers: Vec<Box<dyn HostCarrier + Send>>,
    recording: bool,
) -> (PlantOutcome, Vec<NodeReport>, Vec<Vec<u8>>) {
    let elsewhere = |robot: &RobotIndex| remote.iter().any(|host| host.robots.contains(robot));
    let all = 0..experiment.settings.robots.count;
    let here: Vec<RobotIndex> = all.filter(|robot| !elsewhere(robot)).collect();
    let at_home = Host::new(experiment, None);
    let away: Vec<Host> = remote
        .iter()
        .map(|host| Host::new(experiment, Some(&host.robots)))
        .collect();
    thread::scope(|scope| {
        let folder = at_home.folder();
        let plant = scope.spawn(move || plant::run(folder, Parent::now(), recording).unwrap());
        let recorder = recording.then(|| scope.spawn(move || record(folder)));
        let stand_in = scope.spawn(move || stand_in(folder, remote, home, recording));
        let mut agents = at_home.agents(scope, &here, recording);
        let mut relays = Vec::new();
        for ((host, mut carrier), remote) in away.iter().zip(carriers).zip(remote) {
            relays.push(scope.spawn(move || {
                let _trace = recording.then(|| traced("relay"));
                let relay = Relay {
                    folder: host.folder(),
                    launcher: Parent::now(),
                    run: RUN,
                    recording,
                    left: &|_| Vec::new(),
                    failure: &|| None,
                };
                relay.run(&mut *carrier).unwrap()
            }));
            agents.extend(host.agents(scope, &remote.robots, recording));
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
        at_home.page.advance(Stage::Drained);
        let chunks = recorder.map(|recorder| recorder.join().unwrap());
        (outcome, reports, chunks.unwrap_or_default())
    })
}

/// Runs a stand-in to its end.
pub(crate) fn stand_in(
    folder: &Path,
    hosts: &[RemoteHost],
    mut home: Box<dyn PlantCarrier + Send>,
    recording: bool,
) -> StandInOutcome {
    let _trace = recording.then(|| traced("hosts"));
    let stand_in = StandIn {
        folder,
        launcher: Parent::now(),
        hosts,
        version: VERSION,
        run: RUN,
        keys: String::new(),
        recording,
        keep: &|_, _| {},
        notice: &|_| {},
    };
    stand_in.run(&mut *home).unwrap()
}

/// Hosts with these names and robots.
pub(crate) fn remote(hosts: &[(&str, &[RobotIndex])]) -> Vec<RemoteHost> {
    let host = |&(name, robots): &(&str, &[RobotIndex])| RemoteHost {
        name: name.to_owned(),
        robots: robots.to_vec(),
    };
    hosts.iter().map(host).collect()
}
