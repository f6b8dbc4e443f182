//! Rows of recordings, to be compared.

use std::collections::BTreeMap;

use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Robot, Stream, Wheels};

/// Rows by robot and stream: the time and the values, as bits.
pub(crate) type Rows = BTreeMap<String, Vec<Vec<u64>>>;

/// All rows of several pieces.
pub(crate) fn rows<'a>(pieces: impl IntoIterator<Item = &'a Recording>) -> Rows {
    let mut all = Rows::new();
    for robot in pieces.into_iter().flat_map(|piece| &piece.robots) {
        add_robot(robot, &mut all);
    }
    all.retain(|_, rows| !rows.is_empty());
    all
}

fn add_robot(robot: &Robot, all: &mut Rows) {
    let mut add = |kind: &str, rows: Vec<Vec<u64>>| {
        let name = format!("{}/{kind}", robot.name);
        all.entry(name).or_default().extend(rows);
    };
    if let Some(own) = &robot.command {
        let (kind, [a, b]) = match &own.values {
            Command::Torque { right_nm, left_nm } => ("torque", [right_nm, left_nm]),
            Command::Voltage { right_v, left_v } => ("voltage", [right_v, left_v]),
            Command::WheelSpeed {
                right_rad_s,
                left_rad_s,
            } => ("wheel speed", [right_rad_s, left_rad_s]),
            Command::Twist { v_m_s, w_rad_s } => ("twist", [v_m_s, w_rad_s]),
        };
        add(kind, numbers(own, &[a, b]));
    }
    if let Some(own) = &robot.wheels {
        let count = |cell: &Option<i64>| cell.map_or(f64::NAN, |count| count as f64);
        let (kind, [a, b]) = match &own.values {
            Wheels::Ticks { right, left } => (
                "ticks",
                [right, left].map(|own| own.iter().map(count).collect()),
            ),
            Wheels::Angle {
                right_rad,
                left_rad,
            } => ("angle", [right_rad, left_rad].map(Clone::clone)),
            Wheels::Speed {
                right_rad_s,
                left_rad_s,
            } => ("speed", [right_rad_s, left_rad_s].map(Clone::clone)),
        };
        add(kind, numbers(own, &[&a, &b]));
    }
    if let Some(own) = &robot.odometry {
        let columns: Vec<&Vec<f64>> = std::iter::once(&own.values.v_m_s)
            .chain(&own.values.w_rad_s)
            .collect();
        add("odometry", numbers(own, &columns));
    }
    if let Some(own) = &robot.pose {
        let pose = &own.values;
        let columns: Vec<&Vec<f64>> = [&pose.x_m, &pose.y_m]
            .into_iter()
            .chain(&pose.yaw_rad)
            .collect();
        add("pose", numbers(own, &columns));
    }
    if let Some(own) = &robot.imu {
        let imu = [
            &own.values.ax_m_s2,
            &own.values.ay_m_s2,
            &own.values.gz_rad_s,
        ];
        let columns: Vec<&Vec<f64>> = imu.into_iter().flatten().collect();
        add("imu", numbers(own, &columns));
    }
}

fn numbers<V>(stream: &Stream<V>, columns: &[&Vec<f64>]) -> Vec<Vec<u64>> {
    let row = |(row, t_s): (usize, &f64)| {
        let cells = columns.iter().map(|own| own[row].to_bits());
        std::iter::once(t_s.to_bits()).chain(cells).collect()
    };
    stream.t_s.iter().enumerate().map(row).collect()
}

/// Says in which streams rows differ.
pub(crate) fn assert_same(own: &Rows, other: &Rows) {
    let names = |rows: &Rows| rows.keys().cloned().collect::<Vec<String>>();
    assert_eq!(names(own), names(other));
    for (stream, rows) in own {
        let others = &other[stream];
        assert_eq!(rows.len(), others.len(), "{stream}");
        let first = rows.iter().zip(others).position(|(a, b)| a != b);
        assert_eq!(first, None, "{stream}: another row");
    }
}
