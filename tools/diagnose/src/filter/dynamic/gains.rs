//! One pass of the extended Kalman filter.

use super::flow::{Flow, Point};
use super::update::{Covariance, Derivatives, Gain};
use super::{ANGLE, DISTURBANCES, DISTURBED, N, Noise, POSE, ROLLING, Row, SLIP, Sensor, in_order};

/// Steps of the differences by which the flow is differentiated: m/s and rad/s of the motion, N, N m,
/// m/s and rad/s of the disturbances, m/s of slip. Small against what matters, large against rounding.
const MOTION_STEP: [f64; 2] = [1e-4, 1e-3];
const DISTURBANCE_STEP: [f64; 2] = [1e-2, 1e-4];
const TORQUE_STEP: f64 = 1e-4;
const SLIP_STEP: f64 = 1e-4;
/// Factor of an encoder's variance beside an impact of its gear: half a count more.
const IMPACT: f64 = 4.0;
/// Variance of what was not measured: it says nothing.
pub(crate) const NOT_MEASURED: f64 = 1e12;

/// One row of a pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    /// Which row of the run.
    pub(crate) row: usize,
    /// When it was measured (s).
    pub(crate) true_s: f64,
    pub(crate) step: Derivatives,
    /// Measured minus predicted.
    pub(crate) innovation: [f64; 3],
    /// What is left of the disturbances at the next row.
    pub(crate) decay: [f64; DISTURBANCES],
    /// Variance of the sensor's error.
    pub(crate) variance: [f64; 3],
}

/// A pass over one run, in the order in which its rows were measured.
#[derive(Debug, Clone)]
pub(crate) struct Pass {
    pub(crate) rows: Vec<Passed>,
    /// Of each row of the run, in the run's order.
    pub(crate) gains: Vec<Gain>,
}

impl Pass {
    /// Filters a run.
    pub(crate) fn new(flow: &Flow<'_>, noise: &Noise) -> Self {
        if noise.of_wheels {
            Self::of::<N>(flow, noise)
        } else {
            Self::of::<SLIP>(flow, noise)
        }
    }

    fn of<const M: usize>(flow: &Flow<'_>, noise: &Noise) -> Self {
        let slides = noise.of_wheels;
        let run = flow.run;
        let mut order = Vec::new();
        in_order(flow.robot, run, &mut order);
        let mut covariance = Covariance::<M> {
            p: start_covariance(&run.start_deviation, noise),
        };
        let mut gains = vec![Gain::NONE; run.rows.len()];
        let mut rows = Vec::with_capacity(order.len());
        let mut point = flow.start();
        let mut apart = false;
        for (place, &(true_s, index)) in order.iter().enumerate() {
            let row = &run.rows[index];
            let (after, step) = differentiated(flow, &point, true_s, row, slides);
            point = after;
            let innovation = flow.innovation(&point, row);
            let mut variance = row.variance;
            let engaged = point.state.engaged();
            if row.sensor == Sensor::WheelAngle && (engaged != [true; 2] || apart) {
                // when a gear closes is known to a step only
                for v in variance.iter_mut().filter(|v| **v < NOT_MEASURED) {
                    *v *= IMPACT;
                }
                apart = engaged != [true; 2];
            }
            let gain = covariance.update(&step, &variance);
            let next_s = order.get(place + 1).map_or(true_s, |(next_s, _)| *next_s);
            let decay = noise.decay(next_s - true_s);
            flow.correct(&mut point, &gain.correction(&innovation));
            for (own, a) in point.disturbance.iter_mut().zip(&decay) {
                *own *= a;
            }
            covariance.disturb(noise, &decay);
            gains[index] = gain;
            rows.push(Passed {
                row: index,
                true_s,
                step,
                innovation,
                decay,
                variance,
            });
        }
        Self { rows, gains }
    }
}

/// Covariance of the state where the run begins.
pub(super) fn start_covariance<const M: usize>(
    deviation: &[f64; N],
    noise: &Noise,
) -> [[f64; M]; M] {
    let mut p = [[0.0; M]; M];
    for (i, row) in p.iter_mut().enumerate() {
        row[i] = deviation[i] * deviation[i];
    }
    for (k, size) in noise.size.iter().enumerate() {
        p[DISTURBED + k][DISTURBED + k] = size * size;
    }
    p
}

/// The flow to `true_s`, and its derivatives by differences.
fn differentiated(
    flow: &Flow<'_>,
    from: &Point,
    true_s: f64,
    row: &Row,
    slides: bool,
) -> (Point, Derivatives) {
    let over_s = true_s - from.t_s;
    let mut after = from.clone();
    flow.advance(&mut after, true_s);
    let start = from.state.pose();
    let end = after.state.pose();
    let mut f = [[0.0; N]; N];
    for (i, line) in f.iter_mut().enumerate() {
        line[i] = 1.0;
    }
    f[POSE][POSE + 2] = start[1] - end[1];
    f[POSE + 1][POSE + 2] = end[0] - start[0];
    let base = flow.coordinates(&after);
    let predicted = flow.measured(&after, row);
    let mut g = [[0.0; N]; 3];
    let creep = !flow.of_wheels;
    let (sin, cos) = (0.5 * (start[2] + end[2])).sin_cos();
    if creep {
        f[POSE][DISTURBED + 2] = over_s * cos;
        f[POSE + 1][DISTURBED + 2] = over_s * sin;
        f[POSE][DISTURBED + 3] = -0.5 * over_s * (end[1] - start[1]);
        f[POSE + 1][DISTURBED + 3] = 0.5 * over_s * (end[0] - start[0]);
        f[POSE + 2][DISTURBED + 3] = over_s;
    }
    f[POSE][DISTURBED + 4] = -over_s * sin;
    f[POSE + 1][DISTURBED + 4] = over_s * cos;
    // what is measured by pose and angles after the flow
    let after_flow = configuration(flow, &after, row, &predicted);
    let analytic = |column: usize| {
        !(ROLLING..ROLLING + 2).contains(&column)
            && !(DISTURBED..DISTURBED + 2).contains(&column)
            && (creep || !(DISTURBED + 2..DISTURBED + 4).contains(&column))
            && column < SLIP
    };
    for column in (0..SLIP).filter(|column| analytic(*column)) {
        for (a, line) in g.iter_mut().enumerate() {
            line[column] = (0..7)
                .filter(|i| !(ROLLING..ANGLE).contains(i))
                .map(|i| after_flow[a][i] * f[i][column])
                .sum();
        }
    }
    if row.sensor == Sensor::Imu && creep {
        g[2][DISTURBED + 3] += 1.0;
    }
    // what does not slide has no slip to differ in; on wheels that roll a torque acts as a force
    let sliding = |point: &Point| point.state.slides() != [false; 2];
    let (slid, rolls) = (sliding(from), !sliding(from) && !sliding(&after));
    let last = if slides && slid { N } else { SLIP };
    if over_s <= 0.0 && row.sensor != Sensor::WheelSpeed && row.sensor != Sensor::Imu {
        // no time passed: pose and angles alone are seen
        return (
            after,
            Derivatives {
                flow: f,
                measurement: g,
                still: true,
            },
        );
    }
    let torques = DISTURBED + 2..DISTURBED + 4;
    let differences =
        (ROLLING..last).filter(|column| !analytic(*column) && !(rolls && torques.contains(column)));
    for column in differences {
        let size = step_of(column);
        let mut change = [0.0; N];
        change[column] = size;
        let mut moved = from.clone();
        flow.correct(&mut moved, &change);
        flow.advance(&mut moved, true_s);
        let end = flow.coordinates(&moved);
        for i in 0..N {
            f[i][column] = (end[i] - base[i]) / size;
        }
        let seen = flow.measured(&moved, row);
        for (a, line) in g.iter_mut().enumerate() {
            let slope = (seen[a] - predicted[a]) / size;
            line[column] = if slope.is_finite() { slope } else { 0.0 };
        }
    }
    if !creep && rolls {
        let [radius, lever] = flow.robot.nominal_lengths();
        let force = 1.0 / radius;
        for (column, moment) in torques.zip([lever / radius, -lever / radius]) {
            for line in f.iter_mut().chain(&mut g) {
                line[column] = force * line[DISTURBED] + moment * line[DISTURBED + 1];
            }
            for (k, line) in f.iter_mut().enumerate().skip(DISTURBED).take(5) {
                line[column] = f64::from(u8::from(k == column));
            }
        }
    }
    (
        after,
        Derivatives {
            flow: f,
            measurement: g,
            still: over_s <= 0.0,
        },
    )
}

/// Derivatives of what `row` measures by pose and wheel angles at `point`.
fn configuration(flow: &Flow<'_>, point: &Point, row: &Row, predicted: &[f64; 3]) -> [[f64; 7]; 3] {
    let mut out = [[0.0; 7]; 3];
    let columns: &[usize] = match row.sensor {
        Sensor::WheelAngle => &[ANGLE, ANGLE + 1],
        Sensor::Pose => {
            out[0][0] = 1.0;
            out[1][1] = 1.0;
            &[2]
        }
        Sensor::WheelSpeed | Sensor::Imu => &[],
    };
    const STEP_RAD: f64 = 1e-6;
    for column in columns {
        let mut moved = point.clone();
        let mut change = [0.0; N];
        change[*column] = STEP_RAD;
        flow.correct(&mut moved, &change);
        let seen = flow.measured(&moved, row);
        for a in 0..3 {
            let slope = (seen[a] - predicted[a]) / STEP_RAD;
            out[a][*column] = if slope.is_finite() { slope } else { 0.0 };
        }
    }
    out
}

fn step_of(column: usize) -> f64 {
    match column {
        ROLLING..ANGLE => MOTION_STEP[column - ROLLING],
        SLIP.. => SLIP_STEP,
        _ if column < DISTURBED + 2 => DISTURBANCE_STEP[column - DISTURBED],
        _ => TORQUE_STEP,
    }
}
