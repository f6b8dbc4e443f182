//! Effects of one place or one moment: where to look for them.
//!
//! The force that is missing at each moment says when something happened; the wheels' contacts at
//! those moments say where.

use rayon::prelude::*;
use slipstream_sim::effects::{Info, find};

use crate::windows::bench::{Bench, Node};
use crate::windows::force::{self, Answers};
use crate::windows::hypothesis::Hypothesis;
use crate::windows::linear;
use crate::windows::sampled::Sampled;
use crate::windows::track::{CHANNELS, Sensor, geometry};
use crate::windows::window::PULSE_S;

/// Moments that are tried for a push.
const MOMENTS: usize = 3;
/// Places that are tried for a patch, and how far they lie apart (half tracks).
const PLACES: usize = 16;
const APART: f64 = 0.5;
/// Patches that are fitted a few rounds if they promise something, and in any case, and how many of
/// them at one place.
const PATCHES: usize = 16;
const AT_LEAST: usize = 4;
const A_PLACE: usize = 2;
const FITTED: usize = 8;
/// Radii (half tracks) and frictions from which patches begin.
const RADII: [f64; 3] = [0.75, 1.5, 3.0];
const FRICTIONS: [f64; 3] = [0.06, 0.12, 0.18];
/// Force that is believable where nothing shows it, as a share of the weight.
const BELIEVED: f64 = 0.05;
/// The same for the speed of a wheel over the floor.
const BELIEVED_M_S: f64 = 0.2;

/// Places and moments at which `node` leaves most unexplained.
pub(crate) fn candidates(bench: &Bench, node: &Node, excluded: &[String]) -> Vec<Hypothesis> {
    if bench.is_noise(node) || bench.lacks_motion() {
        return Vec::new();
    }
    let wanted = |id: &str| !excluded.iter().any(|known| known == id);
    let Some(answers) = force::answers(bench, node, 1.0) else {
        return Vec::new();
    };
    let mut candidates = Vec::new();
    if let Some(info) = find("push").filter(|info| wanted(info.id)) {
        candidates.extend(pushes(bench, node, &answers, info));
    }
    if let Some(info) = find("friction_patch").filter(|info| wanted(info.id)) {
        candidates.extend(patches(bench, node, &answers, info));
    }
    candidates
}

/// Pushes at the moments at which one pulse explains most.
fn pushes(bench: &Bench, node: &Node, answers: &[Answers], info: &'static Info) -> Vec<Hypothesis> {
    let [.., back] = geometry(&bench.model.robot);
    let weights = node.fit.misfit.weights();
    let windows = answers.par_iter().enumerate();
    let tried = windows.flat_map_iter(|(w, answers)| {
        let (window, linear) = (&bench.windows[w], &node.fit.linear[w]);
        let own = linear.without_globals();
        let across: Vec<Vec<f64>> = answers
            .about
            .iter()
            .map(|column| column.iter().map(|v| v * back).collect())
            .collect();
        let all: Vec<(f64, usize, usize, [f64; 2])> = (0..answers.samples.len())
            .map(|k| {
                let more = [answers.along[k].as_slice(), across[k].as_slice()];
                let normal = own.normal(window, &weights, &linear.residuals, &more);
                let step = linear::step(std::slice::from_ref(&normal), 1e-9, |_, step| step);
                let gain = normal.decrease(&step);
                (gain, w, k, [step.globals[0], step.globals[1]])
            })
            .collect();
        all
    });
    let mut tried: Vec<(f64, usize, usize, [f64; 2])> = tried.collect();
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Hypothesis> = Vec::new();
    let mut taken: Vec<(usize, f64)> = Vec::new();
    for (_, w, k, [along, across]) in tried {
        let run = bench.windows[w].run;
        let Sampled {
            t_s: at_s, pose, ..
        } = answers[w].samples[k];
        if taken
            .iter()
            .any(|(known, t_s)| *known == run && (t_s - at_s).abs() < 0.25)
        {
            continue;
        }
        taken.push((run, at_s));
        let yaw = if pose[2].is_finite() { pose[2] } else { 0.0 };
        let direction = (across.atan2(along) + yaw)
            .sin()
            .atan2((across.atan2(along) + yaw).cos());
        let values = vec![
            ("t_s", (at_s - 0.03).max(0.0)),
            ("impulse_n_s", along.hypot(across) * PULSE_S),
            ("direction_rad", direction),
        ];
        chosen.push(Hypothesis {
            only: Some(run),
            ..Hypothesis::new(info, values)
        });
        if chosen.len() == MOMENTS {
            break;
        }
    }
    chosen
}

/// Patches at the wheels' contacts where the missing force is largest.
fn patches(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    info: &'static Info,
) -> Vec<Hypothesis> {
    let mut tried: Vec<Hypothesis> = Vec::new();
    for [x, y] in places(bench, node, answers) {
        for radius in RADII.map(|radius| radius * bench.model.robot.half_track_m) {
            for friction in FRICTIONS {
                let values = vec![
                    ("x_m", x),
                    ("y_m", y),
                    ("radius_m", radius),
                    ("friction", friction),
                ];
                tried.push(Hypothesis::new(info, values));
            }
        }
    }
    let judged = tried.into_par_iter().filter_map(|hypothesis| {
        let deviance = judge(bench, node, &hypothesis)?;
        Some((deviance, hypothesis))
    });
    let mut judged: Vec<(f64, Hypothesis)> = judged.collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut chosen: Vec<Hypothesis> = Vec::new();
    for (deviance, patch) in judged {
        let here = |known: &&Hypothesis| known.values[..2] == patch.values[..2];
        let most = if deviance < node.fit.misfit.deviance() {
            PATCHES
        } else {
            AT_LEAST
        };
        if chosen.len() < most && chosen.iter().filter(here).count() < A_PLACE {
            chosen.push(patch);
        }
    }
    let fitted = chosen.into_par_iter().filter_map(|patch| {
        let mut hypotheses = node.hypotheses.clone();
        hypotheses.push(patch);
        let mut fitted = bench.fit(&hypotheses, &node.fit.starts, FITTED)?;
        Some((fitted.fit.misfit.deviance(), fitted.hypotheses.pop()?))
    });
    let mut fitted: Vec<(f64, Hypothesis)> = fitted.collect();
    fitted.sort_by(|a, b| a.0.total_cmp(&b.0));
    fitted.into_iter().take(MOMENTS).map(|(_, h)| h).collect()
}

fn judge(bench: &Bench, node: &Node, hypothesis: &Hypothesis) -> Option<f64> {
    let mut hypotheses = node.hypotheses.clone();
    hypotheses.push(hypothesis.clone());
    bench.started(node, &hypotheses)
}

/// Contacts of both wheels at the moments of the largest missing force, largest first.
fn places(bench: &Bench, node: &Node, answers: &[Answers]) -> Vec<[f64; 2]> {
    let [_, b, d] = geometry(&bench.model.robot);
    let mut moments: Vec<(f64, [f64; 3])> = Vec::new();
    for (w, forces) in over_time(bench, node, answers, &node.fit.misfit.weights())
        .into_iter()
        .enumerate()
    {
        // without a camera nobody knows where on the floor a place is
        if bench.tracks[bench.windows[w].run]
            .of(Sensor::Pose)
            .is_none()
        {
            continue;
        }
        for (k, [along, about]) in forces.into_iter().enumerate() {
            let size = along.abs().max(about.abs() / b);
            moments.push((size, answers[w].samples[k].pose));
        }
    }
    moments.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut places: Vec<[f64; 2]> = Vec::new();
    for (_, [x, y, yaw]) in moments {
        for side in [-b, b] {
            let (sin, cos) = yaw.sin_cos();
            let place = [x - d * cos + side * sin, y - d * sin - side * cos];
            let near = |p: &[f64; 2]| (p[0] - place[0]).hypot(p[1] - place[1]) < APART * b;
            if place[0].is_finite() && places.len() < PLACES && !places.iter().any(near) {
                places.push(place);
            }
        }
    }
    places
}

/// The missing force along (N) and moment about (N m) at every pulse, or speed and turn rate, kept
/// small where nothing shows it (ridge regression; Hoerl and Kennard, 1970). `weights` of the channels: 1 believes them as far
/// as their noise goes.
pub(crate) fn over_time(
    bench: &Bench,
    node: &Node,
    answers: &[Answers],
    weights: &[f64; CHANNELS],
) -> Vec<Vec<[f64; 2]>> {
    let body = &bench.model.robot;
    let weight = 9.81 * body.body_mass_kg.unwrap_or(1.0);
    let b = body.half_track_m;
    let believed = match bench.lacks_motion() {
        true => [BELIEVED_M_S, BELIEVED_M_S / b],
        false => [BELIEVED * weight, BELIEVED * weight * b],
    };
    let windows = answers.par_iter().enumerate();
    let forces = windows.map(|(w, answers)| {
        let linear = node.fit.linear[w].without_globals();
        let columns = answers.along.iter().chain(&answers.about);
        let more: Vec<&[f64]> = columns.map(Vec::as_slice).collect();
        let mut normal = linear.normal(&bench.windows[w], weights, &linear.residuals, &more);
        let count = answers.samples.len();
        normal.believe(|i| 1.0 / believed[usize::from(i >= count)].powi(2));
        let step = linear::step(std::slice::from_ref(&normal), 1e-9, |_, step| step);
        (0..count)
            .map(|k| [step.globals[k], step.globals[count + k]])
            .collect()
    });
    forces.collect()
}
