//! Summary of a run, and its JSON (schema: `tools/cli/schemas/run.schema.json`).

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use slipstream_agents::NodeReport;
use slipstream_agents::process::AgentOutcome;
use slipstream_bus::Experiment;
use slipstream_bus::experiment::Clock;
use slipstream_bus::link::LinkCounts;
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_ipc::clock::{Deadlines, RealTime};
pub use slipstream_robots::fleet::{RobotReport, Stream};
use slipstream_robots::process::RobotsOutcome;
use slipstream_sim::run::PlantReport;
use slipstream_sim::run::process::PlantOutcome;

use crate::role::Role;

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum RunStatus {
    /// The experiment ran to its end.
    #[default]
    Done,
    /// A process failed, for this reason.
    Failed(String),
    /// A signal interrupted it.
    Interrupted,
}

/// Summary of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    format: u32,
    /// The experiment's name.
    pub experiment: String,
    clock: Clock,
    seed: u64,
    /// The processes that were started; empty for a run in one process.
    pub processes: Vec<Process>,
    /// SHA-256 over every plant step.
    pub state_hash: String,
    /// Duration in the time of the run (s).
    pub duration_s: f64,
    /// Wall time from the start of the first process to the end of the last (s).
    pub wall_s: f64,
    /// Wall time of the simulation loop (s).
    pub loop_s: f64,
    /// Wall time from the start of the plant until all processes were connected (s).
    pub start_up_s: f64,
    /// The robots, from the front.
    pub robots: Vec<RobotSummary>,
    /// The links, from the front robot's link on.
    pub links: Vec<LinkSummary>,
    /// What the delay of the links did; `None` without one, and where it cannot be told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay: Option<DelayEffect>,
    /// Deadlines of the loops; empty on the virtual clock.
    pub deadlines: Vec<DeadlineSummary>,
    /// Real-time scheduling that the system permitted; `None` on the virtual clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_time: Option<RealTime>,
    /// The recording, if one was written.
    pub recording: Option<PathBuf>,
    /// Number of records that did not reach the recording.
    pub lost_records: u64,
    /// How it ended. Not part of the JSON: a summary that is read back has `Done`.
    #[serde(skip)]
    pub status: RunStatus,
}

/// A process of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Process {
    /// `plant`, `agent`, `recorder`, or `hosts`: what stands for the agents on other hosts.
    pub role: String,
    /// An agent's robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Process id.
    pub pid: u32,
    /// The host that it ran on, if that is not the plant's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
}

/// Result for one robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotSummary {
    /// Its name.
    pub robot: String,
    /// True pose of c at the end: x (m), y (m), yaw (rad). Of a real robot the last one that was measured.
    pub final_true: Option<[f64; 3]>,
    /// The same by odometry; `None` if its agent died.
    pub final_odometry: Option<[f64; 3]>,
    /// Time for which each contact slid (s), [right, left].
    pub slip_time_s: Option<[f64; 2]>,
    /// Largest sliding speed of each contact (m/s), [right, left].
    pub max_slip_m_s: Option<[f64; 2]>,
    /// Largest true spacing error from 3 s on (m); `None` for the front robot.
    pub max_spacing_error_m: Option<f64>,
    /// Largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: Option<f64>,
    /// What was heard of a real robot and what it was told; `None` in simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real: Option<RobotReport>,
}

/// Message counts of a link.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkSummary {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// Messages sent.
    pub sent: u64,
    /// Messages that left the delay line.
    pub delivered: u64,
    /// Messages lost on the link, by its impairment or by the network between two hosts.
    pub lost: u64,
    /// Messages still in the delay line at the end.
    pub in_flight: u64,
    /// Messages delivered after a newer one.
    pub stale: u64,
}

/// What the delay of the links did: the run as it was beside the same run without that delay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DelayEffect {
    /// Mean age of the position in use at the followers' outer ticks, from its sampling on (s).
    pub age_s: f64,
    /// The same without the delay: the waits for ticks, and for the turn of a ring (s).
    pub age_without_s: f64,
    /// Largest true spacing error without the delay (m).
    pub max_spacing_error_without_m: f64,
}

/// Deadlines of a loop on the wall clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeadlineSummary {
    /// The process: `plant`, or the robot.
    pub process: String,
    /// `step`, `outer` or `inner`.
    #[serde(rename = "loop")]
    pub name: String,
    /// Number of ticks that were due.
    pub ticks: u64,
    /// Ticks that ended a period late, or were skipped.
    pub missed: u64,
    /// Largest delay of a wake-up (s).
    pub latest_s: f64,
}

/// Final reports of plant and agents; `None` for a process that ended without one.
#[derive(Debug, Clone, Default)]
pub(crate) struct ProcessReports {
    pub(crate) plant: Option<PlantReport>,
    pub(crate) agents: Vec<Option<NodeReport>>,
}

impl RunSummary {
    /// The summary of an experiment with these reports.
    pub(crate) fn new(experiment: &Experiment, parts: &ProcessReports) -> Self {
        let settings = &experiment.settings;
        let plant = parts.plant.clone().unwrap_or_default();
        Self {
            format: 1,
            experiment: settings.name.clone(),
            clock: settings.clock,
            seed: settings.seed,
            processes: Vec::new(),
            robots: robots(experiment, &plant, &parts.agents),
            links: links(&parts.agents),
            state_hash: plant.state_hash,
            duration_s: plant.duration_s,
            wall_s: 0.0,
            loop_s: 0.0,
            start_up_s: 0.0,
            delay: None,
            deadlines: Vec::new(),
            real_time: None,
            recording: None,
            lost_records: 0,
            status: RunStatus::Done,
        }
    }

    /// Adds what the processes report about time: lost records, wall time.
    pub(crate) fn add_timing(
        &mut self,
        plant: Option<&PlantOutcome>,
        agents: &[Option<AgentOutcome>],
    ) {
        let reported = || agents.iter().flatten();
        let lost: u64 = reported().map(|agent| agent.lost_records).sum();
        self.lost_records = lost + plant.map_or(0, |plant| plant.lost_records);
        if let Some(plant) = plant {
            self.loop_s = plant.loop_s;
            self.start_up_s = plant.start_up_s;
            let all = reported().map(|agent| agent.real_time);
            let least = all.fold(plant.real_time, RealTime::both);
            self.real_time = plant.deadlines.map(|_| least);
        }
    }
}

impl RunSummary {
    /// The largest true spacing error of all robots (m).
    pub fn max_spacing_error_m(&self) -> Option<f64> {
        let errors = self.robots.iter().filter_map(|own| own.max_spacing_error_m);
        errors.reduce(f64::max)
    }

    /// What the delay of the links did, in words.
    pub fn delay_sentence(&self) -> Option<String> {
        let delay = self.delay?;
        let with_cm = 100.0 * self.max_spacing_error_m()?;
        let without_cm = 100.0 * delay.max_spacing_error_without_m;
        Some(format!(
            "A position is {:.0} ms old when a follower uses it, {:.0} ms without the delay of the links. Without that \
             delay the largest spacing error is {without_cm:.1} cm, with it {with_cm:.1} cm: x_r and v_r come late (Eq. 13).",
            1e3 * delay.age_s,
            1e3 * delay.age_without_s,
        ))
    }

    /// Adds what the process of real robots reports. Poses and spacing are those that were measured.
    pub(crate) fn add_real(&mut self, outcome: &RobotsOutcome) {
        self.duration_s = outcome.duration_s;
        self.start_up_s = outcome.start_up_s;
        self.loop_s = outcome.loop_s;
        self.lost_records += outcome.lost_records;
        let spacing = &outcome.max_spacing_error_m;
        let reports = outcome.robots.iter().zip(spacing);
        for (own, (report, spacing_m)) in self.robots.iter_mut().zip(reports) {
            own.final_true = report.last_pose;
            own.max_spacing_error_m = *spacing_m;
            own.real = Some(report.clone());
        }
        let agents = self.real_time.unwrap_or(outcome.real_time);
        self.real_time = Some(agents.both(outcome.real_time));
    }
}

impl Process {
    pub(crate) fn new(role: Role, pid: u32) -> Self {
        Self {
            role: role.argument().to_owned(),
            robot: role.robot().map(robot_name),
            pid,
            host: None,
        }
    }

    /// The agent of a robot that ran on another host.
    pub(crate) fn on_host(host: &str, robot: RobotIndex, pid: u32) -> Self {
        Self {
            host: Some(host.to_owned()),
            ..Self::new(Role::Agent(robot), pid)
        }
    }
}

impl DeadlineSummary {
    pub(crate) fn new(process: &str, name: &str, deadlines: &Deadlines) -> Self {
        Self {
            process: process.to_owned(),
            name: name.to_owned(),
            ticks: deadlines.ticks,
            missed: deadlines.missed,
            latest_s: slipstream_bus::time::s_from_ns(deadlines.latest_ns),
        }
    }
}

fn robots(
    experiment: &Experiment,
    plant: &PlantReport,
    agents: &[Option<NodeReport>],
) -> Vec<RobotSummary> {
    let robot = |(i, setup): (usize, &slipstream_bus::RobotSetup)| {
        let truth = plant.robots.get(i);
        let agent = agents.get(i).and_then(Option::as_ref);
        RobotSummary {
            robot: setup.name.clone(),
            final_true: truth.map(|truth| truth.final_true),
            final_odometry: agent.map(|agent| agent.final_odometry),
            slip_time_s: truth.map(|truth| truth.slip_time_s),
            max_slip_m_s: truth.map(|truth| truth.max_slip_m_s),
            max_spacing_error_m: truth.and_then(|truth| truth.max_spacing_error_m),
            max_desired_speed_m_s: agent.map(|agent| agent.max_desired_speed_m_s),
            real: None,
        }
    };
    experiment.robots.iter().enumerate().map(robot).collect()
}

/// Both ends of a link count its messages; if one end died, the other's counts are used.
fn links(agents: &[Option<NodeReport>]) -> Vec<LinkSummary> {
    let mut links: BTreeMap<[RobotIndex; 2], Option<u64>> = BTreeMap::new();
    let mut received: BTreeMap<[RobotIndex; 2], LinkCounts> = BTreeMap::new();
    for (robot, agent) in (0..).zip(agents) {
        let Some(agent) = agent else {
            continue;
        };
        for &(to, sent) in &agent.sent {
            links.insert([robot, to], Some(sent));
        }
        for &(from, counts) in &agent.received {
            links.entry([from, robot]).or_default();
            received.insert([from, robot], counts);
        }
    }
    let link = |([from, to], sent): ([RobotIndex; 2], Option<u64>)| {
        let counts = received.get(&[from, to]).copied().unwrap_or_default();
        let sent = sent.unwrap_or(counts.received);
        let gone = counts.delivered + counts.lost + counts.missing;
        LinkSummary {
            from: robot_name(from),
            to: robot_name(to),
            sent,
            delivered: counts.delivered,
            lost: counts.lost + counts.missing,
            in_flight: sent.saturating_sub(gone),
            stale: counts.stale,
        }
    };
    links.into_iter().map(link).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::Settings;

    #[test]
    fn the_json_reads_back() {
        let experiment = Experiment {
            settings: Settings::default(),
            robots: Vec::new(),
            half_round_trips_ns: Vec::new(),
        };
        let mut summary = RunSummary::new(&experiment, &ProcessReports::default());
        summary.processes.push(Process::new(Role::Agent(1), 7));
        summary.real_time = Some(RealTime::default());
        summary
            .deadlines
            .push(DeadlineSummary::new("r1", "outer", &Deadlines::default()));
        let text = serde_json::to_string(&summary).unwrap();
        assert_eq!(serde_json::from_str::<RunSummary>(&text).unwrap(), summary);
    }
}
