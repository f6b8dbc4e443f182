//! The flow from one row to the next, and its derivatives by differences. Derivatives that are known in
//! closed form are not differenced: those by pose, wheel angles and creep.

use super::flow::{Flow, Point};
use super::{ANGLE, DISTURBED, Matrix, N, POSE, ROLLING, Row, SLIP, Sensor, Vector};

/// Steps of the differences by which the flow is differentiated: m/s and rad/s of the motion, N, N m,
/// m/s and rad/s of the disturbances, m/s of slip. Small against what matters, large against rounding.
const MOTION_STEP: [f64; 2] = [1e-4, 1e-3];
const DISTURBANCE_STEP: [f64; 2] = [1e-2, 1e-4];
const TORQUE_STEP: f64 = 1e-4;
const SLIP_STEP: f64 = 1e-4;
/// Largest step where wheels can slide: there steps are standard deviations of the state, for a derivative
/// across sticking and sliding is a mean over what the state may be (divided-difference filter;
/// Nørgaard, Poulsen and Ravn 2000).
const LARGEST_SLIDING_STEP: f64 = 0.1;
/// The same for the angles by which a measurement is differentiated (rad).
const ANGLE_STEP_RAD: f64 = 1e-6;

/// Disturbances that are torques of wheels where wheels can slide.
const TORQUES: std::ops::Range<usize> = DISTURBED + 2..DISTURBED + 4;

/// Derivatives of flow and measurement from one row to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Derivatives {
    /// State after the flow, by the state before it.
    pub(crate) flow: Matrix,
    /// What is measured, by the state before the flow.
    pub(crate) measurement: [[f64; N]; 3],
    /// No time passed: the flow changes nothing.
    pub(crate) still: bool,
}

/// Derivatives by differences that hold for some rows: a robot whose wheels roll on answers a force alike from row to
/// row, but for its heading. Gains need no more.
#[derive(Default)]
pub(super) struct Lately {
    all: Vec<Lasting>,
}

/// Derivatives by differences of one kind of row.
struct Lasting {
    sensor: Sensor,
    over_s: f64,
    /// Heading, and wheel speeds (rad/s).
    heading: f64,
    wheels: [f64; 2],
    step: Derivatives,
    uses: u32,
}

/// Rows for which a derivative is used, kinds of rows that are kept, and the share by which the times between rows of
/// one kind differ.
const USES: u32 = 6;
const KINDS: usize = 8;
const ALIKE: f64 = 0.02;
/// Slowest wheel that rolls on (rad/s): friction jumps where it stops.
const ROLLS_RAD_S: f64 = 0.1;
/// Change of a wheel's speed beyond which derivatives are taken anew (rad/s).
const CHANGED_RAD_S: f64 = 1.0;

impl Lately {
    /// Derivatives that still hold, of a robot with these wheel speeds.
    fn recall(
        &mut self,
        row: &Row,
        over_s: f64,
        heading: f64,
        wheels: [f64; 2],
    ) -> Option<Derivatives> {
        let mut all = self.all.iter_mut();
        let own = all.find(|own| own.is_like(row, over_s))?;
        let same = |i: usize| {
            (wheels[i] - own.wheels[i]).abs() < CHANGED_RAD_S
                && wheels[i].signum() == own.wheels[i].signum()
                && wheels[i].abs().min(own.wheels[i].abs()) > ROLLS_RAD_S
        };
        if own.uses == 0 || !same(0) || !same(1) {
            return None;
        }
        own.uses -= 1;
        Some(own.step.turned(row.sensor, heading - own.heading))
    }

    fn keep(&mut self, row: &Row, over_s: f64, heading: f64, wheels: [f64; 2], step: Derivatives) {
        let own = Lasting {
            sensor: row.sensor,
            over_s,
            heading,
            wheels,
            step,
            uses: USES,
        };
        match self.all.iter_mut().find(|known| known.is_like(row, over_s)) {
            Some(known) => *known = own,
            None => {
                if self.all.len() == KINDS {
                    self.all.remove(0);
                }
                self.all.push(own);
            }
        }
    }
}

impl Lasting {
    fn is_like(&self, row: &Row, over_s: f64) -> bool {
        self.sensor == row.sensor && (self.over_s - over_s).abs() <= ALIKE * over_s
    }
}

/// The flow to `true_s`, and its derivatives.
pub(super) fn differentiated(
    flow: &Flow<'_>,
    from: &Point,
    true_s: f64,
    row: &Row,
    deviation: &Vector,
    lately: &mut Lately,
) -> (Point, Derivatives) {
    let over_s = true_s - from.t_s;
    let mut after = from.clone();
    flow.advance(&mut after, true_s);
    let predicted = flow.measured(&after, row);
    let mut step = Derivatives {
        flow: closed_form(from, &after, over_s, flow.of_wheels),
        measurement: [[0.0; N]; 3],
        still: over_s <= 0.0,
    };
    step.by_configuration(flow, &after, row, &predicted);
    let of_pose_or_angle = matches!(row.sensor, Sensor::Pose | Sensor::WheelAngle);
    if step.still && of_pose_or_angle {
        return (after, step);
    }
    let rolls =
        |point: &Point| point.state.slides() == [false; 2] && point.state.engaged() == [true; 2];
    if step.still || !rolls(from) || !rolls(&after) {
        step.by_differences(flow, [from, &after], row, &predicted, deviation);
        return (after, step);
    }
    let heading = from.state.pose()[2];
    let [surge, _, turn] = from.state.velocity();
    let [radius, lever] = flow.robot.nominal_lengths();
    let wheels = [surge + lever * turn, surge - lever * turn].map(|own| own / radius);
    match lately.recall(row, over_s, heading, wheels) {
        Some(known) => step.take(&known, flow.of_wheels),
        None => {
            step.by_differences(flow, [from, &after], row, &predicted, deviation);
            lately.keep(row, over_s, heading, wheels, step);
        }
    }
    (after, step)
}

/// Derivatives of the flow by pose, angles and creep.
fn closed_form(from: &Point, after: &Point, over_s: f64, of_wheels: bool) -> Matrix {
    let (start, end) = (from.state.pose(), after.state.pose());
    let mut f = [[0.0; N]; N];
    for (i, line) in f.iter_mut().enumerate() {
        line[i] = 1.0;
    }
    f[POSE][POSE + 2] = start[1] - end[1];
    f[POSE + 1][POSE + 2] = end[0] - start[0];
    let (sin, cos) = (0.5 * (start[2] + end[2])).sin_cos();
    if !of_wheels {
        f[POSE][DISTURBED + 2] = over_s * cos;
        f[POSE + 1][DISTURBED + 2] = over_s * sin;
        f[POSE][DISTURBED + 3] = -0.5 * over_s * (end[1] - start[1]);
        f[POSE + 1][DISTURBED + 3] = 0.5 * over_s * (end[0] - start[0]);
        f[POSE + 2][DISTURBED + 3] = over_s;
    }
    f[POSE][DISTURBED + 4] = -over_s * sin;
    f[POSE + 1][DISTURBED + 4] = over_s * cos;
    f
}

/// Whether the derivatives by a column are known in closed form.
fn is_closed(column: usize, of_wheels: bool) -> bool {
    let motion = (ROLLING..ANGLE).contains(&column);
    let forces = (DISTURBED..DISTURBED + 2).contains(&column);
    let torques = of_wheels && TORQUES.contains(&column);
    !(motion || forces || torques) && column < SLIP
}

impl Derivatives {
    /// Columns by motion and forces, of a robot that has turned by so much.
    fn turned(&self, sensor: Sensor, by: f64) -> Self {
        let (sin, cos) = by.sin_cos();
        let mut out = *self;
        for column in 0..N {
            let turn = |x: f64, y: f64| [x * cos - y * sin, x * sin + y * cos];
            let [x, y] = turn(self.flow[POSE][column], self.flow[POSE + 1][column]);
            (out.flow[POSE][column], out.flow[POSE + 1][column]) = (x, y);
            if sensor == Sensor::Pose {
                let [x, y] = turn(self.measurement[0][column], self.measurement[1][column]);
                (out.measurement[0][column], out.measurement[1][column]) = (x, y);
            }
        }
        out
    }

    /// Columns that are differenced, from `other`.
    fn take(&mut self, other: &Self, of_wheels: bool) {
        let columns = (0..SLIP).filter(|column| !is_closed(*column, of_wheels));
        for column in columns {
            for (own, known) in self.flow.iter_mut().zip(&other.flow) {
                own[column] = known[column];
            }
            for (own, known) in self.measurement.iter_mut().zip(&other.measurement) {
                own[column] = known[column];
            }
        }
    }

    /// Of the measurement by what is known in closed form: through pose and angles after the flow.
    fn by_configuration(
        &mut self,
        flow: &Flow<'_>,
        after: &Point,
        row: &Row,
        predicted: &[f64; 3],
    ) {
        let seen = configuration(flow, after, row, predicted);
        let closed = (0..SLIP).filter(|column| is_closed(*column, flow.of_wheels));
        for column in closed {
            for (line, seen) in self.measurement.iter_mut().zip(&seen) {
                let through = (0..POSE + 3).chain(ANGLE..ANGLE + 2);
                line[column] = through.map(|i| seen[i] * self.flow[i][column]).sum();
            }
        }
        if row.sensor == Sensor::Imu && !flow.of_wheels {
            // the gyro turns with the creep
            self.measurement[2][DISTURBED + 3] += 1.0;
        }
    }

    /// By motion, forces and slip.
    fn by_differences(
        &mut self,
        flow: &Flow<'_>,
        [from, after]: [&Point; 2],
        row: &Row,
        predicted: &[f64; 3],
        deviation: &Vector,
    ) {
        let base = flow.coordinates(after);
        // what does not slide has no slip to differ in; on wheels that roll a torque acts as a force
        let slides = |point: &Point| point.state.slides() != [false; 2];
        let rolls = !slides(from) && !slides(after);
        let last = if flow.of_wheels && slides(from) {
            N
        } else {
            SLIP
        };
        for column in ROLLING..last {
            if is_closed(column, flow.of_wheels) || rolls && TORQUES.contains(&column) {
                continue;
            }
            let size = if flow.of_wheels {
                step_of(column).max(deviation[column].min(LARGEST_SLIDING_STEP))
            } else {
                step_of(column)
            };
            let mut change = [0.0; N];
            change[column] = size;
            let mut moved = from.clone();
            flow.correct(&mut moved, &change);
            flow.advance(&mut moved, after.t_s);
            let end = flow.coordinates(&moved);
            for (line, (end, base)) in self.flow.iter_mut().zip(end.iter().zip(&base)) {
                line[column] = (end - base) / size;
            }
            let seen = flow.measured(&moved, row);
            for (a, line) in self.measurement.iter_mut().enumerate() {
                line[column] = slope(seen[a], predicted[a], size);
            }
        }
        if flow.of_wheels && rolls {
            self.torques_as_forces(flow);
        }
    }

    /// Torques of wheels that roll, as force and moment.
    fn torques_as_forces(&mut self, flow: &Flow<'_>) {
        let [radius, lever] = flow.robot.nominal_lengths();
        for (column, moment) in TORQUES.zip([lever / radius, -lever / radius]) {
            for line in self.flow.iter_mut().chain(&mut self.measurement) {
                line[column] = line[DISTURBED] / radius + moment * line[DISTURBED + 1];
            }
            for (k, line) in self.flow.iter_mut().enumerate().take(SLIP).skip(DISTURBED) {
                line[column] = f64::from(u8::from(k == column));
            }
        }
    }
}

/// Derivatives of what `row` measures by pose and wheel angles at `point`.
fn configuration(
    flow: &Flow<'_>,
    point: &Point,
    row: &Row,
    predicted: &[f64; 3],
) -> [[f64; ANGLE + 2]; 3] {
    let mut out = [[0.0; ANGLE + 2]; 3];
    let columns: &[usize] = match row.sensor {
        Sensor::WheelAngle => &[ANGLE, ANGLE + 1],
        Sensor::Pose => {
            out[0][POSE] = 1.0;
            out[1][POSE + 1] = 1.0;
            &[POSE + 2]
        }
        Sensor::WheelSpeed | Sensor::Imu => &[],
    };
    for column in columns {
        let mut moved = point.clone();
        let mut change = [0.0; N];
        change[*column] = ANGLE_STEP_RAD;
        flow.correct(&mut moved, &change);
        let seen = flow.measured(&moved, row);
        for (a, line) in out.iter_mut().enumerate() {
            line[*column] = slope(seen[a], predicted[a], ANGLE_STEP_RAD);
        }
    }
    out
}

/// A difference quotient; 0 where nothing is measured.
fn slope(after: f64, before: f64, step: f64) -> f64 {
    let slope = (after - before) / step;
    if slope.is_finite() { slope } else { 0.0 }
}

fn step_of(column: usize) -> f64 {
    match column {
        ROLLING..ANGLE => MOTION_STEP[column - ROLLING],
        SLIP.. => SLIP_STEP,
        _ if column < DISTURBED + 2 => DISTURBANCE_STEP[column - DISTURBED],
        _ => TORQUE_STEP,
    }
}
