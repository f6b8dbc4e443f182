//! The streams of a robot, and the column sets that each stream can have.

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

    /// The kind with this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The sets of columns besides `t_s`. A stream has exactly one of them.
    pub(crate) fn column_sets(self) -> &'static [ColumnSet] {
        const fn all(names: &'static [&'static str]) -> ColumnSet {
            ColumnSet {
                names,
                required: names.len(),
            }
        }
        const fn first(required: usize, names: &'static [&'static str]) -> ColumnSet {
            ColumnSet { names, required }
        }
        match self {
            Self::Command => {
                &const {
                    [
                        all(&["torque_right_nm", "torque_left_nm"]),
                        all(&["voltage_right_v", "voltage_left_v"]),
                        all(&["speed_right_rad_s", "speed_left_rad_s"]),
                        all(&["v_m_s", "w_rad_s"]),
                    ]
                }
            }
            Self::Wheels => {
                &const {
                    [
                        all(&["ticks_right", "ticks_left"]),
                        all(&["angle_right_rad", "angle_left_rad"]),
                        all(&["speed_right_rad_s", "speed_left_rad_s"]),
                    ]
                }
            }
            Self::Odometry => &const { [first(1, &["v_m_s", "w_rad_s"])] },
            Self::Pose => &const { [first(2, &["x_m", "y_m", "yaw_rad"])] },
            Self::Imu => &const { [first(0, &["ax_m_s2", "ay_m_s2", "gz_rad_s"])] },
            Self::Motor => {
                &const { [first(0, &["current_right_a", "current_left_a", "supply_v"])] }
            }
        }
    }

    /// Whether a stream with this column is of no use where the column is empty.
    pub(crate) fn needs(self, column: &str) -> bool {
        let sets = self.column_sets().iter();
        let mut required = sets.flat_map(|set| set.names.iter().take(set.required));
        required.any(|name| *name == column)
    }

    /// The column of this kind with this name, if the format defines it.
    pub(crate) fn column(self, name: &str) -> Option<&'static str> {
        self.column_sets()
            .iter()
            .flat_map(|set| set.names)
            .copied()
            .find(|known| *known == name)
    }
}

/// Columns that belong together. The first `required` of `names` must be present.
#[derive(Debug)]
pub(crate) struct ColumnSet {
    /// The columns, in the order of writing.
    pub(crate) names: &'static [&'static str],
    required: usize,
}

impl ColumnSet {
    /// The columns of the set that are in `present`, in the order of writing.
    pub(crate) fn present(&self, present: &[&'static str]) -> Vec<&'static str> {
        let names = self.names.iter().copied();
        names.filter(|name| present.contains(name)).collect()
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
            .filter(|set| set.names.iter().any(|name| present.contains(name)))
            .collect();
        let remedy = || {
            let sets: Vec<String> = sets.iter().map(|set| set.names.join(",")).collect();
            format!("give t_s and {}", sets.join(" or "))
        };
        match matching.as_slice() {
            [] => Err(("no known column besides t_s".to_owned(), remedy())),
            [set] => match set
                .names
                .iter()
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
                    first.names.join(","),
                    second.names.join(",")
                ),
                "keep one of them".to_owned(),
            )),
        }
    }
}
