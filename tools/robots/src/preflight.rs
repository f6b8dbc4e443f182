//! Before robots drive: what is heard of them, while nothing is told to any.

use std::time::{Duration, Instant};

use slipstream_bus::Experiment;
use slipstream_bus::record::NoRecorder;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Monotonic, WallClock};
use slipstream_recording::wrapped;

use crate::fleet::{Fleet, RobotReport};
use crate::lab::{Content, Lab};
use crate::topics::{self, Opening};

/// What was heard of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard {
    /// Its name.
    pub robot: String,
    /// What it has topics for, and the messages that came of each in a second; 0 if none came.
    pub rates_hz: Vec<(Content, f64)>,
    /// Distance of its last pose from where it has to stand at the start (m).
    pub from_start_m: Option<f64>,
    /// The same of its heading (rad), in [−π, π).
    pub from_start_rad: Option<f64>,
    /// The first message that could not be read, in words.
    pub problem: Option<String>,
}

impl Heard {
    /// The first content that was not heard.
    pub fn unheard(&self) -> Option<Content> {
        let silent = self.rates_hz.iter().find(|(_, hz)| *hz == 0.0);
        silent.map(|(content, _)| *content)
    }

    /// Whether all that is needed to drive it is heard.
    pub fn is_ready(&self) -> bool {
        self.unheard().is_none() && self.problem.is_none()
    }
}

/// Listens to the robots of an experiment for so long. Nothing is published.
///
/// # Errors
/// The network cannot be used.
pub fn listen(experiment: &Experiment, lab: &Lab, time: Duration) -> Result<Vec<Heard>, BusError> {
    let opening = Opening {
        published: Vec::new(),
        ..Fleet::opening(lab)
    };
    let mut topics = topics::open(&opening)?;
    let mut fleet = Fleet::new(experiment, lab);
    let (clock, begin) = (WallClock::new(Monotonic::now()), Instant::now());
    while begin.elapsed() < time {
        if let Some(heard) = topics.receive(Duration::from_millis(20)) {
            let arrived_ns = clock.ns_at(heard.arrived);
            fleet.hear(heard.place, &heard.payload, arrived_ns, &mut NoRecorder);
        }
    }
    let seconds = clock.now_ns() as f64 * 1e-9;
    let robots = experiment.robots.iter().zip(&lab.robots);
    let heard = robots.zip(fleet.reports());
    let heard = heard.map(|((setup, lab), report)| {
        let rate = |content| (content, report.stream(content).messages as f64 / seconds);
        let rates_hz = Content::of(lab).map(rate).collect();
        let RobotReport {
            problem, last_pose, ..
        } = report;
        let [x, y, yaw] = setup.pose;
        Heard {
            robot: lab.name.clone(),
            rates_hz,
            from_start_m: last_pose.map(|own| (own[0] - x).hypot(own[1] - y)),
            from_start_rad: last_pose.map(|own| wrapped(own[2] - yaw)),
            problem,
        }
    });
    Ok(heard.collect())
}
