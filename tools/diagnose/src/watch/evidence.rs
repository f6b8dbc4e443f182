//! Which rows of the wheels say how they follow their commands: those that move, or should.

use super::learnt::Driven;
use crate::data::streams::WheelKind;
use crate::data::wheel_rows::{AWAY_S, AWAY_SHARE, REST_SHARE};

/// After a rest of this long (s) a filter begins anew.
const REST_S: f64 = 1.0;
/// Commands below this (rad/s) are none.
const NONE_RAD_S: f64 = 1e-9;

/// What of the past tells.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    last: Option<(f64, [f64; 2])>,
    /// When each wheel was last told to turn, and turned although it was not (s).
    told_s: [f64; 2],
    away_s: [f64; 2],
    /// When a row was last evidence (s).
    counted_s: f64,
}

impl Default for Evidence {
    fn default() -> Self {
        Self {
            last: None,
            told_s: [f64::NEG_INFINITY; 2],
            away_s: [f64::NEG_INFINITY; 2],
            counted_s: f64::NEG_INFINITY,
        }
    }
}

impl Evidence {
    /// Whether a row counts, and whether it ends a rest.
    pub(crate) fn of(
        &mut self,
        driven: &Driven,
        t_s: f64,
        told: [f64; 2],
        value: [f64; 2],
    ) -> (bool, bool) {
        let speed = self.speed(driven.kind, t_s, value);
        let mut moves = driven.by_volts;
        for wheel in 0..2 {
            let still = told[wheel].abs() < NONE_RAD_S;
            if !still {
                self.told_s[wheel] = t_s;
            }
            let top = driven.largest_rad_s;
            if still && t_s - self.told_s[wheel] > AWAY_S && speed[wheel] > AWAY_SHARE * top {
                self.away_s[wheel] = t_s;
            }
            let rests = still && speed[wheel] < REST_SHARE * top;
            moves |= !rests && t_s - self.away_s[wheel] >= AWAY_S;
        }
        let rested = moves && t_s - self.counted_s > REST_S;
        if moves {
            self.counted_s = t_s;
        }
        (moves, rested)
    }

    /// Size of each wheel's speed (rad/s).
    fn speed(&mut self, kind: WheelKind, t_s: f64, value: [f64; 2]) -> [f64; 2] {
        let last = self.last.replace((t_s, value));
        match (kind, last) {
            (WheelKind::Speed, _) => value.map(f64::abs),
            (WheelKind::Angle, Some((last_s, before))) if t_s > last_s => {
                [0, 1].map(|i| (value[i] - before[i]).abs() / (t_s - last_s))
            }
            (WheelKind::Angle, _) => [0.0; 2],
        }
    }
}
