//! Two recordings of one experiment beside each other, robot by robot: a run with real robots and a simulated one, or
//! two simulated ones.
//!
//! Time 0 of both is the same instant: the start of the run. Robots are matched by their names. Poses and wheels are read
//! as a diagnosis reads them ([`mended`](crate::mended())), so that counters run on and lost references are left out.

mod answer;
mod experiment;
mod headline;
mod path;
mod places;
mod rolled;
mod seen;
mod slip;
mod spacing;

use slipstream_bus::RobotModel;

pub use answer::{
    Both, DelayPercentiles, Lines, LinkPair, PathApart, RobotPair, Slip, SlipPair, SpacingError,
    SpacingPair, StagePair, TwoRuns,
};
pub use experiment::Experiment;

use self::headline::headline;
use self::seen::Seen;
use crate::mended::mended;
use crate::recording::Recording;

/// One of the two recordings.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// What the answer calls it.
    pub name: &'a str,
    /// The recording.
    pub recording: &'a Recording,
    /// What its run was to do, if that came with it.
    pub experiment: Option<&'a Experiment>,
}

/// Why two recordings cannot stand beside each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TwoRunsError {
    /// No robot is in both.
    #[error("have no robot in common: {}, and {}", .real.join(", "), .simulated.join(", "))]
    NoCommonRobot {
        /// The robots of the real one.
        real: Vec<String>,
        /// The robots of the simulated one.
        simulated: Vec<String>,
    },
    /// They cover no time together. The times are those of the robots in both.
    #[error("do not overlap in time: {:.2} to {:.2} s, and {:.2} to {:.2} s", .real[0], .real[1], .simulated[0], .simulated[1])]
    NoCommonTime {
        /// First and last time of the real one (s).
        real: [f64; 2],
        /// First and last time of the simulated one (s).
        simulated: [f64; 2],
    },
}

/// Compares a run with real robots and the simulation of the same experiment, without what the links between robots did
/// ([`TwoRuns::with_links`]).
///
/// `model_of` gives the model of each robot; without one, the model that came with its recording is used, else that of the
/// other recording. A follower's spacing error is asked of the experiment of its recording, else of the other one's.
///
/// # Errors
/// If no robot is in both recordings, or if they do not overlap in time.
pub fn compare_runs(
    real: Run<'_>,
    simulated: Run<'_>,
    model_of: impl Fn(&str) -> Option<RobotModel>,
) -> Result<TwoRuns, TwoRunsError> {
    let names = common_robots(real.recording, simulated.recording)?;
    let span_s = common_span_s(real.recording, simulated.recording, &names)?;
    let runs = [real, simulated];
    let model = |side: usize, name: &str| {
        let came_with = |side: usize| runs[side].recording.model.clone();
        let known = model_of(name).or_else(|| came_with(side));
        known.or_else(|| came_with(1 - side))
    };
    let seen = [0, 1].map(|side| {
        let (recording, _) = mended(runs[side].recording, &|name| model(side, name));
        let robots = names.iter().filter_map(|name| recording.robot(name));
        let robots = robots.map(|robot| Seen::of(robot, model(side, &robot.name).as_ref()));
        robots.collect::<Vec<Seen>>()
    });
    let experiment = [0, 1].map(|side| runs[side].experiment.or(runs[1 - side].experiment));
    let spacing_m = experiment.map(|own| own?.spacing_m);
    let pair = |(index, name): (usize, &String)| {
        let own = [&seen[0][index], &seen[1][index]];
        let ahead = ahead(simulated.recording, name);
        let ahead = ahead.and_then(|ahead| names.iter().position(|own| *own == ahead));
        let spacing = ahead.map_or_else(Default::default, |ahead| {
            let ahead = [&seen[0][ahead], &seen[1][ahead]];
            [0, 1].map(|side| {
                let (ahead, own) = (&ahead[side].smooth, &own[side].smooth);
                spacing_m[side].map_or_else(Vec::new, |m| spacing::errors(ahead, own, m, span_s))
            })
        });
        RobotPair {
            robot: name.clone(),
            path: path::apart(own, span_s),
            spacing: ahead.and_then(|ahead| spacing::pair(&names[ahead], spacing_m, &spacing)),
            slip: slip::pair(own, span_s),
            lines: path::lines(own, spacing, span_s),
        }
    };
    let robots = names.iter().enumerate().map(pair).collect();
    Ok(TwoRuns::new(runs, span_s, robots))
}

impl TwoRuns {
    fn new([real, simulated]: [Run<'_>; 2], span_s: [f64; 2], robots: Vec<RobotPair>) -> Self {
        let all = real.recording.robots.iter();
        let all = all.chain(&simulated.recording.robots);
        let is_left_out = |name: &&String| robots.iter().all(|own| own.robot != **name);
        let left_out = all.map(|robot| &robot.name).filter(is_left_out);
        let mut answer = Self {
            format: 1,
            headline: String::new(),
            real: real.name.to_owned(),
            simulated: simulated.name.to_owned(),
            span_s,
            left_out: left_out.cloned().collect(),
            robots,
            links: Vec::new(),
        };
        answer.headline = headline(&answer);
        answer
    }

    /// The same with what the links between the robots did.
    #[must_use]
    pub fn with_links(mut self, links: Vec<LinkPair>) -> Self {
        self.links = links;
        self.headline = headline(&self);
        self
    }
}

/// The robot that the plant of a run takes as the one ahead: that before it in the order of the run.
fn ahead<'a>(recording: &'a Recording, name: &str) -> Option<&'a str> {
    let place = recording.robots.iter().position(|own| own.name == name)?;
    let ahead = recording.robots.get(place.checked_sub(1)?)?;
    Some(&ahead.name)
}

/// Names of the robots in both, in the order of the simulated run.
fn common_robots(real: &Recording, simulated: &Recording) -> Result<Vec<String>, TwoRunsError> {
    let names = |recording: &Recording| -> Vec<String> {
        let robots = recording.robots.iter();
        robots.map(|robot| robot.name.clone()).collect()
    };
    let (real, simulated) = (names(real), names(simulated));
    let is_common = |name: &&String| real.contains(name);
    let common: Vec<String> = simulated.iter().filter(is_common).cloned().collect();
    if common.is_empty() {
        return Err(TwoRunsError::NoCommonRobot { real, simulated });
    }
    Ok(common)
}

/// First and last time that both recordings have of these robots (s).
fn common_span_s(
    real: &Recording,
    simulated: &Recording,
    names: &[String],
) -> Result<[f64; 2], TwoRunsError> {
    let span = |recording: &Recording| {
        let robots = names.iter().filter_map(|name| recording.robot(name));
        let stamps = robots.flat_map(|robot| robot.stamps().collect::<Vec<_>>());
        let ends = stamps.filter_map(|t_s| Some([*t_s.first()?, *t_s.last()?]));
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, own| {
            [all[0].min(own[0]), all[1].max(own[1])]
        })
    };
    let (real, simulated) = (span(real), span(simulated));
    let common = [real[0].max(simulated[0]), real[1].min(simulated[1])];
    if common[0] < common[1] {
        Ok(common)
    } else {
        Err(TwoRunsError::NoCommonTime { real, simulated })
    }
}
