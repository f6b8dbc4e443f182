//! Open-loop simulation of the plant with a sequence of commands.

use slipstream_sim::{Command as PlantCommand, Robot as Plant, State, Stream};

use crate::recording::Robot;

/// Longest step of the simulation (s).
const MAX_STEP_S: f64 = 1e-3;
/// Time between two samples (s).
const SAMPLE_S: f64 = 5e-3;
/// How long the last command holds at most (s); pose or wheels may have a stray late time.
const MAX_HOLD_S: f64 = 1.0;

/// What the sensors report of the simulated state at one time, without noise. Pairs are [right, left].
pub(super) struct Sample {
    /// Time stamps of pose, wheels and inertial sensor (s).
    pub(super) stamps_s: [f64; 3],
    /// Pose as a camera reports it for c: x (m), y (m), yaw (rad).
    pub(super) pose: [f64; 3],
    /// Specific force forward and to the left (m/s²), yaw rate (rad/s).
    pub(super) inertial: [f64; 3],
    /// Wheel angles by the encoders (rad).
    pub(super) angle: [f64; 2],
    /// Wheel speeds by the encoders (rad/s).
    pub(super) speed: [f64; 2],
    /// Forward speed (m/s) and yaw rate (rad/s) by the encoders and the nominal model.
    pub(super) odometry: [f64; 2],
}

impl Sample {
    /// Time stamp by a stream (s).
    pub(super) fn stamp_s(&self, stream: Stream) -> f64 {
        self.stamps_s[stream as usize]
    }
}

/// Simulates from the start pose of c to the last row, but not beyond `until_s`.
pub(super) fn simulate(
    plant: &Plant,
    robot: &Robot,
    start_pose: [f64; 3],
    commands: &[(f64, PlantCommand)],
    until_s: f64,
) -> Vec<Sample> {
    let start_s = commands.first().map_or(0.0, |(t_s, _)| *t_s);
    let end_s = end_time_s(robot, commands).min(until_s);
    let mut state = plant.start(start_pose);
    let mut samples = vec![sample(plant, start_s, &state)];
    let mut next_sample_s = start_s + SAMPLE_S;
    for (i, (from_s, command)) in commands.iter().enumerate() {
        let next = commands.get(i + 1).map_or(end_s, |(t_s, _)| *t_s);
        let to_s = next.min(end_s);
        let steps = ((to_s - from_s) / MAX_STEP_S).ceil().max(0.0);
        let step_s = if steps > 0.0 {
            (to_s - from_s) / steps
        } else {
            0.0
        };
        for k in 0..steps as u64 {
            let t_s = from_s + k as f64 * step_s;
            plant.step(&mut state, t_s - start_s, step_s, command);
            if t_s + step_s >= next_sample_s {
                samples.push(sample(plant, t_s + step_s, &state));
                next_sample_s = t_s + step_s + SAMPLE_S;
            }
        }
    }
    samples
}

/// The last time of commands, pose and wheels (s), but at most [`MAX_HOLD_S`] after the last command.
fn end_time_s(robot: &Robot, commands: &[(f64, PlantCommand)]) -> f64 {
    let last = commands.last().map_or(0.0, |(t_s, _)| *t_s);
    let ends = [
        robot.pose.as_ref().and_then(|s| s.t_s.last().copied()),
        robot.wheels.as_ref().and_then(|s| s.t_s.last().copied()),
    ];
    ends.into_iter()
        .flatten()
        .fold(last, f64::max)
        .min(last + MAX_HOLD_S)
}

fn sample(plant: &Plant, t_s: f64, state: &State) -> Sample {
    let speed = plant.measured_speed(state);
    Sample {
        stamps_s: [Stream::Pose, Stream::Wheels, Stream::Imu].map(|own| plant.stamp_s(own, t_s)),
        pose: plant.measured_pose(state.pose()),
        inertial: plant.measured_inertial(state),
        angle: plant.measured_angle(state),
        speed,
        odometry: plant.odometry(speed),
    }
}
