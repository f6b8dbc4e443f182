//! Rows of a stream: moved in time, taken out, changed.

use slipstream_recording::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, Wheels};

/// What a stream holds, column by column.
pub(super) trait Columns {
    /// Keeps the rows of which `keep` holds.
    fn keep(&mut self, keep: &[bool]);
}

fn keep_in<T>(column: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    column.retain(|_| flags.next().copied().unwrap_or(true));
}

fn keep_all<'a>(columns: impl IntoIterator<Item = &'a mut Vec<f64>>, keep: &[bool]) {
    for column in columns {
        keep_in(column, keep);
    }
}

impl Columns for Command {
    fn keep(&mut self, keep: &[bool]) {
        keep_all(pair(self), keep);
    }
}

impl Columns for Wheels {
    fn keep(&mut self, keep: &[bool]) {
        match self {
            Self::Ticks { right, left } => {
                keep_in(right, keep);
                keep_in(left, keep);
            }
            Self::Angle {
                right_rad: right,
                left_rad: left,
            }
            | Self::Speed {
                right_rad_s: right,
                left_rad_s: left,
            } => keep_all([right, left], keep),
        }
    }
}

impl Columns for Odometry {
    fn keep(&mut self, keep: &[bool]) {
        keep_all([&mut self.v_m_s].into_iter().chain(&mut self.w_rad_s), keep);
    }
}

impl Columns for Pose {
    fn keep(&mut self, keep: &[bool]) {
        let Self { x_m, y_m, yaw_rad } = self;
        keep_all([x_m, y_m].into_iter().chain(yaw_rad), keep);
    }
}

impl Columns for Imu {
    fn keep(&mut self, keep: &[bool]) {
        let Self {
            ax_m_s2,
            ay_m_s2,
            gz_rad_s,
        } = self;
        let all = ax_m_s2.iter_mut().chain(ay_m_s2).chain(gz_rad_s);
        keep_all(all, keep);
    }
}

impl Columns for Motor {
    fn keep(&mut self, keep: &[bool]) {
        let Self {
            current_right_a,
            current_left_a,
            supply_v,
        } = self;
        let all = current_right_a
            .iter_mut()
            .chain(current_left_a)
            .chain(supply_v);
        keep_all(all, keep);
    }
}

/// Both columns of a command.
pub(super) fn pair(command: &mut Command) -> [&mut Vec<f64>; 2] {
    match command {
        Command::Torque {
            right_nm: a,
            left_nm: b,
        }
        | Command::Voltage {
            right_v: a,
            left_v: b,
        }
        | Command::WheelSpeed {
            right_rad_s: a,
            left_rad_s: b,
        }
        | Command::Twist {
            v_m_s: a,
            w_rad_s: b,
        } => [a, b],
    }
}

fn keep_stream<V: Columns>(stream: &mut Option<Stream<V>>, keep: &dyn Fn(f64) -> bool) {
    let times_s = stream.as_ref().map(|own| own.t_s.clone());
    keep_rows(stream, &times_s.unwrap_or_default(), keep);
}

fn keep_rows<V: Columns>(
    stream: &mut Option<Stream<V>>,
    times_s: &[f64],
    keep: &dyn Fn(f64) -> bool,
) {
    let Some(stream) = stream else { return };
    let flags: Vec<bool> = times_s.iter().map(|t_s| keep(*t_s)).collect();
    stream.values.keep(&flags);
    keep_in(&mut stream.t_s, &flags);
    for column in &mut stream.unknown {
        keep_in(&mut column.cells, &flags);
    }
}

/// Keeps the rows of each stream at whose times, given beside it, `keep` holds.
pub(super) fn keep_all_rows(robot: &mut Robot, times_s: [Vec<f64>; 6], keep: &dyn Fn(f64) -> bool) {
    let [command, wheels, odometry, pose, imu, motor] = times_s;
    keep_rows(&mut robot.command, &command, keep);
    keep_rows(&mut robot.wheels, &wheels, keep);
    keep_rows(&mut robot.odometry, &odometry, keep);
    keep_rows(&mut robot.pose, &pose, keep);
    keep_rows(&mut robot.imu, &imu, keep);
    keep_rows(&mut robot.motor, &motor, keep);
}

/// Keeps the measurements of a robot at times of which `keep` holds.
pub(super) fn keep_measured(robot: &mut Robot, keep: &dyn Fn(f64) -> bool) {
    keep_stream(&mut robot.wheels, keep);
    keep_stream(&mut robot.odometry, keep);
    keep_stream(&mut robot.pose, keep);
    keep_stream(&mut robot.imu, keep);
    keep_stream(&mut robot.motor, keep);
}

/// Keeps what a robot was told at times of which `keep` holds, and the last command before them.
pub(super) fn keep_told(robot: &mut Robot, [from_s, to_s]: [f64; 2]) {
    let Some(stream) = &robot.command else { return };
    let first = stream.t_s.partition_point(|t_s| *t_s <= from_s).max(1) - 1;
    let begin_s = stream.t_s.get(first).copied().unwrap_or(from_s);
    keep_stream(&mut robot.command, &|t_s| t_s >= begin_s && t_s <= to_s);
}

/// The times of all streams of a robot.
pub(super) fn times(robot: &mut Robot) -> impl Iterator<Item = &mut f64> {
    let command = robot.command.iter_mut().flat_map(|own| &mut own.t_s);
    let wheels = robot.wheels.iter_mut().flat_map(|own| &mut own.t_s);
    let odometry = robot.odometry.iter_mut().flat_map(|own| &mut own.t_s);
    let pose = robot.pose.iter_mut().flat_map(|own| &mut own.t_s);
    let imu = robot.imu.iter_mut().flat_map(|own| &mut own.t_s);
    let motor = robot.motor.iter_mut().flat_map(|own| &mut own.t_s);
    command
        .chain(wheels)
        .chain(odometry)
        .chain(pose)
        .chain(imu)
        .chain(motor)
}

/// Begin and end of what was measured (s): the end lies before the begin where nothing was.
pub fn span_s(robot: &Robot) -> [f64; 2] {
    let wheels = robot.wheels.iter().flat_map(|own| &own.t_s);
    let pose = robot.pose.iter().flat_map(|own| &own.t_s);
    let imu = robot.imu.iter().flat_map(|own| &own.t_s);
    wheels
        .chain(pose)
        .chain(imu)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t_s| {
            [a.min(*t_s), b.max(*t_s)]
        })
}
