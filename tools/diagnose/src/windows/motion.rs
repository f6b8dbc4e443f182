//! What measurements answer where wheels turn as they are told: no force moves such a robot, but it
//! may drive and turn otherwise than its wheels say. Motion that is added for a moment shifts and
//! turns all that comes after, as a rigid body, around where the robot was then.

use slipstream_sim::Command;

use crate::windows::bench::{Bench, Node};
use crate::windows::force::{self, Answers};
use crate::windows::simulate::{Simulation, asked};
use crate::windows::track::Sensor;
use crate::windows::window::PULSE_S;

/// Motion added for a moment.
struct Pulse {
    from_s: f64,
    /// Where the robot is in the middle of it.
    pose: [f64; 3],
    /// Speed (m/s) and turn rate (rad/s).
    motion: [f64; 2],
    /// The same at the right and the left wheel (rad/s).
    wheels: [f64; 2],
}

/// Answers of window `w` to pulses of speed and of turn rate, per m/s and per rad/s.
pub(crate) fn answers(
    bench: &Bench,
    node: &Node,
    simulation: &Simulation<'_>,
    w: usize,
) -> Answers {
    let (marks, _) = simulation.bookmarks(&node.fit.starts[w], PULSE_S);
    let residuals = &node.fit.linear[w].residuals;
    let body = &bench.model.robot;
    let [r, b] = [body.wheel_radius_m, body.half_track_m];
    let of = |[v_m_s, w_rad_s]: [f64; 2]| {
        let wheels = asked(&Command::Twist { v_m_s, w_rad_s }, r, b);
        let answers = marks.iter().map(|mark| {
            let pulse = Pulse {
                from_s: mark.t_s,
                pose: mark.pose(),
                motion: [v_m_s, w_rad_s],
                wheels,
            };
            pulse.answer(simulation, residuals)
        });
        answers.collect()
    };
    Answers {
        samples: force::sampled(bench, simulation.track, &marks),
        along: of([1.0, 0.0]),
        about: of([0.0, 1.0]),
    }
}

impl Pulse {
    /// How every residual of a window moves.
    fn answer(&self, simulation: &Simulation<'_>, residuals: &[f64]) -> Vec<f64> {
        let (track, window) = (simulation.track, simulation.window);
        let mut answer = vec![0.0; residuals.len()];
        for (which, series) in track.series.iter().enumerate() {
            let clock = series.sensor.clock();
            let width = series.sensor.width();
            for (stamp_s, values, base) in window.measured(track, which) {
                let for_s = simulation.robot.true_s(clock, stamp_s) - self.from_s;
                if for_s <= 0.0 {
                    continue;
                }
                let seen = [0, 1].map(|i| values[i] + residuals[base + i] * series.deviation[i]);
                let moved = self.moves(series.sensor, for_s, seen);
                for part in (0..width).filter(|part| moved[*part].is_finite()) {
                    answer[base + part] = moved[part] / series.deviation[part];
                }
            }
        }
        window.share(&mut answer);
        answer
    }

    /// What a sensor sees of it `for_s` after its begin, where the model sees the robot at `seen`.
    fn moves(&self, sensor: Sensor, for_s: f64, seen: [f64; 2]) -> [f64; 3] {
        let [v, turn] = self.motion;
        let over_s = for_s.min(PULSE_S);
        let now = f64::from(u8::from(for_s <= PULSE_S));
        match sensor {
            Sensor::Pose => {
                let [x, y, yaw] = self.pose;
                let (way, angle) = (v * over_s, turn * over_s);
                [
                    way * yaw.cos() - angle * (seen[1] - y),
                    way * yaw.sin() + angle * (seen[0] - x),
                    angle,
                ]
            }
            Sensor::WheelAngle => [self.wheels[0] * over_s, self.wheels[1] * over_s, 0.0],
            Sensor::WheelSpeed => [self.wheels[0] * now, self.wheels[1] * now, 0.0],
            Sensor::Odometry => [v * now, turn * now, 0.0],
            Sensor::Imu => [0.0, 0.0, turn * now],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 1e-4;
    /// When the motion is added, and when the robot is looked at (s).
    const FROM_S: f64 = 0.4;
    const SEEN_S: [f64; 3] = [0.43, 0.45, 1.7];

    /// Where a robot on a winding way is at `SEEN_S`, and at the middle of the pulse, if `more` is
    /// added to its speed (m/s) and turn rate (rad/s) from `FROM_S` on for a pulse.
    fn driven(more: [f64; 2]) -> ([[f64; 3]; 3], [f64; 3]) {
        let mut pose = [0.2, -0.1, 0.5];
        let (mut seen, mut middle) = ([[0.0; 3]; 3], [0.0; 3]);
        for k in 0..18_000_u32 {
            let t_s = f64::from(k) * STEP_S;
            let at = |when_s: f64| (t_s - when_s).abs() < STEP_S / 2.0;
            for (seen, _) in seen
                .iter_mut()
                .zip(SEEN_S)
                .filter(|(_, when_s)| at(*when_s))
            {
                *seen = pose;
            }
            if at(FROM_S + PULSE_S / 2.0) {
                middle = pose;
            }
            let acts = t_s > FROM_S - STEP_S / 2.0 && t_s < FROM_S + PULSE_S - STEP_S / 2.0;
            let [dv, dw] = more.map(|more| if acts { more } else { 0.0 });
            let (v, w) = (0.4 + dv, 0.9 * (3.0 * t_s).sin() + dw);
            let yaw = pose[2] + w * STEP_S / 2.0;
            pose[0] += v * yaw.cos() * STEP_S;
            pose[1] += v * yaw.sin() * STEP_S;
            pose[2] += w * STEP_S;
        }
        (seen, middle)
    }

    /// To first order: what is left is the bend of the way within a pulse, and squares of the change.
    #[test]
    fn poses_move_as_a_robot_that_drove_otherwise() {
        let (before, middle) = driven([0.0; 2]);
        for motion in [[0.02, 0.0], [0.0, 0.02]] {
            let pulse = Pulse {
                from_s: FROM_S,
                pose: middle,
                motion,
                wheels: [0.0; 2],
            };
            let (after, _) = driven(motion);
            for ((before, after), seen_s) in before.iter().zip(&after).zip(SEEN_S) {
                let moved = pulse.moves(Sensor::Pose, seen_s - FROM_S, [before[0], before[1]]);
                for i in 0..3 {
                    let off = moved[i] - (after[i] - before[i]);
                    assert!(off.abs() < 1.2e-5, "{motion:?} {seen_s} {i}: {off}");
                }
            }
            let far = [0, 1].map(|i| after[2][i] - before[2][i]);
            assert!(far[0].hypot(far[1]) > 4e-4, "{far:?}");
        }
    }

    #[test]
    fn wheels_and_gyro_see_it_while_it_lasts() {
        let pulse = Pulse {
            from_s: 0.0,
            pose: [0.0; 3],
            motion: [0.1, 0.4],
            wheels: [3.0, -1.0],
        };
        let moves = |sensor: Sensor, for_s: f64| pulse.moves(sensor, for_s, [0.0; 2]);
        assert_eq!(moves(Sensor::Imu, 0.02)[2], 0.4);
        assert_eq!(moves(Sensor::Imu, 0.2)[2], 0.0);
        assert_eq!(moves(Sensor::Odometry, 0.02)[..2], [0.1, 0.4]);
        assert_eq!(moves(Sensor::WheelSpeed, 0.2)[..2], [0.0, 0.0]);
        let turned = [3.0 * PULSE_S, -PULSE_S];
        assert_eq!(moves(Sensor::WheelAngle, 0.2)[..2], turned);
    }
}
