//! The arc that a robot drives while its wheels turn, and the chord of it.

use slipstream_sim::Scalar;

use super::motion_law::{Knots, LAW, added};

/// Below this time (s) a law adds nothing.
const INSTANT_S: f64 = 1e-9;

/// How the wheels of a robot carry it.
#[derive(Clone, Copy)]
pub(crate) struct Carried<'a, S> {
    /// Way of each wheel for each radian (m), and the track (m).
    pub(crate) metres_per_rad: [S; 2],
    pub(crate) track_m: S,
    /// What laws add.
    pub(crate) law: Option<[S; LAW]>,
    /// Nominal geometry, which drives laws and noise.
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: f64,
    pub(crate) knots: &'a [Knots; 2],
}

/// A way (m) and a turn (rad).
#[derive(Clone, Copy)]
pub(crate) struct Arc<S> {
    pub(crate) way: S,
    pub(crate) turn: S,
}

impl<S: Scalar> Carried<'_, S> {
    /// The arc by the nominal geometry on which the wheels turn so far (rad), [right, left].
    pub(crate) fn nominal(&self, turned: [S; 2]) -> Arc<S> {
        let half_m = self.wheel_radius_m / 2.0;
        Arc {
            way: (turned[0] + turned[1]) * half_m,
            turn: (turned[0] - turned[1]) * (half_m / self.half_track_m),
        }
    }

    /// The arc on which they turn so far (rad) in `dt` (s).
    pub(crate) fn arc(&self, turned: [S; 2], dt: S) -> Arc<S> {
        let [right, left] = [0, 1].map(|i| self.metres_per_rad[i] * turned[i]);
        let rolled = Arc {
            way: (right + left) * 0.5,
            turn: (right - left) / self.track_m,
        };
        match self.law {
            Some(law) if dt.value() > INSTANT_S => {
                let [v, w] = added(&law, self.nominal(turned).rates(dt), self.knots);
                Arc {
                    way: rolled.way + v * dt,
                    turn: rolled.turn + w * dt,
                }
            }
            _ => rolled,
        }
    }
}

impl<S: Scalar> Arc<S> {
    /// Turn rate (rad/s) and speed (m/s) of an arc that takes `dt` (s), in the order of the drivers of laws; 0 in no time.
    pub(crate) fn rates(self, dt: S) -> [S; 2] {
        if dt.value() > INSTANT_S {
            [self.turn / dt, self.way / dt]
        } else {
            [S::constant(0.0); 2]
        }
    }

    /// Length of its chord (m), to the third order of the turn; the chord points where the robot faces in the middle.
    pub(crate) fn chord_m(self) -> S {
        self.way * (S::constant(1.0) - self.turn * self.turn * (1.0 / 24.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a turn in ten arcs ends where the circle does: each chord is off by the fourth order of its turn.
    #[test]
    fn arcs_follow_a_circle() {
        let robot = Carried {
            metres_per_rad: [0.05, 0.05],
            track_m: 0.2,
            law: None,
            wheel_radius_m: 0.05,
            half_track_m: 0.1,
            knots: &[Knots::default(); 2],
        };
        let radius_m = 0.7;
        let turn = std::f64::consts::FRAC_PI_2 / 10.0;
        let turned = [1.0, -1.0].map(|side| turn * (radius_m + side * 0.1) / 0.05);
        let (mut place, mut heading) = ([0.0; 2], 0.0);
        for _ in 0..10 {
            let arc = robot.arc(turned, 0.1);
            let middle: f64 = heading + arc.turn / 2.0;
            place[0] += arc.chord_m() * middle.cos();
            place[1] += arc.chord_m() * middle.sin();
            heading += arc.turn;
        }
        assert!((place[0] - radius_m).abs() < 1e-6, "{place:?}");
        assert!((place[1] - radius_m).abs() < 1e-6, "{place:?}");
    }
}
