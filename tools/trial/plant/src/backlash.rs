//! Backlash: play between motor and wheel.

use crate::state::State;

/// Rounding tolerance: a gear closes when it exceeds its play by this (rad).
const TOLERANCE_RAD: f64 = 1e-11;

/// The side, +1 or −1, on which each gear closes; 0 for a gear that does not.
pub(crate) fn closing(state: &State, gap: f64) -> [i8; 2] {
    [0, 1].map(|i| {
        let apart = state.motor[i] - state.wheel[i];
        match () {
            () if gap <= 0.0 || state.gear[i] != 0 || apart.abs() <= gap / 2.0 + TOLERANCE_RAD => 0,
            () if apart > 0.0 => 1,
            () => -1,
        }
    })
}

/// Sets the gears that close to the ends of their play.
pub(crate) fn close(state: &mut State, gap: f64, closing: [i8; 2]) {
    for (i, side) in closing.into_iter().enumerate() {
        if side != 0 {
            state.gear[i] = side;
            state.motor[i] = state.wheel[i] + f64::from(side) * gap / 2.0;
        }
    }
}
