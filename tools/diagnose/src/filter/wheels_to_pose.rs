//! Extended Kalman filter from wheel angles to a reference pose: exact arcs, odometry noise in
//! proportion to distance and turn (Thrun, Burgard and Fox 2005, section 5.4), a scale mixture for
//! every row.
//!
//! State: x, y and heading of the middle of the axle. A row stamped s was measured at
//! (s − latency) / (1 + rate). The noise is scaled by the motion of the *nominal* geometry: scaled by
//! the estimated one, noise sizes would pull the geometry.

use slipstream_sim::Scalar;

use super::arc::{Arc, Carried};
use super::motion_law::{Knots, LAW};
use super::row_update::{Lever, Row, State};
use super::{Innovation, wrapped};
use crate::data::reference::PoseRow;
use crate::data::wheel_path::Turned;

/// Physical parameters: see [`Physics`].
pub(crate) const PHYSICS: usize = 8 + LAW;
/// Logarithms of noise sizes: see [`Noise`].
pub(crate) const NOISE: usize = 9;
/// Longest piece of an arc (s).
const PIECE_S: f64 = 0.2;

/// One robot's data and nominal geometry.
#[derive(Debug)]
pub(crate) struct WheelsToPose<'a> {
    /// Thinned series; their log-likelihoods are averaged (composite likelihood; Varin, Reid and
    /// Firth 2011).
    pub(crate) series: &'a [Vec<PoseRow>],
    pub(crate) wheel_radius_m: f64,
    pub(crate) half_track_m: f64,
    /// From the middle of the axle forward to the declared point (m).
    pub(crate) declared_m: f64,
    /// Median time between rows of the wheels (s).
    pub(crate) wheel_interval_s: f64,
    /// Heading at the first row where the reference has none (rad).
    pub(crate) first_heading_rad: f64,
    /// Knots of the laws.
    pub(crate) knots: [Knots; 2],
    /// Whether rows may be outliers.
    pub(crate) robust: bool,
}

/// What is estimated of the robot and its reference.
#[derive(Clone, Copy)]
pub(crate) struct Physics<S> {
    metres_per_rad: [S; 2],
    track_m: S,
    /// Tracked point from the middle of the axle (m), and measured minus true yaw (rad).
    offset: [S; 3],
    latency_s: S,
    rate: S,
    law: Option<[S; LAW]>,
}

/// Variances.
#[derive(Clone, Copy)]
pub(crate) struct Noise<S> {
    along_per_m: S,
    across_per_m: S,
    yaw_per_m: S,
    yaw_per_rad: S,
    place_per_row: S,
    yaw_per_row: S,
    place: S,
    yaw: S,
    stamp: S,
}

/// A filter on its way.
#[derive(Clone)]
pub(crate) struct On<S> {
    pub(crate) state: State<S>,
    /// When its last row was measured (s), and how far the wheels had turned by then (rad).
    pub(crate) time_s: S,
    pub(crate) angles: [S; 2],
    hint: usize,
}

impl WheelsToPose<'_> {
    /// Filters all series. `parameters`: ln of right and left wheel scale, ln of track scale, offset
    /// x, y (m), yaw (rad), latency (s), clock rate, the laws; then the logs of the nine noise sizes.
    pub(crate) fn run<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        parameters: &[S],
        sink: &mut dyn FnMut(Innovation<S>),
    ) {
        self.follow(wheels, parameters, sink, &mut |_, _| ());
    }

    /// As [`run`](Self::run); `seen` also hears the filtered pose of the axle after every row.
    pub(crate) fn follow<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        parameters: &[S],
        sink: &mut dyn FnMut(Innovation<S>),
        seen: &mut dyn FnMut(f64, [S; 3]),
    ) {
        let physics = self.physics(parameters);
        let noise = noise(&parameters[PHYSICS..]);
        let weight = 1.0 / self.series.len() as f64;
        for rows in self.series {
            let Some(first) = rows.first() else { continue };
            let mut on = self.begin(wheels, &physics, &noise, first);
            seen(first.0, on.state.mean);
            for row in &rows[1..] {
                let innovation = self.hear(wheels, &physics, &noise, &mut on, row);
                sink(Innovation {
                    weight,
                    ..innovation
                });
                seen(row.0, on.state.mean);
            }
        }
    }

    /// The filter behind the first row of a series.
    pub(crate) fn begin<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        physics: &Physics<S>,
        noise: &Noise<S>,
        first: &PoseRow,
    ) -> On<S> {
        let mut hint = 0;
        let time_s = physics.time(first.0);
        let mut on = On {
            state: self.first(physics, first),
            time_s,
            angles: wheels.angles_at(time_s, &mut hint),
            hint,
        };
        self.update(physics, noise, &mut on.state, first, [S::constant(0.0); 2]);
        on
    }

    /// Moves on to a row and hears it.
    pub(crate) fn hear<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        physics: &Physics<S>,
        noise: &Noise<S>,
        on: &mut On<S>,
        row: &PoseRow,
    ) -> Innovation<S> {
        on.state.q = [[S::constant(0.0); 3]; 3];
        let next_s = physics.time(row.0);
        let rates = self.travel(wheels, physics, noise, on, next_s);
        on.time_s = next_s;
        self.update(physics, noise, &mut on.state, row, rates)
    }

    pub(crate) fn physics<S: Scalar>(&self, p: &[S]) -> Physics<S> {
        Physics {
            metres_per_rad: [
                p[0].exp() * self.wheel_radius_m,
                p[1].exp() * self.wheel_radius_m,
            ],
            track_m: p[2].exp() * (2.0 * self.half_track_m),
            offset: [p[3] + self.declared_m, p[4], p[5]],
            latency_s: p[6],
            rate: p[7],
            law: (p[8..8 + LAW].iter().any(|own| own.value() != 0.0))
                .then(|| std::array::from_fn(|i| p[8 + i])),
        }
    }

    /// The state at the first row, known to half a metre and 0.3 rad beside the sensor noise.
    fn first<S: Scalar>(&self, physics: &Physics<S>, (_, z): &PoseRow) -> State<S> {
        let [ox, oy, oyaw] = physics.offset;
        let yaw = if z[2].is_finite() {
            S::constant(z[2]) - oyaw
        } else {
            S::constant(self.first_heading_rad)
        };
        let (sin, cos) = yaw.sin_cos();
        let zero = S::constant(0.0);
        let mut p = [[zero; 3]; 3];
        p[0][0] = S::constant(0.25);
        p[1][1] = S::constant(0.25);
        p[2][2] = S::constant(0.09);
        State {
            mean: [
                S::constant(z[0]) - ox * cos + oy * sin,
                S::constant(z[1]) - ox * sin - oy * cos,
                yaw,
            ],
            p,
            q: [[zero; 3]; 3],
        }
    }

    /// Moves the state from one time to the next along arcs; returns speed (m/s) and turn rate
    /// (rad/s) of the last piece by the nominal geometry.
    fn travel<S: Scalar>(
        &self,
        wheels: &dyn Turned<S>,
        physics: &Physics<S>,
        noise: &Noise<S>,
        on: &mut On<S>,
        to_s: S,
    ) -> [S; 2] {
        let from_s = on.time_s;
        let span_s = to_s - from_s;
        let longest_s = PIECE_S.max(self.wheel_interval_s);
        let pieces = (span_s.value() / longest_s).ceil().clamp(1.0, 1e5);
        let carried = Carried {
            metres_per_rad: physics.metres_per_rad,
            track_m: physics.track_m,
            law: physics.law,
            wheel_radius_m: self.wheel_radius_m,
            half_track_m: self.half_track_m,
            knots: &self.knots,
        };
        let mut rates = [S::constant(0.0); 2];
        for piece in 1..=(pieces as usize) {
            let t = from_s + span_s * (piece as f64 / pieces);
            let next = wheels.angles_at(t, &mut on.hint);
            let turned = [next[0] - on.angles[0], next[1] - on.angles[1]];
            on.angles = next;
            let dt = span_s / pieces;
            let (nominal, arc) = (carried.nominal(turned), carried.arc(turned, dt));
            let mut q = [
                noise.along_per_m * nominal.way.abs(),
                noise.across_per_m * nominal.way.abs(),
                noise.yaw_per_m * nominal.way.abs() + noise.yaw_per_rad * nominal.turn.abs(),
            ];
            if piece == pieces as usize {
                q[0] += noise.place_per_row;
                q[1] += noise.place_per_row;
                q[2] += noise.yaw_per_row;
                let [w, v] = nominal.rates(dt);
                rates = [v, w];
            }
            on.state.advance(arc, q);
        }
        rates
    }

    fn update<S: Scalar>(
        &self,
        physics: &Physics<S>,
        noise: &Noise<S>,
        state: &mut State<S>,
        (time_s, z): &PoseRow,
        [v, w]: [S; 2],
    ) -> Innovation<S> {
        let zero = S::constant(0.0);
        let (sin, cos) = state.mean[2].sin_cos();
        let (mut difference, by_heading) = observed(physics.offset, &state.mean, z);
        // an error of the stamp displaces the row along the motion
        let moved = [v * cos, v * sin, w];
        let mut r = moved.map(|a| moved.map(|b| noise.stamp * a * b));
        r[0][0] += noise.place;
        r[1][1] += noise.place;
        r[2][2] += noise.yaw;
        for i in 0..3 {
            if !z[i].is_finite() {
                difference[i] = zero;
                r[i] = [zero; 3];
                r.iter_mut().for_each(|line| line[i] = zero);
                // a variance of 1/(2 π) with a difference of 0 adds nothing to the likelihood
                r[i][i] = S::constant(1.0 / std::f64::consts::TAU);
            }
        }
        let lever = Lever {
            by_heading,
            seen: z.map(f64::is_finite),
        };
        let row = Row::new(state, &lever, &r, &difference);
        let (log_likelihood, ordinary) = state.merge(&row, self.robust);
        let covariance = row.covariance(0);
        Innovation {
            time_s: *time_s,
            weight: 1.0,
            scalar: false,
            ordinary,
            log_likelihood,
            difference,
            covariance,
        }
    }
}

/// A pose of the tracked point minus the one predicted from that of the axle, and derivatives of the predicted place
/// by the heading of the axle.
fn observed<S: Scalar>([ox, oy, oyaw]: [S; 3], axle: &[S; 3], z: &[f64; 3]) -> ([S; 3], [S; 2]) {
    let (sin, cos) = axle[2].sin_cos();
    // derivatives of the tracked point by the heading
    let lever = [-(ox * sin + oy * cos), ox * cos - oy * sin];
    let difference = [
        S::constant(z[0]) - axle[0] - lever[1],
        S::constant(z[1]) - axle[1] + lever[0],
        wrapped(S::constant(z[2]) - axle[2] - oyaw),
    ];
    (difference, lever)
}

impl<S: Scalar> Physics<S> {
    /// When a row with this stamp was measured.
    fn time(&self, stamp_s: f64) -> S {
        (S::constant(stamp_s) - self.latency_s) / (self.rate + 1.0)
    }
}

pub(crate) fn noise<S: Scalar>(logs: &[S]) -> Noise<S> {
    let variance = |i: usize| (logs[i] * 2.0).exp();
    Noise {
        along_per_m: variance(0),
        across_per_m: variance(1),
        yaw_per_m: variance(2),
        yaw_per_rad: variance(3),
        place_per_row: variance(4),
        yaw_per_row: variance(5),
        place: variance(6),
        yaw: variance(7),
        stamp: variance(8),
    }
}

impl<S: Scalar> State<S> {
    /// One arc of length `way` and angle `turn`, with variances along, across and of the heading.
    fn advance(&mut self, arc: Arc<S>, [along, across, heading]: [S; 3]) {
        let middle = self.mean[2] + arc.turn * 0.5;
        let (sin, cos) = middle.sin_cos();
        let chord = arc.chord_m();
        self.mean[0] += chord * cos;
        self.mean[1] += chord * sin;
        self.mean[2] += arc.turn;
        let [fx, fy] = [-(chord * sin), chord * cos];
        let [xx, xy, yy] = [
            along * cos * cos + across * sin * sin,
            (along - across) * cos * sin,
            along * sin * sin + across * cos * cos,
        ];
        for m in [&mut self.p, &mut self.q] {
            let [x2, y2, h2] = [m[0][2], m[1][2], m[2][2]];
            m[0][0] += fx * x2 * 2.0 + fx * fx * h2 + xx;
            m[0][1] += fy * x2 + fx * y2 + fx * fy * h2 + xy;
            m[1][1] += fy * y2 * 2.0 + fy * fy * h2 + yy;
            m[0][2] += fx * h2;
            m[1][2] += fy * h2;
            m[2][2] += heading;
            m[1][0] = m[0][1];
            m[2][0] = m[0][2];
            m[2][1] = m[1][2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Matrix3;
    use super::*;

    /// Derivative of `f` at `at`, column by column, by central differences.
    fn numeric(at: [f64; 3], f: impl Fn([f64; 3]) -> [f64; 3]) -> Matrix3<f64> {
        let h = 1e-6;
        let columns: [[f64; 3]; 3] = std::array::from_fn(|k| {
            let moved = |by: f64| {
                f(std::array::from_fn(|i| {
                    at[i] + if i == k { by } else { 0.0 }
                }))
            };
            let (up, down) = (moved(h), moved(-h));
            std::array::from_fn(|i| (up[i] - down[i]) / (2.0 * h))
        });
        std::array::from_fn(|i| std::array::from_fn(|k| columns[k][i]))
    }

    fn state(mean: [f64; 3], p: Matrix3<f64>) -> State<f64> {
        State {
            mean,
            p,
            q: [[0.0; 3]; 3],
        }
    }

    fn apart(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// J M Jᵀ.
    fn projected(j: &Matrix3<f64>, m: &Matrix3<f64>) -> Matrix3<f64> {
        let product = |a: &Matrix3<f64>, b: &dyn Fn(usize, usize) -> f64| -> Matrix3<f64> {
            std::array::from_fn(|i| {
                std::array::from_fn(|k| (0..3).map(|l| a[i][l] * b(l, k)).sum())
            })
        };
        product(&product(j, &|l, k| m[l][k]), &|l, k| j[k][l])
    }

    const P: Matrix3<f64> = [[0.3, 0.1, -0.05], [0.1, 0.2, 0.04], [-0.05, 0.04, 0.1]];

    #[test]
    fn an_arc_carries_the_covariance_by_its_derivative() {
        let at = [0.4, -0.7, 1.1];
        let arc = |mean: [f64; 3]| {
            let mut own = state(mean, P);
            own.advance(
                Arc {
                    way: 0.3,
                    turn: -0.6,
                },
                [0.0; 3],
            );
            own
        };
        let f = numeric(at, |mean| arc(mean).mean);
        assert!(apart(&arc(at).p, &projected(&f, &P)) < 1e-9);
    }

    #[test]
    fn the_noise_of_an_arc_lies_along_and_across_its_chord() {
        let noise = [0.04, 0.01, 0.09];
        let mut own = state([0.0, 0.0, 0.2], [[0.0; 3]; 3]);
        own.advance(
            Arc {
                way: 0.3,
                turn: 0.6,
            },
            noise,
        );
        let (sin, cos) = 0.5_f64.sin_cos();
        let turned = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let diagonal: Matrix3<f64> =
            std::array::from_fn(|i| std::array::from_fn(|k| if i == k { noise[i] } else { 0.0 }));
        assert!(apart(&own.p, &projected(&turned, &diagonal)) < 1e-12);
        assert_eq!(own.p, own.q);
    }

    #[test]
    fn h_is_the_derivative_of_the_predicted_pose() {
        let (offset, at, z) = ([0.2, -0.1, 0.3], [0.4, -0.7, 1.1], [0.5, -0.6, 1.2]);
        let (_, [x, y]) = observed(offset, &at, &z);
        let h = [[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]];
        let lost = numeric(at, |axle| observed(offset, &axle, &z).0);
        assert!(apart(&h, &lost.map(|row| row.map(|own| -own))) < 1e-9);
    }
}
