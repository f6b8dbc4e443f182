//! What noise makes of an open-loop prediction: the covariance of pose and drive over a window, with nothing
//! heard after its start.

use nalgebra::{Matrix3, SMatrix};

/// Pose of the axle (m, m, rad), and speeds by which half the sum and half the difference of both wheels are
/// off (rad/s).
const STATE: usize = 5;

/// An Ornstein-Uhlenbeck disturbance of a wheel speed with a walk of the angle beside it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wander {
    pub(crate) size_rad_s: f64,
    pub(crate) time_s: f64,
    /// rad/√s.
    pub(crate) walk: f64,
}

impl Wander {
    /// Variance of the angle (rad²) after a time (s) from a start at which nothing is known of it.
    pub(crate) fn angle(&self, over_s: f64) -> f64 {
        let Self {
            size_rad_s,
            time_s,
            walk,
        } = *self;
        let held = time_s * (1.0 - (-over_s / time_s.max(1e-9)).exp());
        2.0 * size_rad_s * size_rad_s * time_s * (over_s - held) + walk * walk * over_s
    }
}

/// What wanders between two rows: variances for each metre, radian and second.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rates {
    pub(crate) along_per_m: f64,
    pub(crate) across_per_m: f64,
    pub(crate) yaw_per_m: f64,
    pub(crate) yaw_per_rad: f64,
    /// Errors of the reference that add up.
    pub(crate) place_per_s: f64,
    pub(crate) yaw_per_s: f64,
    /// Half the sum and half the difference of the wheels' speeds, where they are simulated from commands.
    pub(crate) wheels: [Wander; 2],
}

/// The covariance on its way.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    rates: Rates,
    wheel_radius_m: f64,
    half_track_m: f64,
    p: SMatrix<f64, STATE, STATE>,
}

impl Spread {
    /// At the start of a window, whose pose is known.
    pub(crate) fn new(rates: Rates, wheel_radius_m: f64, half_track_m: f64) -> Self {
        let mut p = SMatrix::zeros();
        for (i, own) in rates.wheels.iter().enumerate() {
            p[(3 + i, 3 + i)] = own.size_rad_s * own.size_rad_s;
        }
        Self {
            rates,
            wheel_radius_m,
            half_track_m,
            p,
        }
    }

    /// One arc of length `way` (m) and angle `turn` (rad) that begins with this heading and lasts `dt` (s).
    pub(crate) fn advance(&mut self, way: f64, turn: f64, heading: f64, dt: f64) {
        let r = self.wheel_radius_m;
        let (sin, cos) = (heading + turn / 2.0).sin_cos();
        let mut f = SMatrix::<f64, STATE, STATE>::identity();
        f[(0, 2)] = -way * sin;
        f[(1, 2)] = way * cos;
        f[(0, 3)] = r * dt * cos;
        f[(1, 3)] = r * dt * sin;
        f[(2, 4)] = r * dt / self.half_track_m;
        for (i, own) in self.rates.wheels.iter().enumerate() {
            f[(3 + i, 3 + i)] = (-dt / own.time_s.max(1e-9)).exp();
        }
        self.p = f * self.p * f.transpose();
        let rates = &self.rates;
        let [sum, difference] = rates.wheels.map(|own| own.walk * own.walk * dt * r * r);
        let along = rates.along_per_m * way.abs() + sum;
        let across = rates.across_per_m * way.abs();
        let place = rates.place_per_s * dt;
        self.p[(0, 0)] += along * cos * cos + across * sin * sin + place;
        self.p[(1, 1)] += along * sin * sin + across * cos * cos + place;
        let both = (along - across) * sin * cos;
        self.p[(0, 1)] += both;
        self.p[(1, 0)] += both;
        self.p[(2, 2)] += rates.yaw_per_m * way.abs()
            + rates.yaw_per_rad * turn.abs()
            + rates.yaw_per_s * dt
            + difference / (self.half_track_m * self.half_track_m);
        for (i, own) in rates.wheels.iter().enumerate() {
            let decay = f[(3 + i, 3 + i)];
            self.p[(3 + i, 3 + i)] += own.size_rad_s * own.size_rad_s * (1.0 - decay * decay);
        }
    }

    /// Covariance of a point of the body `lever` (m) from the axle, and of the heading.
    pub(crate) fn of_point(&self, lever: [f64; 2]) -> Matrix3<f64> {
        let mut h = SMatrix::<f64, 3, STATE>::zeros();
        for i in 0..3 {
            h[(i, i)] = 1.0;
        }
        h[(0, 2)] = -lever[1];
        h[(1, 2)] = lever[0];
        h * self.p * h.transpose()
    }
}

/// Variances along both axes and of the heading of a point that is predicted from a start whose pose has this
/// covariance: the path as a whole is turned by the start's heading (rad).
pub(crate) fn from_start(
    own: &Matrix3<f64>,
    start: &Matrix3<f64>,
    heading: f64,
    point: [f64; 2],
) -> [f64; 3] {
    let (sin, cos) = heading.sin_cos();
    let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let own = turn * own * turn.transpose();
    let [x, y] = [
        point[0] * cos - point[1] * sin,
        point[0] * sin + point[1] * cos,
    ];
    let g = Matrix3::new(1.0, 0.0, -y, 0.0, 1.0, x, 0.0, 0.0, 1.0);
    let both = own + g * start * g.transpose();
    [both[(0, 0)], both[(1, 1)], both[(2, 2)]]
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn a_straight_drive_with_a_wandering_heading_is_as_in_closed_form() {
        let rates = Rates {
            yaw_per_m: 1e-4,
            ..Rates::default()
        };
        let mut spread = Spread::new(rates, 0.1, 0.2);
        for _ in 0..1000 {
            spread.advance(0.005, 0.0, 0.0, 0.005);
        }
        let p = spread.of_point([0.0, 0.0]);
        // heading: a walk over 5 m; across: its integral, q s³/3
        assert!((p[(2, 2)] - 5e-4).abs() < 1e-9);
        assert!((p[(1, 1)] - 1e-4 * 125.0 / 3.0).abs() < 1e-5);
        assert!(p[(0, 0)].abs() < 1e-12);
    }

    #[test]
    fn a_wandering_drive_is_as_in_closed_form() {
        let wander = Wander {
            size_rad_s: 0.3,
            time_s: 0.8,
            walk: 0.02,
        };
        let rates = Rates {
            wheels: [wander, Wander::default()],
            ..Rates::default()
        };
        let mut spread = Spread::new(rates, 0.1, 0.2);
        for _ in 0..5000 {
            spread.advance(0.001, 0.0, 0.0, 0.001);
        }
        let along = spread.of_point([0.0, 0.0])[(0, 0)];
        let wanted = 0.01 * wander.angle(5.0);
        // Euler steps of 1 ms
        assert!((along - wanted).abs() < 2e-3 * wanted, "{along} {wanted}");
    }

    #[test]
    fn a_start_that_is_turned_displaces_what_is_far() {
        let start = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1e-4));
        let [x, y, yaw] = from_start(&Matrix3::zeros(), &start, 0.0, [3.0, 0.0]);
        assert!((x, yaw) == (0.0, 1e-4) && (y - 9e-4).abs() < 1e-12);
    }
}
