//! The streams of a robot, and the column sets that each stream can have.

use crate::field::Field;

/// A stream of a robot; one CSV file of the robot's folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StreamKind {
    /// `command.csv`
    Command,
    /// `wheels.csv`
    Wheels,
    /// `odometry.csv`
    Odometry,
    /// `pose.csv`
    Pose,
    /// `imu.csv`
    Imu,
    /// `motor.csv`
    Motor,
}

impl StreamKind {
    /// All kinds, in the order of the format description.
    pub const ALL: [Self; 6] = [
        Self::Command,
        Self::Wheels,
        Self::Odometry,
        Self::Pose,
        Self::Imu,
        Self::Motor,
    ];

    /// Name of the CSV file without `.csv`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Wheels => "wheels",
            Self::Odometry => "odometry",
            Self::Pose => "pose",
            Self::Imu => "imu",
            Self::Motor => "motor",
        }
    }

    /// What the stream has.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Command => "What the actuators were told. A command holds until the next row.",
            Self::Wheels => "Wheel encoders. The first row is not angle zero.",
            Self::Odometry => {
                "The robot's own estimate of its velocity, where encoders were not logged."
            }
            Self::Pose => "Ground truth: camera, motion capture, scan matching.",
            Self::Imu => "Inertial measurement, in the frame of the body.",
            Self::Motor => "Currents and supply of the motors.",
        }
    }

    /// The kind with this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The sets of columns besides `t_s`. A stream has exactly one of them.
    pub fn column_sets(self) -> &'static [ColumnSet] {
        match self {
            Self::Command => &COMMAND,
            Self::Wheels => &WHEELS,
            Self::Odometry => &ODOMETRY,
            Self::Pose => &POSE,
            Self::Imu => &IMU,
            Self::Motor => &MOTOR,
        }
    }

    /// Whether a stream with this column is of no use where the column is empty.
    pub(crate) fn needs(self, column: &str) -> bool {
        let sets = self.column_sets().iter();
        let mut required = sets.flat_map(|set| set.names().take(set.required));
        required.any(|name| name == column)
    }

    /// The column of this kind with this name, if the format defines it.
    pub(crate) fn column(self, name: &str) -> Option<&'static str> {
        self.column_sets()
            .iter()
            .flat_map(ColumnSet::names)
            .find(|known| *known == name)
    }
}

/// Columns that belong together.
#[derive(Debug)]
pub struct ColumnSet {
    /// The columns, in the order of writing.
    pub columns: &'static [Field],
    /// The first so many must be present; of the others any may be.
    pub required: usize,
}

/// The first column of every stream.
pub const TIME: Field = Field::new(
    "t_s",
    "s",
    "Time of the row, never before that of the row above. Any origin (0, a boot, 1970); one clock for all files of a recording.",
);

const COMMAND: [ColumnSet; 4] = [
    ColumnSet::all(&[
        Field::new(
            "torque_right_nm",
            "N m",
            "Torque at the right wheel, positive forwards.",
        ),
        Field::new(
            "torque_left_nm",
            "N m",
            "Torque at the left wheel, positive forwards.",
        ),
    ]),
    ColumnSet::all(&[
        Field::new(
            "voltage_right_v",
            "V",
            "Voltage at the right motor, positive forwards.",
        ),
        Field::new(
            "voltage_left_v",
            "V",
            "Voltage at the left motor, positive forwards.",
        ),
    ]),
    ColumnSet::all(&[
        Field::new(
            "speed_right_rad_s",
            "rad/s",
            "Commanded speed of the right wheel, positive forwards.",
        ),
        Field::new(
            "speed_left_rad_s",
            "rad/s",
            "Commanded speed of the left wheel, positive forwards.",
        ),
    ]),
    ColumnSet::all(&[
        Field::new(
            "v_m_s",
            "m/s",
            "Commanded speed along the body, positive forwards.",
        ),
        Field::new(
            "w_rad_s",
            "rad/s",
            "Commanded turn rate, positive counter-clockwise.",
        ),
    ]),
];

const WHEELS: [ColumnSet; 3] = [
    ColumnSet::all(&[
        Field::new(
            "ticks_right",
            "counts",
            "Counter of the right encoder: signed and cumulative, of any origin, positive forwards.",
        ),
        Field::new(
            "ticks_left",
            "counts",
            "Counter of the left encoder, likewise.",
        ),
    ]),
    ColumnSet::all(&[
        Field::new(
            "angle_right_rad",
            "rad",
            "Angle of the right wheel, not wrapped, of any origin, positive forwards.",
        ),
        Field::new(
            "angle_left_rad",
            "rad",
            "Angle of the left wheel, likewise.",
        ),
    ]),
    ColumnSet::all(&[
        Field::new(
            "speed_right_rad_s",
            "rad/s",
            "Measured speed of the right wheel, positive forwards.",
        ),
        Field::new(
            "speed_left_rad_s",
            "rad/s",
            "Measured speed of the left wheel, positive forwards.",
        ),
    ]),
];

const ODOMETRY: [ColumnSet; 1] = [ColumnSet::first(
    1,
    &[
        Field::new(
            "v_m_s",
            "m/s",
            "Speed along the body by the robot's own estimate.",
        ),
        Field::new(
            "w_rad_s",
            "rad/s",
            "Turn rate by the robot's own estimate, positive counter-clockwise.",
        ),
    ],
)];

const POSE: [ColumnSet; 1] = [ColumnSet::first(
    2,
    &[
        Field::new(
            "x_m",
            "m",
            "Position of the tracked point in the world, first axis.",
        ),
        Field::new(
            "y_m",
            "m",
            "Position of the tracked point in the world, second axis, to the left of the first.",
        ),
        Field::new(
            "yaw_rad",
            "rad",
            "Heading of the body in the world, positive counter-clockwise, wrapped or not.",
        ),
    ],
)];

const IMU: [ColumnSet; 1] = [ColumnSet::first(
    0,
    &[
        Field::new(
            "ax_m_s2",
            "m/s²",
            "Acceleration along the body, at the centre of mass, positive forwards.",
        ),
        Field::new(
            "ay_m_s2",
            "m/s²",
            "Acceleration across the body, at the centre of mass, positive to the left.",
        ),
        Field::new(
            "gz_rad_s",
            "rad/s",
            "Turn rate, positive counter-clockwise.",
        ),
    ],
)];

const MOTOR: [ColumnSet; 1] = [ColumnSet::first(
    0,
    &[
        Field::new("current_right_a", "A", "Current of the right motor."),
        Field::new("current_left_a", "A", "Current of the left motor."),
        Field::new("supply_v", "V", "Voltage of the supply."),
    ],
)];

impl ColumnSet {
    const fn all(columns: &'static [Field]) -> Self {
        Self::first(columns.len(), columns)
    }

    const fn first(required: usize, columns: &'static [Field]) -> Self {
        Self { columns, required }
    }

    /// The names of the columns, in the order of writing.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.columns.iter().map(|column| column.name)
    }

    fn list(&self) -> String {
        self.names().collect::<Vec<_>>().join(",")
    }

    /// The columns of the set that are in `present`, in the order of writing.
    pub(crate) fn present(&self, present: &[&'static str]) -> Vec<&'static str> {
        self.names().filter(|name| present.contains(name)).collect()
    }

    /// The set that the present columns belong to.
    ///
    /// # Errors
    /// Problem and remedy, if they belong to no set or to several, or a required one is missing.
    pub(crate) fn choose(
        kind: StreamKind,
        present: &[&'static str],
    ) -> Result<&'static Self, (String, String)> {
        let sets = kind.column_sets();
        let matching: Vec<&Self> = sets
            .iter()
            .filter(|set| set.names().any(|name| present.contains(&name)))
            .collect();
        let remedy = || {
            let sets: Vec<String> = sets.iter().map(Self::list).collect();
            format!("give t_s and {}", sets.join(" or "))
        };
        match matching.as_slice() {
            [] => Err(("no known column besides t_s".to_owned(), remedy())),
            [set] => match set
                .names()
                .take(set.required)
                .find(|name| !present.contains(name))
            {
                None => Ok(set),
                Some(missing) => Err((format!("column {missing} is missing"), remedy())),
            },
            [first, second, ..] => Err((
                format!(
                    "two {} column sets, {} and {}",
                    kind.name(),
                    first.list(),
                    second.list()
                ),
                "keep one of them".to_owned(),
            )),
        }
    }
}
