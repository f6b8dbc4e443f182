//! The force that is missing: how every measurement answers to a push at every moment, and which
//! variable the missing force follows. Where wheels turn as they are told it is a motion.
//!
//! A robot that rolls has two degrees of freedom, so that any missing force is one along the body
//! and a moment about the vertical. Both are sent through the plant, pulse by pulse; a force that is
//! some function of a variable is then a sum of columns that are there already.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use crate::windows::bench::{Bench, Node};
use crate::windows::drivers::Driver;
use crate::windows::hypothesis::Hypothesis;
use crate::windows::linear;
use crate::windows::misfit::Misfit;
use crate::windows::motion;
use crate::windows::ridge;
use crate::windows::sampled::{Sampled, is_still};
use crate::windows::simulate::{Bookmark, Pulse, Simulation};
use crate::windows::track::{Sensor, Track, geometry};
use crate::windows::wander::GROUP;
use crate::windows::window::{LOCALS, PULSE_S};

/// Charge (−2 ln L) for each number of a force.
pub(crate) const CHARGE: f64 = 6.0;

/// Accelerations of the pulses: along (m/s²) and about (rad/s²).
const PULSE: [f64; 2] = [0.2, 2.0];

/// Share of the best known number by which all are held near zero.
const HELD: f64 = 1e-4;

/// Answers of one window: for each pulse, residuals per newton and per newton metre, or per m/s and per
/// rad/s where a motion is missing.
pub(crate) struct Answers {
    /// The motion in the middle of each pulse.
    pub(crate) samples: Vec<Sampled>,
    pub(crate) along: Vec<Vec<f64>>,
    pub(crate) about: Vec<Vec<f64>>,
}

impl Answers {
    /// Answers of `rows` residuals to mixes of pulses.
    pub(crate) fn mixed(&self, mix: &DMatrix<f64>, rows: usize) -> Vec<Vec<f64>> {
        let columns = mix.column_iter().map(|shares| {
            let mut column = vec![0.0; rows];
            let answers = self.along.iter().chain(&self.about).zip(&shares);
            for (answer, share) in answers.filter(|(_, share)| **share != 0.0) {
                let cells = column.iter_mut().zip(answer);
                cells.for_each(|(cell, answer)| *cell += share * answer);
            }
            column
        });
        columns.collect()
    }
}

/// On what part of the robot a missing force acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Longitudinal,
    Yaw,
    WheelRight,
    WheelLeft,
    /// Both wheels, each after its own variable.
    Wheels,
}

impl Part {
    pub(crate) const ALL: [Self; 5] = [
        Self::Longitudinal,
        Self::Yaw,
        Self::WheelRight,
        Self::WheelLeft,
        Self::Wheels,
    ];

    /// The parts on which a force that is one function of a variable acts by itself.
    fn each(self) -> impl Iterator<Item = Self> {
        let (first, second) = match self {
            Self::Wheels => (Self::WheelRight, Some(Self::WheelLeft)),
            one => (one, None),
        };
        [first].into_iter().chain(second)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Longitudinal | Self::Wheels => "longitudinal",
            Self::Yaw => "yaw",
            Self::WheelRight => "wheel_right",
            Self::WheelLeft => "wheel_left",
        }
    }

    /// What is missing there, and its unit: a force, or a motion of wheels that turn as they are told.
    pub(crate) fn quantity(self, of_motion: bool) -> [&'static str; 2] {
        match (self, of_motion) {
            (Self::Longitudinal, false) => ["force along the body", "N"],
            (Self::Yaw, false) => ["moment about the vertical", "N m"],
            (Self::WheelRight, false) => ["torque at the right wheel", "N m"],
            (Self::WheelLeft, false) => ["torque at the left wheel", "N m"],
            (Self::Wheels, false) => ["torque at each wheel", "N m"],
            (Self::Longitudinal, true) => ["speed along the body", "m/s"],
            (Self::Yaw, true) => ["turn rate", "rad/s"],
            (Self::WheelRight, true) => ["speed of the right wheel", "rad/s"],
            (Self::WheelLeft, true) => ["speed of the left wheel", "rad/s"],
            (Self::Wheels, true) => ["speed of each wheel", "rad/s"],
        }
    }
}

/// A missing force as a function of one variable.
#[derive(Debug, Clone)]
pub(crate) struct Missing {
    pub(crate) part: Part,
    pub(crate) driver: Driver,
    /// It acts against the motion, not in one direction.
    pub(crate) against: bool,
    /// One number a basis function (N or N m).
    pub(crate) weights: Vec<f64>,
    /// −2 ln L with it, to first order.
    pub(crate) deviance: f64,
}

impl Missing {
    /// None of it.
    pub(crate) fn nothing(&self) -> Self {
        Self {
            weights: vec![0.0; self.weights.len()],
            ..self.clone()
        }
    }

    /// With this share of `step` more in its numbers.
    pub(crate) fn further(&self, step: &[f64], share: f64) -> Self {
        let pairs = self.weights.iter().zip(step);
        Self {
            weights: pairs.map(|(from, step)| from + share * step).collect(),
            ..self.clone()
        }
    }

    /// −2 ln L with it, to first order, with a charge for each number.
    fn score(&self) -> f64 {
        self.charged(self.deviance)
    }

    /// `deviance` with a charge for each number.
    pub(crate) fn charged(&self, deviance: f64) -> f64 {
        deviance + CHARGE * self.driver.numbers() as f64
    }
}

/// The answers of every window around `node`. Gears that lose touch for moments hardly change what a
/// push does, and take long to simulate: they are left out. `share` is that of the usual pulses.
pub(crate) fn answers(bench: &Bench, node: &Node, share: f64) -> Option<Vec<Answers>> {
    let engaged = node.hypotheses.iter().filter(|h| !h.has_play());
    let engaged: Vec<Hypothesis> = engaged.cloned().collect();
    bench.posed(&engaged, &bench.windows, |problem, values| {
        let robots = problem.robots(values).ok()?;
        let [mass, inertia] = inertia(bench);
        let amount = [share * PULSE[0] * mass, share * PULSE[1] * inertia];
        let windows = bench.windows.par_iter().enumerate();
        let answers = windows.map(|(w, window)| {
            let simulation = problem.simulation(window, &robots);
            if bench.lacks_motion() {
                return motion::answers(bench, node, &simulation, w);
            }
            let start = &node.fit.starts[w];
            let (marks, base) = simulation.bookmarks(start, PULSE_S);
            let answer = |mark: &Bookmark, part: usize| {
                one(&simulation, start, &base, mark, part, amount[part])
            };
            Answers {
                samples: sampled(bench, simulation.track, &marks),
                along: marks.par_iter().map(|mark| answer(mark, 0)).collect(),
                about: marks.par_iter().map(|mark| answer(mark, 1)).collect(),
            }
        });
        Some(answers.collect())
    })
}

/// Mass (kg) and yaw inertia (kg m²) of the body, or what is likely; one where a motion is missing.
pub(crate) fn inertia(bench: &Bench) -> [f64; 2] {
    if bench.lacks_motion() {
        return [1.0, 1.0];
    }
    let body = &bench.model.robot;
    let mass = body.body_mass_kg.unwrap_or(1.0);
    [mass, body.body_yaw_inertia_kg_m2.unwrap_or(0.01 * mass)]
}

fn one(
    simulation: &Simulation<'_>,
    start: &[f64; 7],
    base: &[f64],
    mark: &Bookmark,
    part: usize,
    amount: f64,
) -> Vec<f64> {
    let mut load = [0.0; 5];
    load[[0, 2][part]] = amount;
    let pulse = Pulse {
        load,
        to_s: mark.t_s + PULSE_S,
    };
    let after = simulation.resumed(start, mark, Some(pulse), |_, _| ());
    let pairs = after.iter().zip(base);
    let change = pairs.map(|(after, base)| {
        let change = (after - base) / amount;
        if change.is_finite() { change } else { 0.0 }
    });
    let mut change: Vec<f64> = change.collect();
    simulation.window.share(&mut change);
    change
}

/// What a force on one part that opposes the motion, or does not, is in force along and moment about
/// per unit; or what a motion of it is in speed and turn rate.
fn shares(
    [r, b]: [f64; 2],
    of_motion: bool,
    part: Part,
    against: bool,
    sampled: &Sampled,
) -> [f64; 2] {
    let wheel = |side: f64| match of_motion {
        true => [r / 2.0, side * r / (2.0 * b)],
        false => [1.0 / r, side * b / r],
    };
    let (shares, speed) = match part {
        Part::Longitudinal => ([1.0, 0.0], sampled.v),
        Part::Yaw => ([0.0, 1.0], sampled.w),
        Part::WheelRight | Part::Wheels => (wheel(1.0), sampled.v + b * sampled.w),
        Part::WheelLeft => (wheel(-1.0), sampled.v - b * sampled.w),
    };
    let sign = match against {
        false => 1.0,
        true if is_still(speed) => 0.0,
        true => -speed.signum(),
    };
    shares.map(|share| share * sign)
}

/// What a unit of each function of `driver` is in force along and moment about, or in speed and turn
/// rate. What acts across the centre of mass turns a robot of which the wheels do not slide.
pub(crate) fn acts(
    [r, b, ahead_m]: [f64; 3],
    of_motion: bool,
    driver: &Driver,
    part: Part,
    against: bool,
    sampled: &Sampled,
) -> Vec<(usize, [f64; 2])> {
    let mut all = Vec::new();
    for part in part.each() {
        let shares = shares([r, b], of_motion, part, against, sampled);
        let values = driver.values(sampled, part).into_iter();
        all.extend(values.map(|(function, value)| (function, shares.map(|share| share * value))));
    }
    let across = driver.across(sampled).into_iter();
    all.extend(across.map(|(function, value)| (function, [0.0, ahead_m * value])));
    all
}

/// The motion in the middle of the pulses that begin at `marks`.
pub(crate) fn sampled(bench: &Bench, track: &Track, marks: &[Bookmark]) -> Vec<Sampled> {
    let half_s = PULSE_S / 2.0;
    let times_s: Vec<f64> = marks.iter().map(|mark| mark.t_s + half_s).collect();
    let camera = track.of(Sensor::Pose).is_some();
    let headings = marks.iter().map(|mark| mark.heading(half_s));
    let otherwise: Vec<[f64; 3]> = match bench.lacks_motion() {
        _ if camera => headings
            .map(|heading| [f64::NAN, f64::NAN, heading])
            .collect(),
        // of wheels that turn as they are told the camera is left out, not absent
        true => vec![[f64::NAN; 3]; marks.len()],
        false => track
            .reckoned(&times_s, geometry(&bench.model.robot))
            .unwrap_or_else(|| vec![[f64::NAN; 3]; marks.len()]),
    };
    let pairs = times_s.iter().zip(otherwise);
    let sampled = pairs.map(|(t_s, otherwise)| Sampled::new(bench, track, *t_s, otherwise));
    sampled.collect()
}

/// The motion at every pulse of each window.
pub(crate) fn samples(answers: &[Answers]) -> Vec<Vec<Sampled>> {
    let answers = answers.iter();
    answers.map(|answers| answers.samples.clone()).collect()
}

/// What a unit of each function of `driver` is in pulses of a window: those along, then those about.
pub(crate) fn mix(
    bench: &Bench,
    samples: &[Sampled],
    driver: &Driver,
    part: Part,
    against: bool,
) -> DMatrix<f64> {
    let mut mix = DMatrix::zeros(2 * samples.len(), driver.functions());
    let body = geometry(&bench.model.robot);
    for (k, sampled) in samples.iter().enumerate() {
        let all = acts(body, bench.lacks_motion(), driver, part, against, sampled);
        for (function, [along, about]) in all {
            mix[(k, function)] += along;
            mix[(samples.len() + k, function)] += about;
        }
    }
    mix
}

/// The missing force of each of `drivers` beside `node`, the one that explains most first.
pub(crate) fn missing(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    drivers: &[Driver],
) -> Vec<Missing> {
    let kinds: Vec<(Driver, Part, bool)> = drivers
        .iter()
        .flat_map(|driver| {
            Part::ALL
                .iter()
                .flat_map(move |part| [false, true].map(|against| (driver.clone(), *part, against)))
        })
        .filter(|(driver, part, against)| driver.suits(*part, *against))
        .collect();
    let found = kinds.par_iter().filter_map(|(driver, part, against)| {
        follow(bench, node, answers, samples, driver, *part, *against)
    });
    let mut found: Vec<Missing> = found.collect();
    found.sort_by(|a, b| a.score().total_cmp(&b.score()));
    found
}

fn follow(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    driver: &Driver,
    part: Part,
    against: bool,
) -> Option<Missing> {
    let columns = columns(bench, answers, samples, driver, part, against);
    let known = node.fit.values.len();
    let mut weights = node.fit.misfit.weights();
    let mut best: Option<Missing> = None;
    for _ in 0..3 {
        let more = |w: usize| columns[w].iter().map(Vec::as_slice).collect::<Vec<_>>();
        let windows = bench.windows.iter().zip(&node.fit.linear).enumerate();
        let normals: Vec<_> = windows
            .map(|(w, (window, linear))| {
                linear.normal(window, &weights, &linear.residuals, &more(w))
            })
            .collect();
        let step = linear::step(&normals, 1e-6, |_, step| step);
        let predicted: Vec<Vec<f64>> = node
            .fit
            .linear
            .iter()
            .zip(&step.locals)
            .enumerate()
            .map(|(w, (linear, locals))| {
                linear.predicted(&linear.residuals, &more(w), locals, &step.globals)
            })
            .collect();
        let misfit = Misfit::new(&bench.windows, &predicted);
        weights = misfit.weights();
        let deviance = misfit.deviance();
        if deviance.is_finite() && best.as_ref().is_none_or(|best| deviance < best.deviance) {
            best = Some(Missing {
                part,
                driver: driver.clone(),
                against,
                weights: step.globals[known..].to_vec(),
                deviance,
            });
        }
    }
    best
}

/// Of each window, how residuals answer to a unit of each function of `driver`.
fn columns(
    bench: &Bench,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    driver: &Driver,
    part: Part,
    against: bool,
) -> Vec<Vec<Vec<f64>>> {
    let windows = answers.iter().zip(samples).zip(&bench.windows);
    let columns = windows.map(|((answers, samples), window)| {
        let mix = mix(bench, samples, driver, part, against);
        answers.mixed(&mix, window.channels.len())
    });
    columns.collect()
}

/// Columns of a missing force, and the steps of all parameters and its numbers that every other
/// window asks for, from the first and from the second on.
fn learnt(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    missing: &Missing,
) -> (Vec<Vec<Vec<f64>>>, [Vec<f64>; 2]) {
    let Missing { driver, part, .. } = missing;
    let columns = columns(bench, answers, samples, driver, *part, missing.against);
    let more = |w: usize| columns[w].iter().map(Vec::as_slice).collect::<Vec<_>>();
    let weights = node.fit.misfit.weights();
    let all = bench.windows.iter().zip(&node.fit.linear).enumerate();
    let learnt = [0, 1].map(|fold| {
        let own = all.clone().skip(fold).step_by(2);
        let own = own.map(|(w, (window, linear))| {
            linear.normal(window, &weights, &linear.residuals, &more(w))
        });
        ridge::step(&own.collect::<Vec<_>>(), node.fit.values.len())
    });
    (columns, learnt)
}

/// The missing force with the numbers that make it most like `forces`: force along (N) and moment about
/// (N m) in each piece of each window.
pub(crate) fn like(
    bench: &Bench,
    samples: &[Vec<Sampled>],
    forces: &[Vec<[f64; 2]>],
    missing: &Missing,
) -> Missing {
    let Missing { driver, part, .. } = missing;
    let count = driver.functions();
    let (mut matrix, mut slope) = (DMatrix::zeros(count, count), DVector::zeros(count));
    // a moment acts at the wheels
    let scale = [1.0, 1.0 / bench.model.robot.half_track_m];
    for (samples, forces) in samples.iter().zip(forces) {
        let mix = mix(bench, samples, driver, *part, missing.against);
        for k in 0..samples.len().min(GROUP * forces.len()) {
            for i in [0, 1] {
                let row = mix.row(i * samples.len() + k).transpose() * scale[i];
                slope += &row * (scale[i] * forces[k / GROUP][i]);
                matrix += &row * row.transpose();
            }
        }
    }
    let most = matrix.diagonal().max();
    (0..count).for_each(|i| matrix[(i, i)] += HELD * most);
    let weights = Cholesky::new(matrix).map(|factor| factor.solve(&slope));
    Missing {
        weights: weights.map_or_else(|| missing.weights.clone(), |w| w.as_slice().to_vec()),
        ..missing.clone()
    }
}

/// Step of the numbers of a missing force that all windows ask for, the effects as they are.
pub(crate) fn step(bench: &Bench, node: &Node, answers: &[Answers], missing: &Missing) -> Vec<f64> {
    let Missing { driver, part, .. } = missing;
    let samples = samples(answers);
    let columns = columns(bench, answers, &samples, driver, *part, missing.against);
    let weights = node.fit.misfit.weights();
    let windows = bench.windows.iter().zip(&node.fit.linear).zip(&columns);
    let normals = windows.map(|((window, linear), columns)| {
        let more: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let alone = linear.without_globals();
        alone.normal(window, &weights, &alone.residuals, &more)
    });
    ridge::step(&normals.collect::<Vec<_>>(), 0)
}

/// The missing force with the numbers that every other window asks for, from the first and from the
/// second on: those of which these windows say next to nothing stay near zero.
pub(crate) fn halves(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    missing: &Missing,
) -> [Missing; 2] {
    let (_, learnt) = learnt(bench, node, answers, samples, missing);
    let known = node.fit.values.len();
    learnt.map(|steps| Missing {
        weights: steps[known..].to_vec(),
        ..missing.clone()
    })
}

/// −2 ln L that a missing force brings in windows that its numbers were not fitted to: every other
/// window in turn, to first order.
pub(crate) fn held_out_gain(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    samples: &[Vec<Sampled>],
    missing: &Missing,
) -> f64 {
    let (columns, learnt) = learnt(bench, node, answers, samples, missing);
    let more = |w: usize| columns[w].iter().map(Vec::as_slice).collect::<Vec<_>>();
    let predicted = node.fit.linear.iter().enumerate().map(|(w, linear)| {
        let others = &learnt[1 - w % 2];
        linear.predicted(&linear.residuals, &more(w), &[0.0; LOCALS], others)
    });
    let predicted: Vec<Vec<f64>> = predicted.collect();
    let mut after = bench.eased(node, &predicted);
    after.memory = node.fit.misfit.memory;
    after.gain_over(&node.fit.misfit)
}
