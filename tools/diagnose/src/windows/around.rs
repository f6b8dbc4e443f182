//! Forces that are not small: how measurements answer around the motion that the forces make, and not
//! around the one without them.
//!
//! Likely forces are sent through the plant, and answers are taken anew around where they lead, as in
//! an iterated smoother (Bell, 1994). What measurements would be without the forces, were the plant as
//! linear everywhere as it is there, is what all that looks for a force begins from.

use nalgebra::DMatrix;

use crate::windows::bench::{Bench, HELD_OUT, Node};
use crate::windows::force::{self, Answers};
use crate::windows::hypothesis::Hypothesis;
use crate::windows::misfit::Misfit;
use crate::windows::search::deviance;
use crate::windows::wander::{GROUP, Judge};
use crate::windows::window::Window;

/// How often answers are taken anew at most.
const ROUNDS: usize = 6;
/// Share of −2 ln L that a round leaves where it leads no further.
const FURTHER: f64 = 0.9;
/// Share of the usual pulses: how starts and forces cancel shows to first order alone.
const SMALL: f64 = 0.05;
/// Shares of the likely forces that are tried until measurements are met better.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];

/// The node with its residuals as they are to first order around the likeliest forces, and these
/// ready to be judged. `judge` is of the node as it is.
pub(crate) fn around(bench: &Bench, node: &Node, mut judge: Judge) -> Option<(Node, Judge)> {
    let mut seen = node.clone();
    let bends = node.hypotheses.iter().any(Hypothesis::has_play);
    if bench.lacks_motion() || bends {
        return Some((seen, judge));
    }
    let mut there = node.clone();
    let mut acting: Vec<Vec<[f64; 2]>> = vec![Vec::new(); bench.windows.len()];
    for _ in 0..ROUNDS {
        if bench.is_noise(&there) {
            break;
        }
        let wander = judge.alone()?;
        let likely = pulses(&judge.forces(&wander.level)?);
        let tried = SHARES.iter().find_map(|share| {
            let forces = towards(&acting, &likely, *share);
            let (under, moved) = under(bench, &there, &forces)?;
            let better = deviance(&moved) < FURTHER * deviance(&there);
            better.then_some((forces, under, moved))
        });
        let Some((forces, under, moved)) = tried else {
            break;
        };
        let answers = force::answers(&under, &moved, SMALL)?;
        seen = without(bench, &moved, &answers, &forces);
        judge = Judge::over(bench, &seen, answers);
        (acting, there) = (forces, moved);
    }
    Some((seen, judge))
}

/// Forces of pieces, pulse by pulse.
fn pulses(pieces: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    let windows = pieces.iter();
    let each = windows.map(|forces| forces.iter().flat_map(|force| [*force; GROUP]).collect());
    each.collect()
}

/// From forces that act already a share of the way to others.
fn towards(from: &[Vec<[f64; 2]>], to: &[Vec<[f64; 2]>], share: f64) -> Vec<Vec<[f64; 2]>> {
    let windows = from.iter().zip(to);
    let moved = windows.map(|(from, to)| {
        let at = |k: usize| from.get(k).copied().unwrap_or_default();
        let pulses = to.iter().enumerate();
        let moved = pulses.map(|(k, to)| [0, 1].map(|i| at(k)[i] + share * (to[i] - at(k)[i])));
        moved.collect()
    });
    moved.collect()
}

/// The windows under these forces, and the node there.
fn under(bench: &Bench, node: &Node, forces: &[Vec<[f64; 2]>]) -> Option<(Bench, Node)> {
    let windows = bench.windows.iter().zip(forces);
    let windows = windows.map(|(window, forces)| Window {
        forces: forces.clone(),
        ..window.clone()
    });
    let under = bench.over(windows.collect());
    let moved = moved(&under, node)?;
    Some((under, moved))
}

/// The node where forces lead that act in `under`: its windows begin anew, its parameters stay.
pub(crate) fn moved(under: &Bench, node: &Node) -> Option<Node> {
    let fit = under.posed(&node.hypotheses, &under.windows, |problem, values| {
        let begun = problem.with_free(&[]);
        let begun = begun.fit(&[], &node.fit.starts, HELD_OUT)?;
        problem.fit(values, &begun.starts, 0)
    })?;
    let hypotheses = node.hypotheses.clone();
    Some(Node { hypotheses, fit })
}

/// `node`, under forces, as if these were gone, to first order.
fn without(bench: &Bench, node: &Node, answers: &[Answers], forces: &[Vec<[f64; 2]>]) -> Node {
    let mut gone = node.clone();
    let mut all = Vec::new();
    let windows = gone.fit.linear.iter_mut().zip(answers).zip(forces);
    for ((linear, answers), forces) in windows {
        let pulses = answers.samples.len();
        let mix = DMatrix::from_fn(2 * pulses, 1, |k, _| {
            let force = forces.get(k % pulses).copied().unwrap_or_default();
            force[k / pulses]
        });
        for moved in answers.mixed(&mix, linear.residuals.len()) {
            let cells = linear.residuals.iter_mut().zip(moved);
            cells.for_each(|(cell, moved)| *cell -= moved);
        }
        all.push(linear.residuals.clone());
    }
    let memory = node.fit.misfit.memory;
    gone.fit.misfit = Misfit {
        memory,
        ..Misfit::new(&bench.windows, &all)
    };
    gone
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use crate::windows::bench::FULL;
    use crate::windows::fixture;

    use super::*;

    /// Grade of a slope that takes the robot far from where it would be on the level.
    const GRADE: f64 = 0.02;

    fn on_a_slope() -> (Bench, Node) {
        let model = RobotModel::default();
        let slope = [("grade", GRADE), ("downhill_rad", 0.0)];
        let truth = model.clone().with("floor_slope", &slope);
        let bench = fixture::bench(fixture::driven(&truth, 10.0, fixture::gentle), model);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[], &starts, FULL).unwrap();
        (bench, node)
    }

    /// What the weight pulls along the body is m g grade cos φ downhill. Pieces of 0.1 s take its mean
    /// and so miss what changes within them: a tenth is a wide margin.
    #[test]
    fn a_large_force_is_what_it_is() {
        let (bench, node) = on_a_slope();
        assert!(bench.worst(&node).1 > 30.0, "{:?}", bench.worst(&node));
        let judge = Judge::new(&bench, &node).unwrap();
        let (_, judge) = around(&bench, &node, judge).unwrap();
        let wander = judge.alone().unwrap();
        let forces = judge.forces(&wander.level).unwrap();
        let samples = force::samples(&judge.answers);
        let body = &bench.model.robot;
        let mass = body.body_mass_kg.unwrap() + 2.0 * body.wheel_mass_kg.unwrap();
        let most = mass * 9.81 * GRADE;
        let (mut off, mut count) = (0.0, 0.0);
        for (forces, samples) in forces.iter().zip(&samples) {
            let at = samples.iter().step_by(GROUP);
            for ([along, _], sampled) in forces.iter().zip(at) {
                off += (along - most * sampled.pose[2].cos()).powi(2);
                count += 1.0;
            }
        }
        let off = (off / count).sqrt();
        assert!(off < 0.1 * most, "{off} of {most} N");
    }

    #[test]
    fn what_fits_is_left_as_it_is() {
        let model = RobotModel::default();
        let bench = fixture::bench(fixture::driven(&model, 5.0, fixture::gentle), model);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[], &starts, FULL).unwrap();
        let judge = Judge::new(&bench, &node).unwrap();
        let (seen, _) = around(&bench, &node, judge).unwrap();
        let (before, after) = (&node.fit.linear[0], &seen.fit.linear[0]);
        let pairs = before.residuals.iter().zip(&after.residuals);
        assert!(pairs.filter(|(b, _)| b.is_finite()).all(|(b, a)| b == a));
    }
}
