//! Corrections of a state by what a filter has learnt of it.

use super::state::State;
use super::velocity_projection::project_velocity;
use crate::parts::friction_constraints::{ConstraintSet, FrictionConstraint};
use crate::robot::Robot;
use crate::robot::mode::Gear;

/// A small change of a state.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Correction {
    /// x and y of c (m) and heading (rad), world frame.
    pub pose: [f64; 3],
    /// Surge (m/s) and yaw rate (rad/s); the wheels turn along, and the slip stays.
    pub rolling: [f64; 2],
    /// Wheel angles, right and left (rad); motors turn along.
    pub angle_rad: [f64; 2],
    /// Slip velocities, right, left and lateral (m/s). What sticks keeps sticking.
    pub slip_m_s: [f64; 3],
}

impl Robot<f64> {
    /// Changes `state` by `correction`. What dry friction holds at rest stays at rest. Of prescribed
    /// wheel speeds nothing changes.
    pub fn correct(&self, state: &mut State, correction: &Correction) {
        let body = &mut state.body;
        for i in 0..3 {
            body.pose[i] += correction.pose[i];
        }
        for i in 0..2 {
            body.angle[i] += correction.angle_rad[i];
            body.motor_angle[i] += correction.angle_rad[i];
        }
        let [surge, turn] = correction.rolling;
        let slides = FrictionConstraint::WHEELS.map(|wheel| state.mode.slides(wheel));
        let slip = |i: usize| {
            if slides[i] {
                correction.slip_m_s[i]
            } else {
                0.0
            }
        };
        let lateral = if slides == [true; 2] {
            correction.slip_m_s[2]
        } else {
            0.0
        };
        if surge == 0.0 && turn == 0.0 && slides == [false; 2] {
            return;
        }
        let body = &mut state.body;
        body.nu[0] += surge;
        body.nu[1] += self.com_to_axle * turn + lateral;
        body.nu[2] += turn;
        let rim = [self.half_track * turn, -self.half_track * turn];
        for (i, rim) in rim.into_iter().enumerate() {
            body.nu[3 + i] += (surge + rim - slip(i)) / self.radius[i];
            if state.mode.gear[i] != Gear::Free {
                body.motor_speed[i] = body.nu[3 + i];
            }
        }
        let dry = state.mode.frictional.difference(ConstraintSet::WHEELS);
        if dry.iter().any(|constraint| !state.mode.slides(constraint)) {
            state.body.nu = project_velocity(self, state, state.mode.active);
        }
    }
}
