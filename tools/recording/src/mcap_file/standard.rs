//! Standard ROS 2 messages of each stream: the message of a row.

use slipstream_bag::ros::compose::{WORLD, header, imu, joint_state};
use slipstream_bag::ros::messages::{self as ros, Pose, Quaternion, Twist, Vector3};
use slipstream_bag::ros::time::is_whole_ns;
use slipstream_bag::{BagWriter, Channel, Result};

use crate::table::{Cells, StreamKind, Table};

/// Name of the first column, which identifies the column set.
pub(super) fn first_column(table: &Table) -> &'static str {
    table.columns.first().map_or("", |(name, _)| *name)
}

/// Whether the standard messages represent these rows bit for bit.
pub(super) fn is_lossless(table: &Table) -> bool {
    let round_trips =
        |yaw: &f64| yaw.is_nan() || Quaternion::from_yaw(*yaw).yaw().to_bits() == yaw.to_bits();
    table.t_s.iter().all(|t_s| is_whole_ns(*t_s))
        && table.columns.iter().all(|(name, cells)| match cells {
            Cells::Counts(counts) => counts.iter().all(Option::is_some),
            Cells::Numbers(yaws) if *name == "yaw_rad" => yaws.iter().all(round_trips),
            Cells::Numbers(_) | Cells::Texts(_) => true,
        })
}

/// Writes a row as its standard message.
pub(super) fn write_standard(
    bag: &mut BagWriter<'_>,
    channel: Channel,
    kind: StreamKind,
    table: &Table,
    t_ns: i64,
    row: usize,
) -> Result<()> {
    let named = |name| table.number_named(name, row);
    let pair = [table.number(0, row), table.number(1, row)];
    match (kind, first_column(table)) {
        (StreamKind::Command, "torque_right_nm") => {
            bag.write(channel, t_ns, &joint_state(t_ns, &[], &[], &pair))
        }
        (StreamKind::Command, "voltage_right_v") => {
            bag.write(channel, t_ns, &wheel_voltage(t_ns, pair))
        }
        (StreamKind::Command | StreamKind::Wheels, "speed_right_rad_s") => {
            bag.write(channel, t_ns, &joint_state(t_ns, &[], &pair, &[]))
        }
        (StreamKind::Wheels, "ticks_right") => {
            // The rows are lossless; here, for viewers only, an empty count becomes 0.
            let counts = [0, 1].map(|i| table.count(i, row).unwrap_or(0));
            bag.write(channel, t_ns, &encoder_ticks(t_ns, counts))
        }
        (StreamKind::Wheels, _) => bag.write(channel, t_ns, &joint_state(t_ns, &pair, &[], &[])),
        (StreamKind::Command | StreamKind::Odometry, _) => {
            let twist = Twist::planar(named("v_m_s"), 0.0, named("w_rad_s"));
            let header = header(t_ns, "");
            bag.write(channel, t_ns, &ros::TwistStamped { header, twist })
        }
        (StreamKind::Pose, _) => bag.write(channel, t_ns, &pose(t_ns, table, row)),
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

fn wheel_voltage(t_ns: i64, [right_v, left_v]: [f64; 2]) -> ros::WheelVoltage<&'static str> {
    ros::WheelVoltage {
        header: header(t_ns, ""),
        right_v,
        left_v,
    }
}

fn encoder_ticks(t_ns: i64, [right, left]: [i64; 2]) -> ros::EncoderTicks<&'static str> {
    ros::EncoderTicks {
        header: header(t_ns, ""),
        right,
        left,
    }
}

/// A pose without a column of headings gets the heading 0.
fn pose(t_ns: i64, table: &Table, row: usize) -> ros::PoseStamped<&'static str> {
    let named = |name| table.number_named(name, row);
    let has_yaw = table.columns.iter().any(|(name, _)| *name == "yaw_rad");
    let yaw_rad = if has_yaw { named("yaw_rad") } else { 0.0 };
    ros::PoseStamped {
        header: header(t_ns, WORLD),
        pose: Pose {
            position: Vector3::new(named("x_m"), named("y_m"), 0.0),
            orientation: Quaternion::from_yaw(yaw_rad),
        },
    }
}
