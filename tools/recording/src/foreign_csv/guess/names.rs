//! Columns that people named by hand: `time;enc_left;enc_right;x;y;theta`.

use super::guessed::{Guessed, entry};
use super::times;
use super::units::{Dimension, Unit, unit_after, words};
use crate::foreign_csv::entry::{ColumnEntry, Source, TimeEntry};
use crate::foreign_csv::layout::Sample;
use crate::table::StreamKind;

/// A set of columns, each with the words by which a name may mean it: `right enc` are two words of one name, in any
/// order; ` or ` separates names. A unit may follow, and must after a name with `*`.
type Set = (StreamKind, &'static [(&'static str, &'static str)]);

const X: &str = "pos x or pose x or position x or tx or p rs r x or *x";
const Y: &str = "pos y or pose y or position y or ty or p rs r y or *y";
const YAW: &str = "yaw or theta or heading or pose yaw or pose theta";
/// Parts of a quaternion: x, y, z, w.
const QUATERNION: [&str; 4] = [
    "qx or q x or quat x or q rs x or orientation x",
    "qy or q y or quat y or q rs y or orientation y",
    "qz or q z or quat z or q rs z or orientation z",
    "qw or q w or quat w or q rs w or orientation w",
];

const SETS: [Set; 9] = [
    (
        StreamKind::Wheels,
        &[
            (
                "ticks_right",
                "right ticks or right enc or right encoder or r ticks or enc r or encoder r or ticks right",
            ),
            (
                "ticks_left",
                "left ticks or left enc or left encoder or l ticks or enc l or encoder l or ticks left",
            ),
        ],
    ),
    (
        StreamKind::Wheels,
        &[
            (
                "angle_right_rad",
                "right angle or wheel right or wheel r or right pos or right wheel angle or right wheel position",
            ),
            (
                "angle_left_rad",
                "left angle or wheel left or wheel l or left pos or left wheel angle or left wheel position",
            ),
        ],
    ),
    (
        StreamKind::Wheels,
        &[
            (
                "speed_right_rad_s",
                "right speed or speed r or w r or omega r or right vel or right wheel speed or right wheel velocity or *right",
            ),
            (
                "speed_left_rad_s",
                "left speed or speed l or w l or omega l or left vel or left wheel speed or left wheel velocity or *left",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            (
                "v_m_s",
                "cmd v or command v or v ref or cmd linear or v des or cmd vel linear",
            ),
            (
                "w_rad_s",
                "cmd w or command w or w ref or cmd angular or w des or cmd omega or cmd vel angular",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            (
                "voltage_right_v",
                "right voltage or voltage r or u r or v right",
            ),
            (
                "voltage_left_v",
                "left voltage or voltage l or u l or v left",
            ),
        ],
    ),
    (
        StreamKind::Command,
        &[
            ("torque_right_nm", "right torque or torque r or tau r"),
            ("torque_left_nm", "left torque or torque l or tau l"),
        ],
    ),
    (
        StreamKind::Odometry,
        &[
            (
                "v_m_s",
                "v or odom v or speed or linear vel or vel or linear velocity",
            ),
            (
                "w_rad_s",
                "w or omega or odom w or yaw rate or angular vel or angular velocity",
            ),
        ],
    ),
    (
        StreamKind::Imu,
        &[
            ("gz_rad_s", IMU_RATE),
            ("ax_m_s2", "ax or acc x or accel x or imu ax or a rs s x"),
            ("ay_m_s2", "ay or acc y or accel y or imu ay or a rs s y"),
        ],
    ),
    (StreamKind::Imu, &[("gz_rad_s", IMU_RATE)]),
];
const IMU_RATE: &str = "gz or gyro z or imu gz or imu yaw rate or w rs s z or gyr z";

/// The streams that the names suggest.
pub(super) fn guess(sample: &Sample) -> Vec<Guessed> {
    let Some(time) = times::of_file(sample) else {
        return Vec::new();
    };
    let names = Names(sample);
    let mut guessed: Vec<Guessed> = names.pose(&time).into_iter().collect();
    for (kind, columns) in &SETS {
        if guessed.iter().any(|own| own.kind == *kind) {
            continue;
        }
        let source = |(column, wanted): &(&'static str, &str)| {
            let entry = names.find(wanted, Dimension::of(column))?;
            Some((*column, Source::One(entry)))
        };
        let columns: Option<Vec<_>> = columns.iter().map(source).collect();
        if let Some(columns) = columns {
            guessed.push(Guessed::new(*kind, time.clone(), columns));
        }
    }
    guessed
}

/// The names of a file's columns.
struct Names<'a>(&'a Sample);

impl Names<'_> {
    /// The column that one of these names means.
    fn find(&self, wanted: &str, dimension: Dimension) -> Option<ColumnEntry> {
        wanted.split(" or ").find_map(|wanted| {
            let mut names = self.0.layout.names.iter().enumerate();
            names.find_map(|(index, name)| {
                let plain = wanted.trim_start_matches('*');
                let unit = unit_after(&words(name), plain, dimension)?;
                let fits = plain == wanted || unit != Unit::NotSaid;
                fits.then(|| entry(self.0, index, unit.factor()))
            })
        })
    }

    /// A pose: with a yaw, or with names that can mean nothing else.
    fn pose(&self, time: &TimeEntry) -> Option<Guessed> {
        let part = |names: &str| self.find(names, Dimension::One);
        let yaw = self.find(YAW, Dimension::Angle).map(Source::One);
        let yaw = yaw.or_else(|| {
            let [x, y, z, w] = QUATERNION.map(part);
            Some(Source::Quaternion([x, y], [z?, w?]))
        });
        let place = |names: &str, bare: &str| {
            let bare = || self.find(bare, Dimension::Length).filter(|_| yaw.is_some());
            self.find(names, Dimension::Length).or_else(bare)
        };
        let mut columns = vec![
            ("x_m", Source::One(place(X, "x")?)),
            ("y_m", Source::One(place(Y, "y")?)),
        ];
        columns.extend(yaw.map(|yaw| ("yaw_rad", yaw)));
        Some(Guessed::new(StreamKind::Pose, time.clone(), columns))
    }
}
