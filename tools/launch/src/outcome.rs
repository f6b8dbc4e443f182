//! What a run came to, and its form as JSON (CONTRACT.md, section 5).

use std::path::{Path, PathBuf};

use serde::Serialize;
use slipstream_agents::NodeReport;
use slipstream_bus::Experiment;
use slipstream_bus::experiment::Clock;
use slipstream_bus::message::robot_name;
use slipstream_ipc::clock::{Deadlines, RealTime};
use slipstream_sim::run::PlantReport;

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// The experiment is over.
    Done,
    /// Something failed; in words.
    Failed(String),
    /// Somebody interrupted it.
    Interrupted,
}

/// What a run came to.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    format: u32,
    /// The experiment's name.
    pub experiment: String,
    clock: Clock,
    seed: u64,
    /// The processes that were started; none in a run in one process.
    pub processes: Vec<Process>,
    /// SHA-256 over every plant step.
    pub state_hash: String,
    /// How long the run lasted in its own time (s).
    pub duration_s: f64,
    /// How long it took from the first process's start to the last one's end (s).
    pub wall_s: f64,
    /// How long the loop alone took (s).
    pub loop_s: f64,
    /// From the plant's start until everybody was connected (s).
    pub start_up_s: f64,
    /// The robots from the front.
    pub robots: Vec<RobotOutcome>,
    /// The links, from the front robot's on.
    pub links: Vec<LinkOutcome>,
    /// Deadlines; on the wall clock.
    pub deadlines: Vec<DeadlineOutcome>,
    /// What the system permitted; on the wall clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub real_time: Option<RealTime>,
    /// The recording, if there is one.
    pub recording: Option<PathBuf>,
    /// Records that did not reach the recording.
    pub lost_records: u64,
    /// How it ended.
    #[serde(skip)]
    pub verdict: Verdict,
}

/// A process of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Process {
    /// `plant`, `agent` or `recorder`.
    pub role: &'static str,
    /// An agent's robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Its identity in the system.
    pub pid: u32,
}

/// What became of a robot.
#[derive(Debug, Clone, Serialize)]
pub struct RobotOutcome {
    /// Its name.
    pub robot: String,
    /// x (m), y (m), yaw (rad) of c.
    pub final_true: Option<[f64; 3]>,
    /// Likewise by odometry; none when its agent died.
    pub final_odometry: Option<[f64; 3]>,
    /// How long each contact slid (s), [right, left].
    pub slip_time_s: Option<[f64; 2]>,
    /// How fast each contact slid at most (m/s).
    pub max_slip_m_s: Option<[f64; 2]>,
    /// The largest true spacing error from 3 s on (m); none for the front robot.
    pub max_spacing_error_m: Option<f64>,
    /// The largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: Option<f64>,
}

/// What became of the messages of a link.
#[derive(Debug, Clone, Serialize)]
pub struct LinkOutcome {
    /// The sender.
    pub from: String,
    /// The receiver.
    pub to: String,
    /// Sent.
    pub sent: u64,
    /// Left the delay line.
    pub delivered: u64,
    /// Lost on the way.
    pub lost: u64,
    /// Under way when the run ended.
    pub in_flight: u64,
    /// Delivered after a newer one.
    pub stale: u64,
}

/// What became of a loop's deadlines.
#[derive(Debug, Clone, Serialize)]
pub struct DeadlineOutcome {
    /// The process: `plant`, or the robot.
    pub process: String,
    /// `step`, `outer` or `inner`.
    #[serde(rename = "loop")]
    pub name: &'static str,
    /// Ticks that were due.
    pub ticks: u64,
    /// Ticks that were late by a period, or left out.
    pub missed: u64,
    /// The latest wake-up (s).
    pub latest_s: f64,
}

/// What the parts of a run had to say; `None` for who did not come to say it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Parts {
    pub(crate) plant: Option<PlantReport>,
    pub(crate) agents: Vec<Option<NodeReport>>,
}

impl Outcome {
    /// Puts together what the parts had to say.
    pub(crate) fn new(experiment: &Experiment, parts: &Parts) -> Self {
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
            deadlines: Vec::new(),
            real_time: None,
            recording: None,
            lost_records: 0,
            verdict: Verdict::Done,
        }
    }

    /// Writes the JSON.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_json(&self, path: &Path) -> std::io::Result<()> {
        let mut text = serde_json::to_string_pretty(self).map_err(std::io::Error::other)?;
        text.push('\n');
        std::fs::write(path, text)
    }
}

impl DeadlineOutcome {
    pub(crate) fn new(process: &str, name: &'static str, deadlines: &Deadlines) -> Self {
        Self {
            process: process.to_owned(),
            name,
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
) -> Vec<RobotOutcome> {
    let robot = |(i, setup): (usize, &slipstream_bus::RobotSetup)| {
        let truth = plant.robots.get(i);
        let agent = agents.get(i).copied().flatten();
        RobotOutcome {
            robot: setup.name.clone(),
            final_true: truth.map(|truth| truth.final_true),
            final_odometry: agent.map(|agent| agent.final_odometry),
            slip_time_s: truth.map(|truth| truth.slip_time_s),
            max_slip_m_s: truth.map(|truth| truth.max_slip_m_s),
            max_spacing_error_m: truth.and_then(|truth| truth.max_spacing_error_m),
            max_desired_speed_m_s: agent.map(|agent| agent.max_desired_speed_m_s),
        }
    };
    experiment.robots.iter().enumerate().map(robot).collect()
}

/// A link is told by both ends; where one died, by the other.
fn links(agents: &[Option<NodeReport>]) -> Vec<LinkOutcome> {
    let mut links = Vec::new();
    for from in 0..agents.len() {
        let sent = agents[from].and_then(|agent| agent.sent);
        let receiver = (from + 1) % agents.len();
        let received = agents[receiver]
            .and_then(|agent| agent.received)
            .filter(|&(ahead, _)| ahead as usize == from);
        if sent.is_none() && received.is_none() {
            continue;
        }
        let counts = received.map(|(_, counts)| counts).unwrap_or_default();
        let sent = sent.map_or(counts.received, |(_, sent)| sent);
        let name = |index: usize| robot_name(u32::try_from(index).unwrap_or(u32::MAX));
        links.push(LinkOutcome {
            from: name(from),
            to: name(receiver),
            sent,
            delivered: counts.delivered,
            lost: counts.lost,
            in_flight: sent.saturating_sub(counts.delivered + counts.lost),
            stale: counts.stale,
        });
    }
    links
}
