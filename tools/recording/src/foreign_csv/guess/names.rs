//! Columns that people named by hand: `time;enc_left;enc_right;x;y;theta`.

use super::columns::Columns;
use super::guessed::{Guessed, OF_ODOMETRY};
use super::pairs;
use super::times;
use super::units::{Dimension, unit_after};
use crate::foreign_csv::entry::{ColumnEntry, Source, TimeEntry};
use crate::table::StreamKind;

/// A set of columns, each with the words by which a name may mean it: `cmd v` are two words of one name, in any
/// order; ` or ` separates names. A unit may follow, and must after a name with `*`.
type Set = (StreamKind, &'static [(&'static str, &'static str)]);

/// Words beside those of a pose, of references first.
const OF_POSES: [&str; 13] = [
    "",
    "gt",
    "ground truth",
    "true",
    "truth",
    "mocap",
    "vicon",
    "optitrack",
    "camera",
    "cam",
    "robot",
    "odom",
    "est",
];
/// Words of poses that are the robot's own estimate.
const ESTIMATES: [&str; 2] = ["odom", "est"];
const X: &str = "pos x or pose x or position x or tx or p rs r x or *x";
const Y: &str = "pos y or pose y or position y or ty or p rs r y or *y";
const YAW: &str =
    "yaw or theta or heading or pose yaw or pose theta or orientation or psi or winkel";
/// Parts of a quaternion: x, y, z, w.
const QUATERNION: [&str; 4] = [
    "qx or q x or quat x or q rs x or orientation x",
    "qy or q y or quat y or q rs y or orientation y",
    "qz or q z or quat z or q rs z or orientation z",
    "qw or q w or quat w or q rs w or orientation w",
];
const RATE: &str = "gz or gyro z or imu gz or imu yaw rate or w rs s z or gyr z or gyro";

const SETS: [Set; 5] = [
    (
        StreamKind::Command,
        &[
            (
                "v_m_s",
                "cmd v or command v or v ref or cmd linear or v des or cmd vel linear or cmd vel x or linear cmd",
            ),
            (
                "w_rad_s",
                "cmd w or command w or w ref or cmd angular or w des or cmd omega or cmd vel angular or cmd vel theta",
            ),
        ],
    ),
    (
        StreamKind::Odometry,
        &[
            (
                "v_m_s",
                "v or odom v or speed or linear vel or vel or linear velocity or forward velocity or linear speed",
            ),
            (
                "w_rad_s",
                "w or omega or odom w or yaw rate or angular vel or angular velocity or angular speed or turn rate",
            ),
        ],
    ),
    (
        StreamKind::Imu,
        &[
            ("gz_rad_s", RATE),
            ("ax_m_s2", "ax or acc x or accel x or imu ax or a rs s x"),
            ("ay_m_s2", "ay or acc y or accel y or imu ay or a rs s y"),
        ],
    ),
    (StreamKind::Imu, &[("gz_rad_s", RATE)]),
    (
        StreamKind::Motor,
        &[(
            "supply_v",
            "battery voltage or supply voltage or vbat or v bat or bus voltage or battery or supply",
        )],
    ),
];

/// The streams that the names suggest.
pub(super) fn guess(columns: &Columns<'_>) -> Vec<Guessed> {
    // The stamp of the only message outweighs the time at which it came.
    let stamp = times::of_message(columns, <[String]>::is_empty);
    let Some(time) = stamp.or_else(|| times::of_file(columns)) else {
        return Vec::new();
    };
    let names = ColumnNames(columns);
    let mut guessed: Vec<Guessed> = names.poses(&time).into_iter().collect();
    guessed.extend(pairs::guess(columns, &time));
    for (kind, set) in &SETS {
        let source = |(column, wanted): &(&'static str, &str)| {
            let entry = names.find(wanted, Dimension::of(column))?;
            Some((*column, Source::One(entry)))
        };
        let sources: Option<Vec<_>> = set.iter().map(source).collect();
        let known = guessed.iter_mut().find(|own| own.kind == *kind);
        match (sources, known) {
            // A supply beside currents.
            (Some(sources), Some(known)) if *kind == StreamKind::Motor => {
                known.columns.extend(sources);
            }
            (Some(sources), None) => guessed.push(Guessed::new(*kind, time.clone(), sources)),
            _ => {}
        }
    }
    guessed
}

/// The names of a file's columns.
struct ColumnNames<'a>(&'a Columns<'a>);

impl ColumnNames<'_> {
    /// The column that one of these names means.
    fn find(&self, wanted: &str, dimension: Dimension) -> Option<ColumnEntry> {
        wanted.split(" or ").find_map(|wanted| {
            let mut names = self.0.words.iter().enumerate();
            names.find_map(|(index, name)| {
                let plain = wanted.trim_start_matches('*');
                let unit = unit_after(name, plain, dimension)?;
                let fits = plain == wanted || unit.is_said();
                fits.then(|| self.0.entry(index, unit.factor()))
            })
        })
    }

    /// The pose of the best reference.
    fn poses(&self, time: &TimeEntry) -> Option<Guessed> {
        OF_POSES.iter().find_map(|of| {
            let pose = self.pose(of, time)?;
            Some(match ESTIMATES.contains(of) {
                true => pose.with_note(OF_ODOMETRY),
                false => pose,
            })
        })
    }

    /// A pose whose names have these words: with a yaw, or with names that can mean nothing else.
    fn pose(&self, of: &str, time: &TimeEntry) -> Option<Guessed> {
        let find = |names: &str, dimension| {
            let mut names = names.split(" or ");
            names.find_map(|name| {
                let star = if name.starts_with('*') { "*" } else { "" };
                let name = name.trim_start_matches('*');
                self.find(format!("{star}{of} {name}").trim_start(), dimension)
            })
        };
        let yaw = find(YAW, Dimension::Angle).map(Source::One);
        let yaw = yaw.or_else(|| {
            let [x, y, z, w] = QUATERNION.map(|names| find(names, Dimension::One));
            Some(Source::Quaternion([x, y], [z?, w?]))
        });
        let place = |names: &str, bare: &str| {
            let bare = || find(bare, Dimension::Length).filter(|_| yaw.is_some());
            find(names, Dimension::Length).or_else(bare)
        };
        let mut columns = vec![
            ("x_m", Source::One(place(X, "x")?)),
            ("y_m", Source::One(place(Y, "y")?)),
        ];
        columns.extend(yaw.map(|yaw| ("yaw_rad", yaw)));
        Some(Guessed::new(StreamKind::Pose, time.clone(), columns))
    }
}
