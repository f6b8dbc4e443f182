//! The equations of motion of a robot whose wheels roll, in the two velocities that rolling leaves:
//! ν = N [u, φ̇] (Eq. 1), and with it Nᵀ M N a = Nᵀ F.

use crate::parts::scalar::{Pair, Scalar, Vector};

/// Lengths and masses of a robot that its rolling motion depends on.
pub(super) struct Body<S> {
    /// m (kg).
    pub(super) mass: S,
    /// Mass times its place, forward and to the left (kg m).
    pub(super) first_moment: Pair<S>,
    /// I (kg m²).
    pub(super) yaw_inertia: S,
    /// I_wy (kg m²).
    pub(super) wheel_inertia: S,
    /// 1 − s of each wheel: what slip leaves of its way (1).
    pub(super) travel: Pair<S>,
    /// r of each wheel, b and d (m).
    pub(super) radius: Pair<S>,
    pub(super) half_track: S,
    pub(super) com_to_axle: S,
}

/// A robot reduced to surge and yaw rate.
#[derive(Debug, Clone)]
pub(crate) struct RollingMotion<S> {
    /// 1 / r of each wheel (1/m).
    per_radius: Pair<S>,
    /// b / r of the right wheel and −b / r of the left (1).
    turn: Pair<S>,
    /// d (m).
    com_to_axle: S,
    /// Nᵀ M N: over surge, over both, over yaw rate.
    inertia: [S; 3],
}

impl<S: Scalar> RollingMotion<S> {
    pub(super) fn new(robot: &Body<S>) -> Self {
        let (m, [sx, sy], d) = (robot.mass, robot.first_moment, robot.com_to_axle);
        let per_radius = robot.radius.map(|r| r.recip());
        let b = robot.half_track;
        let turn = [b * per_radius[0], -b * per_radius[1]];
        let wheels = robot.travel.map(|travel| robot.wheel_inertia * travel);
        let sum = |of: [S; 2]| of[0] * wheels[0] + of[1] * wheels[1];
        Self {
            inertia: [
                m + sum([0, 1].map(|i| per_radius[i] * per_radius[i])),
                sum([0, 1].map(|i| per_radius[i] * turn[i])) - sy,
                m * d * d
                    + sx * d * 2.0
                    + robot.yaw_inertia
                    + sum([0, 1].map(|i| turn[i] * turn[i])),
            ],
            per_radius,
            turn,
            com_to_axle: d,
        }
    }

    /// N [u, φ̇].
    #[inline]
    pub(crate) fn full(&self, [surge, yaw]: Pair<S>) -> Vector<S> {
        Vector::from([
            surge,
            self.com_to_axle * yaw,
            yaw,
            self.per_radius[0] * surge + self.turn[0] * yaw,
            self.per_radius[1] * surge + self.turn[1] * yaw,
        ])
    }

    /// Nᵀ F.
    #[inline]
    pub(crate) fn reduced(&self, force: &Vector<S>) -> Pair<S> {
        [
            force[0] + self.per_radius[0] * force[3] + self.per_radius[1] * force[4],
            self.com_to_axle * force[1]
                + force[2]
                + self.turn[0] * force[3]
                + self.turn[1] * force[4],
        ]
    }

    /// Inverse of Nᵀ (M + D over) N for the damping D of each velocity: over surge, both, yaw rate.
    #[inline]
    pub(crate) fn inverse(&self, damping: &Vector<S>, over_s: f64) -> [S; 3] {
        let (p, t, d) = (&self.per_radius, &self.turn, self.com_to_axle);
        let wheels = [damping[3] * over_s, damping[4] * over_s];
        let a = self.inertia[0]
            + damping[0] * over_s
            + p[0] * p[0] * wheels[0]
            + p[1] * p[1] * wheels[1];
        let b = self.inertia[1] + p[0] * t[0] * wheels[0] + p[1] * t[1] * wheels[1];
        let c = self.inertia[2]
            + d * d * damping[1] * over_s
            + damping[2] * over_s
            + t[0] * t[0] * wheels[0]
            + t[1] * t[1] * wheels[1];
        let per = (a * c - b * b).recip();
        [c * per, -b * per, a * per]
    }
}
