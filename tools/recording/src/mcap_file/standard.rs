//! The standard messages of each stream: which type, which topic, what goes where.

use std::io::Write;

use crate::bag::{BagWriter, Channel};
use crate::error::Result;
use crate::ros2::MessageType;
use crate::ros2::compose::{WORLD, header, imu, joint_state};
use crate::ros2::messages::{self as ros, Pose, Quaternion, Twist, Vector3};
use crate::ros2::time::is_whole_ns;
use crate::table::{CellsView, StreamKind, TableView};

/// The standard message of a stream and the name of its topic.
pub(crate) fn standard(kind: StreamKind, table: &TableView<'_>) -> (MessageType, &'static str) {
    let first = table.columns.first().map_or("", |(name, _)| *name);
    match (kind, first) {
        (StreamKind::Command, "voltage_right_v") => (MessageType::WheelVoltage, "command"),
        (StreamKind::Command, "v_m_s") => (MessageType::TwistStamped, "command"),
        (StreamKind::Command, _) => (MessageType::JointState, "command"),
        (StreamKind::Wheels, "ticks_right") => (MessageType::EncoderTicks, "encoder_ticks"),
        (StreamKind::Wheels, _) => (MessageType::JointState, "joint_states"),
        (StreamKind::Odometry, _) => (MessageType::TwistStamped, "odometry"),
        (StreamKind::Pose, _) => (MessageType::PoseStamped, "pose"),
        (StreamKind::Imu, _) => (MessageType::Imu, "imu"),
        (StreamKind::Motor, _) => (MessageType::MotorState, "motor"),
    }
}

/// Whether the standard messages give every row of the stream back bit for bit.
pub(crate) fn holds(table: &TableView<'_>) -> bool {
    let same =
        |yaw: &f64| yaw.is_nan() || Quaternion::from_yaw(*yaw).yaw().to_bits() == yaw.to_bits();
    table.unknown.is_empty()
        && table.t_s.iter().all(|t_s| is_whole_ns(*t_s))
        && table.columns.iter().all(|(name, cells)| match cells {
            CellsView::Counts(counts) => counts.iter().all(Option::is_some),
            CellsView::Numbers(yaws) if *name == "yaw_rad" => yaws.iter().all(same),
            CellsView::Numbers(_) => true,
        })
}

/// Writes a row as its standard message.
pub(crate) fn write_standard<W: Write>(
    bag: &mut BagWriter<W>,
    channel: Channel,
    kind: StreamKind,
    table: &TableView<'_>,
    t_ns: i64,
    row: usize,
) -> Result<()> {
    let named = |name| named(table, name, row);
    let pair = [cell(table, 0, row), cell(table, 1, row)];
    let first = table.columns.first().map_or("", |(name, _)| *name);
    match (kind, first) {
        (StreamKind::Command, "torque_right_nm") => {
            bag.write(channel, t_ns, &joint_state(t_ns, &[], &[], &pair))
        }
        (StreamKind::Command, "voltage_right_v") => {
            let [right_v, left_v] = pair;
            let header = header(t_ns, "");
            bag.write(
                channel,
                t_ns,
                &ros::WheelVoltage {
                    header,
                    right_v,
                    left_v,
                },
            )
        }
        (StreamKind::Command | StreamKind::Wheels, "speed_right_rad_s") => {
            bag.write(channel, t_ns, &joint_state(t_ns, &[], &pair, &[]))
        }
        (StreamKind::Wheels, "ticks_right") => {
            let [right, left] = [0, 1].map(|i| count(table, i, row));
            let header = header(t_ns, "");
            bag.write(
                channel,
                t_ns,
                &ros::EncoderTicks {
                    header,
                    right,
                    left,
                },
            )
        }
        (StreamKind::Wheels, _) => bag.write(channel, t_ns, &joint_state(t_ns, &pair, &[], &[])),
        (StreamKind::Command | StreamKind::Odometry, _) => {
            let twist = Twist::planar(named("v_m_s"), 0.0, named("w_rad_s"));
            let header = header(t_ns, "");
            bag.write(channel, t_ns, &ros::TwistStamped { header, twist })
        }
        (StreamKind::Pose, _) => {
            let has_yaw = table.columns.iter().any(|(name, _)| *name == "yaw_rad");
            let yaw_rad = if has_yaw { named("yaw_rad") } else { 0.0 };
            let header = header(t_ns, WORLD);
            let pose = Pose {
                position: Vector3::new(named("x_m"), named("y_m"), 0.0),
                orientation: Quaternion::from_yaw(yaw_rad),
            };
            bag.write(channel, t_ns, &ros::PoseStamped { header, pose })
        }
        (StreamKind::Imu, _) => {
            let values = ["ax_m_s2", "ay_m_s2", "gz_rad_s"].map(named);
            bag.write(channel, t_ns, &imu(t_ns, values))
        }
        (StreamKind::Motor, _) => {
            let message = ros::MotorState {
                header: header(t_ns, ""),
                current_right_a: named("current_right_a"),
                current_left_a: named("current_left_a"),
                supply_v: named("supply_v"),
            };
            bag.write(channel, t_ns, &message)
        }
    }
}

/// The number in a row; NaN where there is none.
pub(crate) fn at(numbers: &[f64], row: usize) -> f64 {
    numbers.get(row).copied().unwrap_or(f64::NAN)
}

/// The number in column `i`; NaN where it is empty or there is none.
pub(crate) fn cell(table: &TableView<'_>, i: usize, row: usize) -> f64 {
    match table.columns.get(i) {
        Some((_, CellsView::Numbers(cells))) => at(cells, row),
        Some((_, CellsView::Counts(cells))) => {
            let count = cells.get(row).copied().flatten();
            count.map_or(f64::NAN, |count| count as f64)
        }
        None => f64::NAN,
    }
}

fn named(table: &TableView<'_>, name: &str, row: usize) -> f64 {
    let column = table.columns.iter().position(|(known, _)| *known == name);
    column.map_or(f64::NAN, |i| cell(table, i, row))
}

/// The count in column `i`; 0 where it is empty, for viewers only.
fn count(table: &TableView<'_>, i: usize, row: usize) -> i64 {
    match table.columns.get(i) {
        Some((_, CellsView::Counts(cells))) => cells.get(row).copied().flatten().unwrap_or(0),
        _ => 0,
    }
}
