//! Columns of a recording by the names of the CSV form, in and out.

use slipstream_bus::InputError;
use slipstream_recording::recording::{Command, Imu, Motor, Odometry, Pose, Robot, Stream, Wheels};

/// A column: its name and its values; NaN where a sensor did not see.
pub(crate) type Column = (String, Vec<f64>);
/// A stream: its name and its columns.
pub(crate) type Columns = (String, Vec<Column>);

/// Largest count that a number holds exactly.
const LARGEST_COUNT: f64 = 9.0e15;

/// The columns of one stream while they are taken out by name.
struct TakenColumns<'a> {
    place: String,
    columns: Vec<&'a Column>,
    rows: usize,
}

impl TakenColumns<'_> {
    fn find(&mut self, name: &str) -> Option<Vec<f64>> {
        let place = self.columns.iter().position(|(own, _)| own == name)?;
        Some(self.columns.remove(place).1.clone())
    }

    /// Two columns that belong together; none if neither is there.
    fn pair(&mut self, names: [&str; 2]) -> Result<Option<[Vec<f64>; 2]>, InputError> {
        match names.map(|name| self.find(name)) {
            [Some(one), Some(other)] => Ok(Some([one, other])),
            [None, None] => Ok(None),
            [one, _] => {
                let missing = names[usize::from(one.is_some())];
                Err(self.error(format!("has no column {missing}"), "give both of the pair"))
            }
        }
    }

    fn error(&self, problem: impl Into<String>, remedy: &str) -> InputError {
        InputError::new(&self.place, problem.into(), remedy)
    }
}

/// Adds a stream to a robot.
///
/// # Errors
/// A stream or a column that the format does not know, columns of different lengths, times that run backwards.
pub(crate) fn add(robot: &mut Robot, (name, columns): &Columns) -> Result<(), InputError> {
    let place = format!("{}: {name}", robot.name);
    let times = columns.iter().find(|(own, _)| own == "t_s");
    let Some((_, t_s)) = times else {
        return Err(InputError::new(
            place,
            "has no column t_s",
            "give the times in seconds",
        ));
    };
    let others = columns.iter().filter(|(own, _)| own != "t_s");
    let mut taken = TakenColumns {
        place,
        columns: others.collect(),
        rows: t_s.len(),
    };
    check(&taken, t_s)?;
    let t_s = t_s.clone();
    match name.as_str() {
        "command" => robot.command = Some(stream(t_s, command(&mut taken)?)),
        "wheels" => robot.wheels = Some(stream(t_s, wheels(&mut taken)?)),
        "odometry" => {
            let Some(v_m_s) = taken.find("v_m_s") else {
                return Err(taken.error("has no column v_m_s", "give the speed in m/s"));
            };
            let w_rad_s = taken.find("w_rad_s");
            robot.odometry = Some(stream(t_s, Odometry { v_m_s, w_rad_s }));
        }
        "pose" => {
            let Some([x_m, y_m]) = taken.pair(["x_m", "y_m"])? else {
                return Err(taken.error("has no columns x_m and y_m", "give places in metres"));
            };
            let yaw_rad = taken.find("yaw_rad");
            robot.pose = Some(stream(t_s, Pose { x_m, y_m, yaw_rad }));
        }
        "imu" => {
            let [ax_m_s2, ay_m_s2, gz_rad_s] =
                ["ax_m_s2", "ay_m_s2", "gz_rad_s"].map(|own| taken.find(own));
            robot.imu = Some(stream(
                t_s,
                Imu {
                    ax_m_s2,
                    ay_m_s2,
                    gz_rad_s,
                },
            ));
        }
        "motor" => {
            let [current_right_a, current_left_a, supply_v] =
                ["current_right_a", "current_left_a", "supply_v"].map(|own| taken.find(own));
            robot.motor = Some(stream(
                t_s,
                Motor {
                    current_right_a,
                    current_left_a,
                    supply_v,
                },
            ));
        }
        _ => {
            let remedy = "streams are command, wheels, odometry, pose, imu, motor";
            return Err(taken.error("is not a stream", remedy));
        }
    }
    match taken.columns.first() {
        Some((unknown, _)) => Err(taken.error(
            format!("has no use for column {unknown}"),
            "columns are named as in the CSV form, docs/columns",
        )),
        None => Ok(()),
    }
}

fn stream<V>(t_s: Vec<f64>, values: V) -> Stream<V> {
    Stream {
        t_s,
        values,
        unknown: Vec::new(),
    }
}

fn check(taken: &TakenColumns<'_>, t_s: &[f64]) -> Result<(), InputError> {
    if t_s.is_empty() {
        return Err(taken.error("is empty", "leave it out"));
    }
    for (name, values) in &taken.columns {
        if values.len() != taken.rows {
            let problem = format!(
                "column {name} has {} rows, t_s has {}",
                values.len(),
                taken.rows
            );
            return Err(taken.error(problem, "give columns of one length"));
        }
        if values.iter().any(|value| value.is_infinite()) {
            return Err(taken.error(
                format!("column {name} is infinite"),
                "give NaN where nothing was seen",
            ));
        }
    }
    let backwards = t_s.windows(2).position(|pair| pair[1] < pair[0]);
    if let Some(row) = backwards {
        let problem = format!("time runs backwards at row {}", row + 1);
        return Err(taken.error(problem, "sort the rows by t_s"));
    }
    if t_s.iter().any(|t| !t.is_finite()) {
        return Err(taken.error("has a time that is no number", "leave the row out"));
    }
    Ok(())
}

fn command(taken: &mut TakenColumns<'_>) -> Result<Command, InputError> {
    if let Some([right_nm, left_nm]) = taken.pair(["torque_right_nm", "torque_left_nm"])? {
        return Ok(Command::Torque { right_nm, left_nm });
    }
    if let Some([right_v, left_v]) = taken.pair(["voltage_right_v", "voltage_left_v"])? {
        return Ok(Command::Voltage { right_v, left_v });
    }
    if let Some([right_rad_s, left_rad_s]) =
        taken.pair(["speed_right_rad_s", "speed_left_rad_s"])?
    {
        return Ok(Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        });
    }
    if let Some([v_m_s, w_rad_s]) = taken.pair(["v_m_s", "w_rad_s"])? {
        return Ok(Command::Twist { v_m_s, w_rad_s });
    }
    let remedy =
        "give torque_right_nm and torque_left_nm, voltage_…_v, speed_…_rad_s, or v_m_s and w_rad_s";
    Err(taken.error("has no known pair of columns", remedy))
}

fn wheels(taken: &mut TakenColumns<'_>) -> Result<Wheels, InputError> {
    if let Some(pair) = taken.pair(["ticks_right", "ticks_left"])? {
        let counts = |values: &[f64]| -> Option<Vec<Option<i64>>> {
            values.iter().map(|value| count(*value)).collect()
        };
        let [right, left] = pair.map(|own| counts(&own));
        return match (right, left) {
            (Some(right), Some(left)) => Ok(Wheels::Ticks { right, left }),
            _ => Err(taken.error("has ticks that are not whole", "give angles as angle_…_rad")),
        };
    }
    if let Some([right_rad, left_rad]) = taken.pair(["angle_right_rad", "angle_left_rad"])? {
        return Ok(Wheels::Angle {
            right_rad,
            left_rad,
        });
    }
    if let Some([right_rad_s, left_rad_s]) =
        taken.pair(["speed_right_rad_s", "speed_left_rad_s"])?
    {
        return Ok(Wheels::Speed {
            right_rad_s,
            left_rad_s,
        });
    }
    let remedy = "give ticks_right and ticks_left, angle_…_rad or speed_…_rad_s";
    Err(taken.error("has no known pair of columns", remedy))
}

/// A count; nothing seen is none of the two, a number that is not whole no count at all.
fn count(value: f64) -> Option<Option<i64>> {
    if value.is_nan() {
        return Some(None);
    }
    (value.fract() == 0.0 && value.abs() < LARGEST_COUNT).then_some(Some(value as i64))
}

/// Every stream of a robot as columns.
pub(crate) fn of(robot: &Robot) -> Vec<Columns> {
    let mut all: Vec<Columns> = Vec::new();
    let mut put = |name: &str, t_s: &[f64], columns: Vec<(&str, Vec<f64>)>| {
        let named = columns
            .into_iter()
            .map(|(own, values)| (own.to_owned(), values));
        let columns = std::iter::once(("t_s".to_owned(), t_s.to_vec())).chain(named);
        all.push((name.to_owned(), columns.collect()));
    };
    if let Some(own) = &robot.command {
        put("command", &own.t_s, command_columns(&own.values));
    }
    if let Some(own) = &robot.wheels {
        put("wheels", &own.t_s, wheel_columns(&own.values));
    }
    if let Some(own) = &robot.odometry {
        let mut columns = vec![("v_m_s", own.values.v_m_s.clone())];
        columns.extend(own.values.w_rad_s.clone().map(|values| ("w_rad_s", values)));
        put("odometry", &own.t_s, columns);
    }
    if let Some(own) = &robot.pose {
        let mut columns = vec![
            ("x_m", own.values.x_m.clone()),
            ("y_m", own.values.y_m.clone()),
        ];
        columns.extend(own.values.yaw_rad.clone().map(|values| ("yaw_rad", values)));
        put("pose", &own.t_s, columns);
    }
    if let Some(own) = &robot.imu {
        let values = &own.values;
        let columns = [
            ("ax_m_s2", &values.ax_m_s2),
            ("ay_m_s2", &values.ay_m_s2),
            ("gz_rad_s", &values.gz_rad_s),
        ];
        put("imu", &own.t_s, there(columns));
    }
    if let Some(own) = &robot.motor {
        let values = &own.values;
        let columns = [
            ("current_right_a", &values.current_right_a),
            ("current_left_a", &values.current_left_a),
            ("supply_v", &values.supply_v),
        ];
        put("motor", &own.t_s, there(columns));
    }
    all
}

/// The columns that are there.
fn there<'a>(columns: [(&'a str, &Option<Vec<f64>>); 3]) -> Vec<(&'a str, Vec<f64>)> {
    let own = columns.into_iter();
    own.filter_map(|(name, values)| Some((name, values.clone()?)))
        .collect()
}

fn command_columns(values: &Command) -> Vec<(&'static str, Vec<f64>)> {
    let (names, pair) = match values {
        Command::Torque { right_nm, left_nm } => {
            (["torque_right_nm", "torque_left_nm"], [right_nm, left_nm])
        }
        Command::Voltage { right_v, left_v } => {
            (["voltage_right_v", "voltage_left_v"], [right_v, left_v])
        }
        Command::WheelSpeed {
            right_rad_s,
            left_rad_s,
        } => (
            ["speed_right_rad_s", "speed_left_rad_s"],
            [right_rad_s, left_rad_s],
        ),
        Command::Twist { v_m_s, w_rad_s } => (["v_m_s", "w_rad_s"], [v_m_s, w_rad_s]),
    };
    names.into_iter().zip(pair.map(Clone::clone)).collect()
}

fn wheel_columns(values: &Wheels) -> Vec<(&'static str, Vec<f64>)> {
    let counts = |values: &[Option<i64>]| -> Vec<f64> {
        values
            .iter()
            .map(|own| own.map_or(f64::NAN, |count| count as f64))
            .collect()
    };
    match values {
        Wheels::Ticks { right, left } => {
            vec![("ticks_right", counts(right)), ("ticks_left", counts(left))]
        }
        Wheels::Angle {
            right_rad,
            left_rad,
        } => {
            vec![
                ("angle_right_rad", right_rad.clone()),
                ("angle_left_rad", left_rad.clone()),
            ]
        }
        Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } => {
            vec![
                ("speed_right_rad_s", right_rad_s.clone()),
                ("speed_left_rad_s", left_rad_s.clone()),
            ]
        }
    }
}
