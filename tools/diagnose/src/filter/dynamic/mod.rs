//! Extended Kalman filter over the plant, for robots whose masses are known.
//!
//! The state is that of the plant and five disturbances, each an Ornstein-Uhlenbeck process
//! (Kristensen, Madsen and Jørgensen 2004): a surge force, a yaw moment, and the creep of the contact
//! along, about and across the body, which is what separates pose from wheels. Where wheels can slide,
//! torques at both wheels take the place of the creep along and about. A disturbance is held from one
//! row of measurements to the next.
//!
//! * [`flow`]: the plant from row to row, and what it would measure.
//! * [`gains`]: one pass of the extended filter; stores derivatives, gains and whitening factors.
//! * [`linear`]: the same filter for other noise sizes, linear about the pass.
//! * [`predictor`]: innovations of other parameters at the gains of a pass.

pub(crate) mod columns;
mod derivatives;
pub(crate) mod flow;
pub(crate) mod gains;
pub(crate) mod impulse;
pub(crate) mod linear;
pub(crate) mod open_loop;
pub(crate) mod predictor;
mod update;

use slipstream_sim::{Command, Stream};

/// Length of the state.
pub(crate) const N: usize = 15;
/// Disturbances.
pub(crate) const DISTURBANCES: usize = 5;

/// x, y and heading.
pub(super) const POSE: usize = 0;
/// Surge and yaw rate.
pub(super) const ROLLING: usize = 3;
/// Angles of both wheels.
pub(super) const ANGLE: usize = 5;
/// The disturbances.
pub(crate) const DISTURBED: usize = 7;
/// Slip of the right and the left wheel, and lateral.
pub(crate) const SLIP: usize = 12;

pub(crate) type Vector = [f64; N];
pub(crate) type Matrix = [[f64; N]; N];

/// What a row was measured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sensor {
    WheelAngle,
    WheelSpeed,
    Pose,
    Imu,
}

impl Sensor {
    pub(crate) fn stream(self) -> Stream {
        match self {
            Self::WheelAngle | Self::WheelSpeed => Stream::Wheels,
            Self::Pose => Stream::Pose,
            Self::Imu => Stream::Imu,
        }
    }
}

/// One row of measurements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) sensor: Sensor,
    /// Stamp (s).
    pub(crate) stamp_s: f64,
    /// What was measured; what was not is NaN.
    pub(crate) value: [f64; 3],
    /// Variance of the sensor's error.
    pub(crate) variance: [f64; 3],
}

/// One recording of a robot, as the filter reads it.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// From when (s) each command holds.
    pub(crate) commands: Vec<(f64, Command)>,
    pub(crate) rows: Vec<Row>,
    /// When it begins (s): with its first command, or with its first row where that comes late.
    pub(crate) begin_s: f64,
    /// State at the start, and standard deviation of each of its entries.
    pub(crate) start: Vector,
    pub(crate) start_deviation: Vector,
    /// From c forward to the point whose pose was measured (m).
    pub(crate) tracked_ahead_m: f64,
    /// The accelerometer leaves gravity out.
    pub(crate) without_gravity: bool,
    /// Intervals (s) excluded from the analysis: after each the state is as unknown as at the start, of a robot that
    /// may move.
    pub(crate) left_out_s: Vec<[f64; 2]>,
    /// Standard deviation of the state after such an interval.
    pub(crate) lost_deviation: Vector,
    /// Times (s) at which something pushes for a moment: between two rows surge and yaw rate may change
    /// as if they were lost.
    pub(crate) disturbances_s: Vec<[f64; 2]>,
}

impl Run {
    /// Whether something pushes for a moment at this time (s).
    pub(super) fn is_disturbed(&self, true_s: f64) -> bool {
        let mut gusts = self.disturbances_s.iter();
        gusts.any(|[begin, end]| (*begin..=*end).contains(&true_s))
    }

    /// Whether an interval that is excluded from the analysis lies between two instants (s).
    pub(super) fn is_lost_between(&self, from_s: f64, to_s: f64) -> bool {
        let mut left_out = self.left_out_s.iter();
        left_out.any(|[begin, end]| from_s <= *end && to_s >= *begin && from_s < to_s)
    }
}

/// Standard deviation and correlation time of each disturbance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Surge (N), yaw (N m), then creep along (m/s), about (rad/s) and across (m/s), or torque of the
    /// right and the left wheel (N m) and creep across.
    pub(crate) size: [f64; DISTURBANCES],
    /// Correlation times (s): surge, yaw, all others.
    pub(crate) time_s: [f64; 3],
    /// Whether the third and the fourth are torques of the wheels.
    pub(crate) of_wheels: bool,
    /// Standard deviation of the stamps of the wheels' angles (s): a wheel that turns is read a little before or after.
    pub(crate) jitter_s: f64,
    /// What the readings of wheels, poses and inertial sensor have beyond what is known of their error, as a share of
    /// it.
    pub(crate) beyond: [f64; 3],
}

impl Noise {
    /// Variance of a row that changes at `rates`, of which its sensor's own is known as `variance`.
    pub(crate) fn variance(
        &self,
        sensor: Sensor,
        variance: &[f64; 3],
        rates: &[f64; 3],
    ) -> [f64; 3] {
        let beyond = self.beyond[match sensor.stream() {
            Stream::Wheels => 0,
            Stream::Pose => 1,
            Stream::Imu => 2,
        }];
        [0, 1, 2]
            .map(|i| variance[i] * (1.0 + beyond * beyond) + (self.jitter_s * rates[i]).powi(2))
    }

    /// What is left of each disturbance after `over_s` (s).
    pub(crate) fn decay(&self, over_s: f64) -> [f64; DISTURBANCES] {
        let [surge, yaw, other] = self.time_s.map(|time_s| (-over_s / time_s).exp());
        [surge, yaw, other, other, other]
    }
}

/// Order in which the rows of `run` were measured, with the true time of each (s).
pub(super) fn in_order(robot: &slipstream_sim::Robot, run: &Run) -> Vec<(f64, usize)> {
    let timed = run.rows.iter().enumerate().map(|(index, row)| {
        let true_s = robot.true_s(row.sensor.stream(), row.stamp_s);
        (true_s.max(run.begin_s), index)
    });
    let mut order: Vec<(f64, usize)> = timed.collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order
}
