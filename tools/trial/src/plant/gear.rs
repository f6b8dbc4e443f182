//! Play between motor and wheel.

use super::state::State;

/// By so much more than its play a gear must be apart to count as closed (rad): rounding.
const SLACK: f64 = 1e-11;

/// The gears that closed: on which side each would lean, 0 for those that did not.
pub(crate) fn closing(state: &State, gap: f64) -> [i8; 2] {
    [0, 1].map(|i| {
        let apart = state.motor[i] - state.wheel[i];
        match () {
            () if gap <= 0.0 || state.gear[i] != 0 || apart.abs() <= gap / 2.0 + SLACK => 0,
            () if apart > 0.0 => 1,
            () => -1,
        }
    })
}

/// Lets gears lean on the side that they reached.
pub(crate) fn close(state: &mut State, gap: f64, closing: [i8; 2]) {
    for (i, side) in closing.into_iter().enumerate() {
        if side != 0 {
            state.gear[i] = side;
            state.motor[i] = state.wheel[i] + f64::from(side) * gap / 2.0;
        }
    }
}
