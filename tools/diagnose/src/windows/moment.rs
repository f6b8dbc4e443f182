//! A missing force moment by moment, as figures show it.

use rayon::prelude::*;

use crate::windows::bench::{Bench, Node};
use crate::windows::force::{self, Answers, Part};
use crate::windows::local;
use crate::windows::sampled::Sampled;
use crate::windows::track::CHANNELS;

/// A missing force at one moment.
pub(crate) struct Moment {
    pub(crate) run: usize,
    pub(crate) sampled: Sampled,
    /// Along the body (N) and about the vertical (N m).
    pub(crate) force: [f64; 2],
}

/// The missing force at every pulse around `node`.
pub(crate) fn moments(bench: &Bench, node: &Node) -> Option<Vec<Moment>> {
    let answers: Vec<Answers> = force::answers(bench, node, 1.0)?;
    let forces = local::over_time(bench, node, &answers, &[1.0; CHANNELS]);
    let windows = bench.windows.par_iter().zip(&answers).zip(forces);
    let moments = windows.flat_map_iter(|((window, answers), forces)| {
        let pulses = answers.samples.iter().zip(forces);
        pulses.map(|(sampled, force)| Moment {
            run: window.run,
            sampled: *sampled,
            force,
        })
    });
    Some(moments.collect())
}

/// What a missing force and moment are on one part of the robot (N, N m): along the body, about the
/// vertical, or torques of the wheels that make both. Or speed and turn rate (m/s, rad/s), and speeds
/// of wheels.
pub(crate) fn acting_on(bench: &Bench, part: Part, moment: &Moment) -> f64 {
    let body = &bench.model.robot;
    let [r, b] = [body.wheel_radius_m, body.half_track_m];
    let [along, about] = moment.force;
    match part {
        Part::Longitudinal => along,
        Part::Yaw => about,
        Part::WheelRight | Part::Wheels if bench.lacks_motion() => (along + about * b) / r,
        Part::WheelLeft if bench.lacks_motion() => (along - about * b) / r,
        Part::WheelRight | Part::Wheels => r * (along + about / b) / 2.0,
        Part::WheelLeft => r * (along - about / b) / 2.0,
    }
}

/// The missing force on a part in words, with its unit.
pub(crate) fn quantity(bench: &Bench, part: Part) -> String {
    let [what, unit] = part.quantity(bench.lacks_motion());
    format!("missing {what} ({unit})")
}
