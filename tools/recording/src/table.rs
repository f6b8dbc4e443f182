//! Every stream as a plain table: what the formats read and write without knowing robots.
//!
//! [`StreamKind`] lists the files of the format with their columns; [`Table`] holds one stream on
//! its way in, [`TableView`] on its way out.

use crate::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, UnknownColumn, Wheels};

/// A file of a robot's folder.
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

/// The cells of one column.
#[derive(Debug, Clone)]
pub(crate) enum Cells {
    Numbers(Vec<f64>),
    Counts(Vec<Option<i64>>),
}

/// The cells of one column, borrowed.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CellsView<'a> {
    Numbers(&'a [f64]),
    Counts(&'a [Option<i64>]),
}

/// A stream on its way in.
#[derive(Debug, Clone, Default)]
pub(crate) struct Table {
    pub(crate) t_s: Vec<f64>,
    pub(crate) columns: Vec<(&'static str, Cells)>,
    pub(crate) unknown: Vec<UnknownColumn>,
}

/// A stream on its way out.
#[derive(Debug, Clone)]
pub(crate) struct TableView<'a> {
    pub(crate) t_s: &'a [f64],
    pub(crate) columns: Vec<(&'static str, CellsView<'a>)>,
    pub(crate) unknown: &'a [UnknownColumn],
}

impl StreamKind {
    /// All kinds, in the order of the format's description.
    pub const ALL: [Self; 6] = [
        Self::Command,
        Self::Wheels,
        Self::Odometry,
        Self::Pose,
        Self::Imu,
        Self::Motor,
    ];

    /// The file's name without `.csv`.
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

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The columns besides `t_s`, as sets of which a file has exactly one.
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

    /// The known column of that name.
    pub(crate) fn column(self, name: &str) -> Option<&'static str> {
        self.column_sets()
            .iter()
            .flat_map(|set| set.names)
            .copied()
            .find(|known| *known == name)
    }
}

/// Columns that come together: of `names`, the first `required` must be there.
#[derive(Debug)]
pub(crate) struct ColumnSet {
    pub(crate) names: &'static [&'static str],
    required: usize,
}

impl ColumnSet {
    /// The set that the columns present belong to, or what is wrong with them and the remedy.
    pub(crate) fn choose(
        kind: StreamKind,
        present: &[&'static str],
    ) -> Result<&'static Self, (String, String)> {
        let sets = kind.column_sets();
        let touched: Vec<&Self> = sets
            .iter()
            .filter(|set| set.names.iter().any(|name| present.contains(name)))
            .collect();
        let spelled = || {
            let sets: Vec<String> = sets.iter().map(|set| set.names.join(",")).collect();
            format!("give t_s and {}", sets.join(" or "))
        };
        match touched.as_slice() {
            [] => Err(("no known column beside t_s".to_owned(), spelled())),
            [set] => match set
                .names
                .iter()
                .take(set.required)
                .find(|name| !present.contains(name))
            {
                None => Ok(set),
                Some(missing) => Err((format!("column {missing} is missing"), spelled())),
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

/// Whether a column holds whole numbers.
pub(crate) fn is_count(column: &str) -> bool {
    column.starts_with("ticks_")
}

impl Cells {
    /// No cells yet, of the type that `column` holds.
    pub(crate) fn of(column: &str) -> Self {
        if is_count(column) {
            Self::Counts(Vec::new())
        } else {
            Self::Numbers(Vec::new())
        }
    }

    fn numbers(self) -> Vec<f64> {
        match self {
            Self::Numbers(numbers) => numbers,
            Self::Counts(_) => Vec::new(),
        }
    }

    fn counts(self) -> Vec<Option<i64>> {
        match self {
            Self::Counts(counts) => counts,
            Self::Numbers(_) => Vec::new(),
        }
    }
}

impl Table {
    fn take(&mut self, name: &str) -> Option<Cells> {
        let at = self.columns.iter().position(|(known, _)| *known == name)?;
        Some(self.columns.swap_remove(at).1)
    }

    fn numbers(&mut self, name: &str) -> Option<Vec<f64>> {
        self.take(name).map(Cells::numbers)
    }

    fn pair(&mut self, right: &str, left: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        let right = self.numbers(right)?;
        Some((right, self.numbers(left)?))
    }

    fn into_stream<V>(self, values: V) -> Stream<V> {
        Stream {
            t_s: self.t_s,
            values,
            unknown: self.unknown,
        }
    }

    /// Makes this table the robot's stream. The columns have passed [`ColumnSet::choose`].
    pub(crate) fn give_to(mut self, robot: &mut Robot, kind: StreamKind) {
        match kind {
            StreamKind::Command => {
                robot.command = self.command().map(|values| self.into_stream(values));
            }
            StreamKind::Wheels => {
                robot.wheels = self.wheels().map(|values| self.into_stream(values));
            }
            StreamKind::Odometry => {
                let values = Odometry {
                    v_m_s: self.numbers("v_m_s").unwrap_or_default(),
                    w_rad_s: self.numbers("w_rad_s"),
                };
                robot.odometry = Some(self.into_stream(values));
            }
            StreamKind::Pose => {
                let values = Pose {
                    x_m: self.numbers("x_m").unwrap_or_default(),
                    y_m: self.numbers("y_m").unwrap_or_default(),
                    yaw_rad: self.numbers("yaw_rad"),
                };
                robot.pose = Some(self.into_stream(values));
            }
            StreamKind::Imu => {
                let values = Imu {
                    ax_m_s2: self.numbers("ax_m_s2"),
                    ay_m_s2: self.numbers("ay_m_s2"),
                    gz_rad_s: self.numbers("gz_rad_s"),
                };
                robot.imu = Some(self.into_stream(values));
            }
            StreamKind::Motor => {
                let values = Motor {
                    current_right_a: self.numbers("current_right_a"),
                    current_left_a: self.numbers("current_left_a"),
                    supply_v: self.numbers("supply_v"),
                };
                robot.motor = Some(self.into_stream(values));
            }
        }
    }

    fn command(&mut self) -> Option<Command> {
        if let Some((right_nm, left_nm)) = self.pair("torque_right_nm", "torque_left_nm") {
            return Some(Command::Torque { right_nm, left_nm });
        }
        if let Some((right_v, left_v)) = self.pair("voltage_right_v", "voltage_left_v") {
            return Some(Command::Voltage { right_v, left_v });
        }
        if let Some((right_rad_s, left_rad_s)) = self.pair("speed_right_rad_s", "speed_left_rad_s")
        {
            return Some(Command::WheelSpeed {
                right_rad_s,
                left_rad_s,
            });
        }
        let (v_m_s, w_rad_s) = self.pair("v_m_s", "w_rad_s")?;
        Some(Command::Twist { v_m_s, w_rad_s })
    }

    fn wheels(&mut self) -> Option<Wheels> {
        if let Some(right) = self.take("ticks_right") {
            return Some(Wheels::Ticks {
                right: right.counts(),
                left: self.take("ticks_left")?.counts(),
            });
        }
        if let Some((right_rad, left_rad)) = self.pair("angle_right_rad", "angle_left_rad") {
            return Some(Wheels::Angle {
                right_rad,
                left_rad,
            });
        }
        let (right_rad_s, left_rad_s) = self.pair("speed_right_rad_s", "speed_left_rad_s")?;
        Some(Wheels::Speed {
            right_rad_s,
            left_rad_s,
        })
    }
}

impl<'a> TableView<'a> {
    /// The robot's stream of that kind, if it has one.
    pub(crate) fn of(robot: &'a Robot, kind: StreamKind) -> Option<Self> {
        match kind {
            StreamKind::Command => robot
                .command
                .as_ref()
                .map(|s| Self::new(s, command(&s.values))),
            StreamKind::Wheels => robot
                .wheels
                .as_ref()
                .map(|s| Self::new(s, wheels(&s.values))),
            StreamKind::Odometry => robot.odometry.as_ref().map(|s| {
                let Odometry { v_m_s, w_rad_s } = &s.values;
                Self::new(
                    s,
                    present([("v_m_s", Some(v_m_s)), ("w_rad_s", w_rad_s.as_ref())]),
                )
            }),
            StreamKind::Pose => robot.pose.as_ref().map(|s| {
                let Pose { x_m, y_m, yaw_rad } = &s.values;
                Self::new(
                    s,
                    present([
                        ("x_m", Some(x_m)),
                        ("y_m", Some(y_m)),
                        ("yaw_rad", yaw_rad.as_ref()),
                    ]),
                )
            }),
            StreamKind::Imu => robot.imu.as_ref().map(|s| {
                let Imu {
                    ax_m_s2,
                    ay_m_s2,
                    gz_rad_s,
                } = &s.values;
                Self::new(
                    s,
                    present([
                        ("ax_m_s2", ax_m_s2.as_ref()),
                        ("ay_m_s2", ay_m_s2.as_ref()),
                        ("gz_rad_s", gz_rad_s.as_ref()),
                    ]),
                )
            }),
            StreamKind::Motor => robot.motor.as_ref().map(|s| {
                let Motor {
                    current_right_a,
                    current_left_a,
                    supply_v,
                } = &s.values;
                Self::new(
                    s,
                    present([
                        ("current_right_a", current_right_a.as_ref()),
                        ("current_left_a", current_left_a.as_ref()),
                        ("supply_v", supply_v.as_ref()),
                    ]),
                )
            }),
        }
    }

    fn new<V>(stream: &'a Stream<V>, columns: Vec<(&'static str, CellsView<'a>)>) -> Self {
        Self {
            t_s: &stream.t_s,
            columns,
            unknown: &stream.unknown,
        }
    }
}

type Columns<'a> = Vec<(&'static str, CellsView<'a>)>;

fn present<'a, const N: usize>(columns: [(&'static str, Option<&'a Vec<f64>>); N]) -> Columns<'a> {
    columns
        .into_iter()
        .filter_map(|(name, cells)| Some((name, CellsView::Numbers(cells?))))
        .collect()
}

fn command(command: &Command) -> Columns<'_> {
    let (names, a, b) = match command {
        Command::Torque { right_nm, left_nm } => {
            (["torque_right_nm", "torque_left_nm"], right_nm, left_nm)
        }
        Command::Voltage { right_v, left_v } => {
            (["voltage_right_v", "voltage_left_v"], right_v, left_v)
        }
        Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => (
            ["speed_right_rad_s", "speed_left_rad_s"],
            right_rad_s,
            left_rad_s,
        ),
        Command::Twist { v_m_s, w_rad_s } => (["v_m_s", "w_rad_s"], v_m_s, w_rad_s),
    };
    present([(names[0], Some(a)), (names[1], Some(b))])
}

fn wheels(wheels: &Wheels) -> Columns<'_> {
    match wheels {
        Wheels::Ticks { right, left } => vec![
            ("ticks_right", CellsView::Counts(right)),
            ("ticks_left", CellsView::Counts(left)),
        ],
        Wheels::Angle {
            right_rad,
            left_rad,
        } => present([
            ("angle_right_rad", Some(right_rad)),
            ("angle_left_rad", Some(left_rad)),
        ]),
        Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } => present([
            ("speed_right_rad_s", Some(right_rad_s)),
            ("speed_left_rad_s", Some(left_rad_s)),
        ]),
    }
}
