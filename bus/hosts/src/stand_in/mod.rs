//! Stand-in: the process on the plant's host that takes the part of all agents on other hosts.
//!
//! It joins the run as each of these agents would, so that plant, recorder and the agents of this host notice no
//! difference.

mod host;
mod hosts;
mod robots;
mod session;
mod wall;

use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;
use slipstream_ipc::endpoints::Awaited;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::Parent;
use slipstream_ipc::wake_page::Member;

use self::host::Arrived;
use self::hosts::Hosts;
use self::robots::Robots;
use self::session::Session;
use crate::carrier::PlantCarrier;
use crate::frame::{Down, End, LeftFile};
use crate::hello::{RemoteHost, Welcome, robots_of};
use crate::log;

/// Longest wait for a round of the plant, between two looks at the network.
const ROUND_WAIT: Duration = Duration::from_millis(100);
/// Time that the hosts of a run that ends early have to report.
const STOP_GRACE: Duration = Duration::from_millis(400);

/// What the stand-in is started with.
pub struct StandIn<'a> {
    /// The run directory.
    pub folder: &'a Path,
    /// The launcher.
    pub launcher: Parent,
    /// The other hosts. Each has at least one robot, and no robot is on two.
    pub hosts: &'a [RemoteHost],
    /// Version and commit of this program.
    pub version: &'a str,
    /// Number of the run, drawn at its start.
    pub run: u64,
    /// The keys of the experiment as TOML.
    pub keys: String,
    /// The run is recorded.
    pub recording: bool,
    /// Keeps a file that an agent of a host left.
    pub keep: &'a dyn Fn(&RemoteHost, &LeftFile),
    /// Says something to the user.
    pub notice: &'a dyn Fn(&str),
}

/// How the stand-in ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct StandInOutcome {
    /// How it ended.
    pub ended: ProcessStatus,
    /// Chunks of records that did not reach the recorder.
    pub lost_chunks: u64,
    /// What went wrong on other hosts although the run went on.
    pub failures: Vec<String>,
}

impl StandIn<'_> {
    /// Waits for the hosts, and takes the part of their agents until the run is over.
    ///
    /// # Errors
    /// It cannot join the run. Errors after that are in [`StandInOutcome::ended`].
    pub fn run(self, carrier: &mut dyn PlantCarrier) -> Result<StandInOutcome, BusError> {
        let first = robots_of(self.hosts).next();
        let first = first.ok_or_else(|| BusError::failed("hosts", "a stand-in for no robot"))?;
        let joined = JoinedRun::new(self.folder, Member::Agent(first as usize), self.launcher)?;
        let experiment = postcard::to_allocvec(&joined.experiment)
            .map_err(|e| BusError::failed("experiment", e))?;
        let welcome = Welcome {
            run: self.run,
            experiment,
            keys: self.keys,
            robots: Vec::new(),
            recording: self.recording,
        };
        let mut hosts = Hosts::new(
            self.hosts,
            &joined,
            self.version,
            self.notice,
            welcome,
            carrier,
        );
        let (mut lost_chunks, mut failures) = (0, Vec::new());
        let ended = hosts.await_all().and_then(|()| {
            let services = joined.services("hosts")?;
            let mut robots = Robots::join(&joined, &services, self.hosts, self.recording)?;
            let mut session = Session {
                joined: &joined,
                services: &services,
                hosts: self.hosts,
                recording: self.recording,
                notice: self.notice,
                start_ns: 0,
                failures: Vec::new(),
            };
            let ended = play(&mut session, &mut robots, &mut hosts);
            let stopped = ended.as_ref().err().map(told);
            let left = farewell(&mut session, &mut robots, &mut hosts, self.keep, stopped);
            lost_chunks = robots.lost_chunks();
            failures = session.failures;
            ended.and(left)
        });
        if let Err(error) = &ended {
            hosts.stop(&told(error));
        }
        Ok(StandInOutcome {
            ended: ended.into(),
            lost_chunks,
            failures,
        })
    }
}

/// Takes the part of the agents until the plant has made its last step.
fn play(
    session: &mut Session<'_>,
    robots: &mut Robots,
    hosts: &mut Hosts<'_>,
) -> Result<(), BusError> {
    if session.services.lockstep() {
        rounds(robots, hosts)?;
    } else {
        wall::pass_on(session, robots, hosts)?;
    }
    // The plant may have ended first: a run that was stopped is not complete.
    match session.joined.wake_page().stopping() {
        true => Err(BusError::Stopped),
        false => Ok(()),
    }
}

/// What other hosts are told of why the run ends early.
fn told(error: &BusError) -> String {
    match error {
        BusError::Stopped => "it was stopped".to_owned(),
        other => other.to_string(),
    }
}

/// In lockstep: plays all rounds.
fn rounds(robots: &mut Robots, hosts: &mut Hosts<'_>) -> Result<(), BusError> {
    for number in 1.. {
        loop {
            match robots.await_round(ROUND_WAIT)? {
                Awaited::Over => return Ok(()),
                Awaited::Round(_) => break,
                Awaited::Nothing => hosts.look()?,
            }
        }
        robots.take_positions()?;
        hosts.ask(|own| Down::Round(robots.round(number, own)))?;
        for (own, answer) in hosts.await_answers(number)? {
            robots.answer(&own, answer)?;
        }
    }
    Ok(())
}

/// Tells the hosts that the run is over, and keeps what their agents leave. `stopped`: why the run ends early; then
/// there is little time.
fn farewell(
    session: &mut Session<'_>,
    robots: &mut Robots,
    hosts: &mut Hosts<'_>,
    keep: &dyn Fn(&RemoteHost, &LeftFile),
    stopped: Option<String>,
) -> Result<(), BusError> {
    robots.take_last_encoders()?;
    hosts.ask(|own: &[RobotIndex]| {
        Down::Over(End {
            measured: robots.measured(own),
            stopped: stopped.clone(),
        })
    })?;
    let limit = stopped.map(|_| STOP_GRACE);
    let begin = Instant::now();
    while !hosts.all_have_left() && limit.is_none_or(|limit| begin.elapsed() < limit) {
        let reports = hosts.take_reports(limit.is_some())?;
        // On the wall clock, what has come before the report.
        for (host, arrived) in hosts.take_arrived() {
            match arrived {
                Arrived::Records(records) => robots.record(&host.robots, records),
                Arrived::Lost(reason) => {
                    session.fail(&host.name, &reason, "; what its agents left is missing");
                }
                Arrived::Clock(report) => log::clock(&host.name, session.start_ns, &report),
                Arrived::Sent(_) | Arrived::Agents(_) => {}
            }
        }
        for (host, report) in reports {
            robots.record(&host.robots, report.records);
            for file in &report.files {
                keep(&host, file);
            }
            if let Some(failure) = report.failure {
                session.fail(&host.name, &failure, "");
            }
        }
    }
    robots.hand_over_the_rest();
    Ok(())
}
