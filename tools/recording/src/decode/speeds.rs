//! Speeds from the poses of an odometry whose driver leaves its twist zero.

/// Differences of poses that arrive one by one.
#[derive(Debug, Default)]
pub(crate) struct PoseSpeeds {
    last: Option<(f64, [f64; 3])>,
}

impl PoseSpeeds {
    /// From the pose before to this one, x (m), y (m), yaw (rad) at `t_s`: the time in their middle (s), forward speed
    /// (m/s) and yaw rate (rad/s), exact on an arc. `None` for the first pose, for one that is not later, and for one
    /// that is not known.
    pub(super) fn push(&mut self, t_s: f64, pose: [f64; 3]) -> Option<(f64, [f64; 2])> {
        if !pose.iter().all(|own| own.is_finite()) {
            return None;
        }
        let (before_s, before) = self.last.replace((t_s, pose))?;
        let h = t_s - before_s;
        if h <= 0.0 {
            return None;
        }
        let turn = wrapped(pose[2] - before[2]);
        let middle = before[2] + turn / 2.0;
        let chord = (pose[0] - before[0]) * middle.cos() + (pose[1] - before[1]) * middle.sin();
        // half a turn's arc over its chord; 1 where it is straight
        let half = turn / 2.0;
        let arc = if half.abs() < 1e-6 {
            1.0
        } else {
            half / half.sin()
        };
        Some((before_s + h / 2.0, [chord * arc / h, turn / h]))
    }
}

/// The same angle in [-π, π) (rad).
pub fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_gives_its_speed_and_turn_rate() {
        let (v, w, h) = (0.4_f64, 1.5_f64, 0.5);
        let at = |t: f64| {
            let yaw = 3.0 + w * t;
            let r = v / w;
            let place = [r * yaw.sin(), -r * yaw.cos()];
            // drivers tell angles within half a turn
            [place[0], place[1], yaw.sin().atan2(yaw.cos())]
        };
        let mut speeds = PoseSpeeds::default();
        assert!(speeds.push(0.0, at(0.0)).is_none());
        let (t_s, found) = speeds.push(h, at(h)).unwrap();
        assert!((t_s - h / 2.0).abs() < 1e-12);
        assert!(
            (found[0] - v).abs() < 1e-9 && (found[1] - w).abs() < 1e-9,
            "{found:?}"
        );
        assert!(speeds.push(h, at(h)).is_none());
    }
}
