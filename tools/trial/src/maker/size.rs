//! How large a concealed effect is, in the only unit that fits all: what the recording can know of it.
//!
//! The recording is cut into windows of 5 s. In each the start is free: what another start of the
//! window could explain counts for nobody. Predictions are clean, by the same simulator.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use slipstream_bus::{EffectSpec, Parameter, RobotModel};

use super::drive::Actor;
use super::scene::{Eye, Scene};
use super::sensors::{IMU_M_S2, IMU_RAD_S, POSE_M, POSE_RAD, Sensors, Stream, between};
use crate::plant::{Physics, Plant, State, Strange};

/// Step of these predictions (s).
const STEP_S: f64 = 5e-4;

/// A robot as a prediction sees it.
struct Guess {
    plant: Plant,
    sensors: Sensors,
}

impl Guess {
    fn new(scene: &Scene, model: &RobotModel, strange: Option<Strange>) -> Result<Self, String> {
        let mut physics = Physics::new(model)?;
        physics.strange.extend(strange);
        let sensors = Sensors::new(&model.effects, physics.grade);
        Ok(Self {
            plant: Plant::new(physics, scene.told.quantity(), STEP_S),
            sensors,
        })
    }
}

/// What a recording can know of the effects of one robot.
pub(crate) struct Sizes {
    /// Nats by which the truth beats the model without effect `i`, for each.
    pub(crate) gains: Vec<f64>,
    /// Least deviation of each numeric parameter of each effect, all of them free together; counts
    /// with the deviation of their rounding.
    pub(crate) deviations: Vec<Vec<(String, f64)>>,
    /// The same gain for what the vocabulary does not hold.
    pub(crate) strange: f64,
}

/// Judges what is concealed in robot `i`.
///
/// # Errors
/// A model that cannot move.
pub(crate) fn sizes(scene: &Scene, i: usize, actor: &Actor) -> Result<Sizes, String> {
    let hidden = &scene.robots[i].hidden;
    let strange = scene.robots[i].strange;
    let model = scene.model(i);
    let truth = Guess::new(scene, &model, strange)?;
    let look = Look {
        actor,
        counts: counts(scene),
        eye: scene.robots[i].eye,
    };
    let windows = look.predict(&truth, None);
    let nudged: Vec<Vec<DVector<f64>>> = (0..NUDGES)
        .map(|nudge| look.predict(&truth, Some(nudge)))
        .collect();
    // how much more than one count, the deviation that gains are told in, a count really says
    let [blunt, sharp] = [1.0, 12f64.sqrt()].map(|scale| look.starts(&windows, &nudged, scale));
    let away = |guess: &Guess, starts: &[Start]| -> Vec<DVector<f64>> {
        let other = look.predict(guess, None);
        let pairs = windows.iter().zip(&other).zip(starts);
        pairs
            .map(|((one, other), start)| start.left(one - other))
            .collect()
    };
    let half_square = |parts: &[DVector<f64>]| parts.iter().map(|p| p.norm_squared() / 2.0).sum();
    let mut gains = Vec::new();
    let mut columns: Vec<Vec<DVector<f64>>> = Vec::new();
    for effect in hidden {
        let without = swapped(&model, effect, listed(&scene.nominal, effect));
        gains.push(half_square(&away(
            &Guess::new(scene, &without, strange)?,
            &blunt,
        )));
        for (at, (_, value)) in effect.parameters.iter().enumerate() {
            if let Parameter::Number(number) = value {
                let by = 1e-3 * number.abs().max(1e-2);
                let other = swapped(&model, effect, Some(&moved(effect, at, number + by)));
                let column = away(&Guess::new(scene, &other, strange)?, &sharp);
                columns.push(column.into_iter().map(|part| part / by).collect());
            }
        }
    }
    let strange = match strange {
        None => 0.0,
        Some(_) => half_square(&away(&Guess::new(scene, &model, None)?, &blunt)),
    };
    let deviations = named(hidden, &least(&columns));
    Ok(Sizes {
        gains,
        deviations,
        strange,
    })
}

fn counts(scene: &Scene) -> f64 {
    scene
        .nominal
        .encoder
        .as_ref()
        .map_or(1856.0, |encoder| f64::from(encoder.counts_per_rev))
}

fn listed<'a>(model: &'a RobotModel, effect: &EffectSpec) -> Option<&'a EffectSpec> {
    model
        .effects
        .iter()
        .find(|listed| listed.effect == effect.effect)
}

/// The model with another one in the place of an effect, or with none.
fn swapped(model: &RobotModel, effect: &EffectSpec, other: Option<&EffectSpec>) -> RobotModel {
    let mut model = model.clone();
    if let Some(at) = model.effects.iter().position(|own| own == effect) {
        model.effects.remove(at);
    }
    model.effects.extend(other.cloned());
    model
}

fn moved(effect: &EffectSpec, at: usize, to: f64) -> EffectSpec {
    let mut effect = effect.clone();
    effect.parameters[at].1 = Parameter::Number(to);
    effect
}

fn named(hidden: &[EffectSpec], least: &[f64]) -> Vec<Vec<(String, f64)>> {
    let mut least = least.iter();
    let numbers = |effect: &EffectSpec| {
        let numbers = effect
            .parameters
            .iter()
            .filter(|(_, value)| matches!(value, Parameter::Number(_)));
        numbers
            .filter_map(|(name, _)| Some((name.clone(), *least.next()?)))
            .collect()
    };
    hidden.iter().map(numbers).collect()
}

/// Deviations from the information that the columns hold together (Cramér, Rao).
fn least(columns: &[Vec<DVector<f64>>]) -> Vec<f64> {
    let count = columns.len();
    let information: DMatrix<f64> = DMatrix::from_fn(count, count, |a, b| {
        columns[a]
            .iter()
            .zip(&columns[b])
            .map(|(one, other)| one.dot(other))
            .sum::<f64>()
    });
    let scale: Vec<f64> = (0..count)
        .map(|a| information[(a, a)].sqrt().max(1e-300))
        .collect();
    let even = DMatrix::from_fn(count, count, |a, b| {
        information[(a, b)] / (scale[a] * scale[b])
    });
    let inverse = even.try_inverse();
    (0..count)
        .map(|a| {
            inverse
                .as_ref()
                .map_or(f64::INFINITY, |i| i[(a, a)].max(0.0).sqrt() / scale[a])
        })
        .collect()
}

/// What other starts of one window do.
struct Start {
    /// Factor on each row: what a count says.
    scale: DVector<f64>,
    /// An orthonormal basis.
    basis: DMatrix<f64>,
}

impl Start {
    /// What no other start explains.
    fn left(&self, residual: DVector<f64>) -> DVector<f64> {
        let residual = residual.component_mul(&self.scale);
        &residual - &self.basis * (self.basis.transpose() * &residual)
    }
}

/// One robot's looks, as predictions are compared at them.
struct Look<'a> {
    actor: &'a Actor,
    counts: f64,
    eye: Eye,
}

impl Look<'_> {
    /// What each window would hold by `guess`, in noise deviations, wheels first; started elsewhere
    /// where asked.
    fn predict(&self, guess: &Guess, nudge: Option<usize>) -> Vec<DVector<f64>> {
        let windows = self.windows();
        windows
            .map(|(start, end_s)| self.window(guess, start, end_s, nudge))
            .collect()
    }

    /// The state at each window's start, and its end (s).
    fn windows(&self) -> impl Iterator<Item = (&State, f64)> {
        let kept = &self.actor.trace.kept;
        let ends = kept
            .iter()
            .skip(1)
            .map(|state| state.t_s)
            .chain([f64::INFINITY]);
        kept.iter().zip(ends)
    }

    /// What other starts of each window do, and other phases of the counts.
    fn starts(
        &self,
        windows: &[DVector<f64>],
        nudged: &[Vec<DVector<f64>>],
        count: f64,
    ) -> Vec<Start> {
        let bounds: Vec<[f64; 2]> = self
            .windows()
            .map(|(start, end_s)| [start.t_s, end_s])
            .collect();
        let start = |(at, window): (usize, &DVector<f64>)| {
            let wheels = 2 * self.due(Stream::Wheels, bounds[at]).count();
            let rows = |value: &dyn Fn(usize) -> f64| {
                DVector::from_iterator(window.len(), (0..window.len()).map(value))
            };
            let phase =
                |wheel: usize| rows(&|row| f64::from(u8::from(row < wheels && row % 2 == wheel)));
            let scale = rows(&|row| if row < wheels { count } else { 1.0 });
            let moved = nudged
                .iter()
                .map(|nudged| (&nudged[at] - window).component_mul(&scale));
            let columns: Vec<DVector<f64>> = moved.chain([phase(0), phase(1)]).collect();
            let basis = orthonormal(columns.into_iter(), window.len());
            Start { scale, basis }
        };
        windows.iter().enumerate().map(start).collect()
    }

    /// Which looks of a stream belong to a window. The first of it are left out: by another clock
    /// they might lie before its start.
    fn due(&self, stream: Stream, [from_s, end_s]: [f64; 2]) -> impl Iterator<Item = f64> {
        let looks = self.actor.trace.looks.0[stream as usize].iter().copied();
        looks.filter(move |t_s| (from_s + CLOCKS_S..end_s).contains(t_s))
    }

    fn window(
        &self,
        guess: &Guess,
        start: &State,
        end_s: f64,
        nudge: Option<usize>,
    ) -> DVector<f64> {
        let commands = &self.actor.commands;
        let mut state = guess.plant.adopt(start, commands);
        let stands = state.velocity.iter().all(|value| value.abs() < 1e-9);
        // what stands is known not to move
        if let Some(nudge) = nudge.filter(|nudge| *nudge < PLACES || !stands) {
            guess.plant.nudge(&mut state, nudge, NUDGE);
        }
        // by this guess's clocks, latest first
        let mut due = [Stream::Wheels, Stream::Pose, Stream::Imu].map(|stream| {
            let stamps = self.due(stream, [start.t_s, end_s]);
            let stamps = stamps.map(|t_s| self.actor.trace.sensors.stamp_s(stream, t_s));
            let mut times: Vec<f64> = stamps
                .map(|stamp| guess.sensors.true_s(stream, stamp))
                .collect();
            times.reverse();
            times
        });
        let last_s = due
            .iter()
            .filter_map(|times| times.first().copied())
            .fold(start.t_s, f64::max);
        let mut rows = [Vec::new(), Vec::new(), Vec::new()];
        guess
            .plant
            .advance(commands, &mut state, last_s, |before, after| {
                for (stream, times) in due.iter_mut().enumerate() {
                    while let Some(t_s) = times.pop_if(|t_s| *t_s <= after.t_s) {
                        let seen = between(before, after, t_s.max(before.t_s));
                        self.rows(guess, stream, &seen, &mut rows[stream]);
                    }
                }
            });
        for (stream, times) in due.iter().enumerate() {
            for _ in times {
                self.rows(guess, stream, &state, &mut rows[stream]);
            }
        }
        DVector::from_vec(rows.concat())
    }

    fn rows(&self, guess: &Guess, stream: usize, state: &State, rows: &mut Vec<f64>) {
        match stream {
            0 => {
                let angles = guess.sensors.angles(state);
                rows.extend(angles.map(|angle| angle * self.counts / TAU));
            }
            1 => {
                let [x, y, yaw] = guess.sensors.pose(state);
                rows.extend([x / POSE_M, y / POSE_M]);
                if self.eye == Eye::Pose {
                    rows.push(yaw / POSE_RAD);
                }
            }
            _ => {
                let [along, across, rate] = guess.sensors.inertial(state);
                rows.extend([along / IMU_M_S2, across / IMU_M_S2, rate / IMU_RAD_S]);
            }
        }
    }
}

/// Gram and Schmidt's, twice for rounding's sake; what depends on others is left out.
fn orthonormal(columns: impl Iterator<Item = DVector<f64>>, rows: usize) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for column in columns {
        let mut rest = column.clone();
        for _ in 0..2 {
            for known in &basis {
                rest -= known * known.dot(&rest);
            }
        }
        if rest.norm() > 1e-6 * column.norm() {
            basis.push(rest.normalize());
        }
    }
    DMatrix::from_fn(rows, basis.len(), |row, column| basis[column][row])
}

/// Clocks and latencies move looks by less than this (s).
const CLOCKS_S: f64 = 0.2;
/// Parts of a start: x, y, yaw, surge, yaw rate; and by how much each is moved (m, rad, 1/s).
const NUDGES: usize = 5;
const PLACES: usize = 3;
const NUDGE: f64 = 1e-5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_start_explains_counts_for_nobody() {
        let columns = [
            DVector::from_vec(vec![1.0, 1.0, 0.0]),
            DVector::from_vec(vec![2.0, 2.0, 0.0]),
        ];
        let basis = orthonormal(columns.into_iter(), 3);
        assert_eq!(basis.ncols(), 1);
        let start = Start {
            scale: DVector::from_element(3, 1.0),
            basis,
        };
        let rest = start.left(DVector::from_vec(vec![3.0, 3.0, 4.0]));
        assert!((rest.norm_squared() - 16.0).abs() < 1e-12);
    }

    #[test]
    fn deviations_are_cramers_and_raos() {
        let column = |values: [f64; 2]| vec![DVector::from_vec(values.to_vec())];
        // two parameters of correlation 0.6: 1 / √(1 − 0.36) larger than each alone
        let least = least(&[column([2.0, 0.0]), column([0.6, 0.8])]);
        assert!((least[0] - 0.5 / 0.8).abs() < 1e-12);
        assert!((least[1] - 1.0 / 0.8).abs() < 1e-12);
    }
}
