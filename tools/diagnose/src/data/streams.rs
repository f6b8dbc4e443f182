//! The streams of a robot row by row, for whatever filters them: one reading of each.

use std::f64::consts::TAU;

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command as Told, Robot, Wheels as Recorded};
use slipstream_sim::Command;

/// Rows of a stream: stamp (s) and values, in the order of the recording.
pub(crate) type Rows<const N: usize> = Vec<(f64, [f64; N])>;

/// What a row of the wheels holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WheelKind {
    Angle,
    Speed,
}

/// Both wheels, [right, left] (rad, or rad/s).
pub(super) struct Wheels {
    pub(super) kind: WheelKind,
    /// Standard deviation of a rounding to whole counts (rad); `None` where there are none.
    pub(super) rounding_rad: Option<f64>,
    pub(super) rows: Rows<2>,
}

/// The rows that have both wheels; `None` without wheels, or where counts per turn are unknown.
///
/// A counter rounds down, so that the true angle lies half a count above on average. That is left out: it is the same
/// in all rows, and where a wheel began is not known either.
pub(super) fn wheels(robot: &Robot, model: &RobotModel) -> Option<Wheels> {
    let stream = robot.wheels.as_ref()?;
    let pairs = |right: &[f64], left: &[f64]| both(&stream.t_s, right, left);
    Some(match &stream.values {
        Recorded::Ticks { right, left } => {
            let tick = TAU / robot.counts_per_rev(Some(model))?;
            let angles = |counts: &[Option<i64>]| -> Vec<f64> {
                let angle = |count: &Option<i64>| count.map_or(f64::NAN, |n| n as f64 * tick);
                counts.iter().map(angle).collect()
            };
            Wheels {
                kind: WheelKind::Angle,
                rounding_rad: Some(tick / 12.0_f64.sqrt()),
                rows: pairs(&angles(right), &angles(left)),
            }
        }
        Recorded::Angle {
            right_rad,
            left_rad,
        } => Wheels {
            kind: WheelKind::Angle,
            rounding_rad: None,
            rows: pairs(right_rad, left_rad),
        },
        Recorded::Speed {
            right_rad_s,
            left_rad_s,
        } => Wheels {
            kind: WheelKind::Speed,
            rounding_rad: None,
            rows: pairs(right_rad_s, left_rad_s),
        },
    })
}

/// From when (s) each command holds; empty without commands.
pub(super) fn commands(robot: &Robot) -> Vec<(f64, Command)> {
    let Some(stream) = &robot.command else {
        return Vec::new();
    };
    let pair = |a: &[f64], b: &[f64], make: fn([f64; 2]) -> Command| {
        let rows = both(&stream.t_s, a, b).into_iter();
        rows.map(|(t_s, row)| (t_s, make(row))).collect()
    };
    match &stream.values {
        Told::Torque { right_nm, left_nm } => pair(right_nm, left_nm, |[right_nm, left_nm]| {
            Command::Torque { right_nm, left_nm }
        }),
        Told::Voltage { right_v, left_v } => pair(right_v, left_v, |[right_v, left_v]| {
            Command::Voltage { right_v, left_v }
        }),
        Told::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => pair(right_rad_s, left_rad_s, |[right_rad_s, left_rad_s]| {
            Command::Speed {
                right_rad_s,
                left_rad_s,
            }
        }),
        Told::Twist { v_m_s, w_rad_s } => pair(v_m_s, w_rad_s, |[v_m_s, w_rad_s]| Command::Twist {
            v_m_s,
            w_rad_s,
        }),
    }
}

/// Poses: x and y (m), and yaw (rad); NaN what was not seen. `None` without poses.
pub(crate) fn poses(robot: &Robot) -> Option<Rows<3>> {
    let stream = robot.pose.as_ref()?;
    let values = &stream.values;
    let rows = stream.t_s.iter().enumerate().map(|(i, t_s)| {
        let yaw_rad = values.yaw_rad.as_ref().map_or(f64::NAN, |yaw| yaw[i]);
        (*t_s, [values.x_m[i], values.y_m[i], yaw_rad])
    });
    Some(
        rows.filter(|(_, [x, y, yaw])| x.is_finite() && y.is_finite() || yaw.is_finite())
            .collect(),
    )
}

/// Speed (m/s) and turn rate (rad/s) as the robot estimates them; NaN what it does not. `None` without odometry.
pub(super) fn odometry(robot: &Robot) -> Option<Rows<2>> {
    let stream = robot.odometry.as_ref()?;
    let values = &stream.values;
    let rows = stream.t_s.iter().enumerate().map(|(i, t_s)| {
        let w_rad_s = values.w_rad_s.as_ref().map_or(f64::NAN, |w| w[i]);
        (*t_s, [values.v_m_s[i], w_rad_s])
    });
    Some(rows.collect())
}

/// Accelerations along and across (m/s²) and turn rate (rad/s); NaN what was not measured. `None` without an
/// inertial sensor.
pub(super) fn inertial(robot: &Robot) -> Option<Rows<3>> {
    let stream = robot.imu.as_ref()?;
    let values = &stream.values;
    let axes = [&values.ax_m_s2, &values.ay_m_s2, &values.gz_rad_s];
    let rows = stream.t_s.iter().enumerate().map(|(i, t_s)| {
        let value = |axis: &Option<Vec<f64>>| axis.as_ref().map_or(f64::NAN, |own| own[i]);
        (*t_s, axes.map(value))
    });
    Some(rows.collect())
}

/// Turn rates (rad/s) of the gyro; or, without one, of poses that are headings alone, between each two.
pub(super) fn turn_rates(robot: &Robot) -> Option<Vec<(f64, f64)>> {
    if !has_headings_alone(robot) {
        let rows = inertial(robot)?.into_iter();
        return Some(rows.map(|(t_s, [.., rate])| (t_s, rate)).collect());
    }
    let headings = poses(robot)?;
    let rates = headings.windows(2).map(|pair| {
        let [(from_s, [.., from]), (to_s, [.., to])] = [pair[0], pair[1]];
        let turned = to - from - TAU * ((to - from) / TAU).round();
        (f64::midpoint(from_s, to_s), turned / (to_s - from_s))
    });
    Some(rates.collect())
}

/// Whether headings are all that is known of a robot beside its wheels.
pub(crate) fn has_headings_alone(robot: &Robot) -> bool {
    let has_headings = poses(robot).is_some_and(|rows| !rows.is_empty());
    robot.imu.is_none() && has_headings && !has_places(robot)
}

/// Whether any pose has a place.
pub(crate) fn has_places(robot: &Robot) -> bool {
    let poses = poses(robot).unwrap_or_default();
    poses
        .iter()
        .any(|(_, [x, y, _])| x.is_finite() && y.is_finite())
}

/// The rows in which both are known.
fn both(times_s: &[f64], a: &[f64], b: &[f64]) -> Rows<2> {
    let rows = times_s.iter().zip(a.iter().zip(b));
    rows.filter(|(_, (a, b))| a.is_finite() && b.is_finite())
        .map(|(t_s, (a, b))| (*t_s, [*a, *b]))
        .collect()
}

#[cfg(test)]
mod tests {
    use slipstream_recording::recording::Stream;

    use super::*;

    #[test]
    fn a_row_without_one_of_both_counts_is_left_out() {
        let mut robot = Robot::named("r1");
        robot.encoder_counts_per_rev = Some(100.0);
        robot.wheels = Some(Stream {
            t_s: vec![0.0, 0.1, 0.2],
            values: Recorded::Ticks {
                right: vec![Some(0), None, Some(25)],
                left: vec![Some(-50), Some(0), Some(100)],
            },
            unknown: vec![],
        });
        let read = wheels(&robot, &RobotModel::default()).unwrap();
        assert_eq!(read.kind, WheelKind::Angle);
        let tick = TAU / 100.0;
        let rows = [
            (0.0, [0.0, -50.0 * tick]),
            (0.2, [25.0 * tick, 100.0 * tick]),
        ];
        assert_eq!(read.rows, rows);
        // of what is even over a count, the root mean square is a twelfth's root of it
        let deviation = read.rounding_rad.unwrap();
        assert!((deviation - tick / 12.0_f64.sqrt()).abs() < 1e-15);
    }
}
