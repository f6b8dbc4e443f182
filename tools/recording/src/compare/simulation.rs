//! Open loop.

use slipstream_sim::{Command as Told, Robot as Plant, State};

use crate::recording::Robot;

/// Longest step of the simulation (s).
const STEP_S: f64 = 1e-3;
/// Time between the simulated samples that are kept (s).
const SAMPLE_S: f64 = 5e-3;

/// A simulated state at a time (s).
pub(super) struct Sample {
    pub(super) t_s: f64,
    pub(super) pose: [f64; 3],
    pub(super) velocity: [f64; 3],
    pub(super) acceleration: [f64; 2],
    pub(super) angle: [f64; 2],
    pub(super) speed: [f64; 2],
}

/// Simulates from `start`, no longer than to `until_s`.
pub(super) fn simulate(
    plant: &Plant,
    robot: &Robot,
    start: [f64; 3],
    commands: &[(f64, Told)],
    until_s: f64,
) -> Vec<Sample> {
    let start_s = commands.first().map_or(0.0, |(t_s, _)| *t_s);
    let last = commands.last().map_or(0.0, |(t_s, _)| *t_s);
    let ends = [
        robot.pose.as_ref().and_then(|s| s.t_s.last().copied()),
        robot.wheels.as_ref().and_then(|s| s.t_s.last().copied()),
    ];
    // The last command holds for as long as anything was seen, but not for a stray stamp.
    let end_s = ends
        .into_iter()
        .flatten()
        .fold(last, f64::max)
        .min(last + 1.0);
    let end_s = end_s.min(until_s);
    let mut state = plant.start(start);
    let mut samples = vec![sample(plant, start_s, &state)];
    let mut next_sample_s = start_s + SAMPLE_S;
    for (i, (from_s, told)) in commands.iter().enumerate() {
        let next = commands.get(i + 1).map_or(end_s, |(t_s, _)| *t_s);
        let to_s = next.min(end_s);
        let steps = ((to_s - from_s) / STEP_S).ceil().max(0.0);
        let step_s = if steps > 0.0 {
            (to_s - from_s) / steps
        } else {
            0.0
        };
        for k in 0..steps as u64 {
            let t_s = from_s + k as f64 * step_s;
            plant.step(&mut state, t_s - start_s, step_s, told);
            if t_s + step_s >= next_sample_s {
                samples.push(sample(plant, t_s + step_s, &state));
                next_sample_s = t_s + step_s + SAMPLE_S;
            }
        }
    }
    samples
}

fn sample(plant: &Plant, t_s: f64, state: &State) -> Sample {
    let [along, across, _] = state.acceleration();
    Sample {
        t_s,
        pose: state.pose(),
        velocity: state.velocity(),
        acceleration: [along, across],
        angle: plant.seen_angle(state),
        speed: state.wheel_speed(),
    }
}
