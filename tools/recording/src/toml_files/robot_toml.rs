//! `robot.toml`: the nominal model of a robot, read strictly and written readably.
//!
//! ```
//! use slipstream_recording::robot_toml;
//!
//! let text = "format = 1
//! [robot]
//! wheel_radius_m = 0.0365
//! half_track_m = 0.105
//! [encoder]
//! counts_per_rev = 1856
//! ";
//! let model = robot_toml::parse(text, "robot.toml".as_ref())?;
//! assert_eq!(model.robot.half_track_m, 0.105);
//! assert_eq!(model.robot.body_mass_kg, None); // unknown: a kinematic model
//! assert_eq!(robot_toml::to_text(&model), text);
//!
//! let error = robot_toml::parse("format = 1\n[robo]\n", "robot.toml".as_ref()).unwrap_err();
//! assert_eq!(error.line, Some(2));
//! # Ok::<(), slipstream_recording::Error>(())
//! ```

use std::fmt::Write as _;
use std::path::Path;

use slipstream_bag::output::write_file;
use slipstream_bag::{Result, read_text};
use slipstream_bus::{Body, EffectSpec, Encoder, InputError, Motor, Parameter, RobotModel};
use slipstream_sim::Robot;
use toml::de::DeValue;

use super::document::{Entry, Section, TomlFile, counts_value};
use crate::field::{Field, names};

/// Keys of the root table.
pub const FILE: [Field; 5] = [
    Field::new("format", "", "Version of the format: 1."),
    Field::new("robot", "", "Masses, inertias and lengths."),
    Field::new(
        "motor",
        "",
        "The motor of each wheel. Needed for voltage commands.",
    ),
    Field::new(
        "encoder",
        "",
        "The encoder of each wheel. Needed where wheels are recorded as ticks.",
    ),
    Field::new(
        "effects",
        "",
        "Physics beyond pure rolling. What is not listed, the model leaves out.",
    ),
];
/// Keys of `[robot]`, in the order of writing.
pub const BODY: [Field; 10] = [
    Field::new("body_mass_kg", "kg", "Mass of the body, without its wheels.").symbol("m_r"),
    Field::new("body_yaw_inertia_kg_m2", "kg m²", "Yaw inertia of the body about its centre of mass.").symbol("I_rz"),
    Field::new("wheel_mass_kg", "kg", "Mass of one wheel, on the axle.").symbol("m_w"),
    Field::new("wheel_spin_inertia_kg_m2", "kg m²", "Inertia of one wheel about the axle.").symbol("I_wy"),
    Field::new("wheel_yaw_inertia_kg_m2", "kg m²", "Inertia of one wheel about its vertical.").symbol("I_wz"),
    Field::new("wheel_radius_m", "m", "Rolling radius of each driven wheel. Required.").symbol("r"),
    Field::new("half_track_m", "m", "Half of the distance between the driven wheels. Required.").symbol("b"),
    Field::new("com_to_axle_m", "m", "Distance from the centre of mass back to the axle. Without it, pose.csv tracks the middle of the axle.").symbol("d"),
    Field::new("com_to_caster_m", "m", "Distance from the centre of mass forward to the contact of the caster.").symbol("e"),
    Field::new("com_height_m", "m", "Height of the centre of mass above the floor.").symbol("h"),
];
/// Keys of `[motor]`, in the order of writing.
pub const MOTOR: [Field; 3] = [
    Field::new("nominal_voltage_v", "V", "Nominal voltage.").symbol("V_nominal"),
    Field::new(
        "no_load_speed_rad_s",
        "rad/s",
        "Speed of the wheel without load at the nominal voltage.",
    )
    .symbol("ω_0"),
    Field::new(
        "stall_torque_nm",
        "N m",
        "Torque at the wheel that stands, at the nominal voltage.",
    )
    .symbol("τ_stall"),
];
/// Keys of `[encoder]`.
pub const ENCODER: [Field; 1] = [Field::new(
    "counts_per_rev",
    "counts",
    "Counts in one revolution of the wheel; gears make it a fraction.",
)];

const TOP_KEYS: [&str; 5] = names(&FILE);
const BODY_KEYS: [&str; 10] = names(&BODY);
const MOTOR_KEYS: [&str; 3] = names(&MOTOR);
const ENCODER_KEYS: [&str; 1] = names(&ENCODER);

/// Reads a model from a file.
///
/// # Errors
/// If the file cannot be read or is not TOML, if a key is unknown or missing, or if a value has the
/// wrong type or is physically impossible. It is the check of the simulator, so that whoever reads a
/// model refuses what a run refuses.
pub fn read(path: &Path) -> Result<RobotModel> {
    Ok(parse(&read_text(path)?, path)?)
}

/// Parses the text of a model. `path` is used in errors only.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str, path: &Path) -> std::result::Result<RobotModel, InputError> {
    let file = TomlFile { path, text };
    let table = file.parse()?;
    let root = file.root(&table);
    root.require_format_1()?;
    root.allow_only(&TOP_KEYS)?;
    let body = root.require("robot")?.section()?;
    let model = RobotModel {
        robot: parse_body(&body)?,
        motor: root
            .section("motor")?
            .map(|s| parse_motor(&s))
            .transpose()?,
        encoder: root
            .section("encoder")?
            .map(|s| parse_encoder(&s))
            .transpose()?,
        effects: match root.get("effects") {
            Some(entry) => parse_effects(&entry)?,
            None => Vec::new(),
        },
    };
    // The check that a run makes, too.
    Robot::new(&model).map_err(|error| root.error_below(&error))?;
    Ok(model)
}

fn parse_body(section: &Section<'_>) -> std::result::Result<Body, InputError> {
    section.allow_only(&BODY_KEYS)?;
    Ok(Body {
        body_mass_kg: section.number("body_mass_kg")?,
        body_yaw_inertia_kg_m2: section.number("body_yaw_inertia_kg_m2")?,
        wheel_mass_kg: section.number("wheel_mass_kg")?,
        wheel_spin_inertia_kg_m2: section.number("wheel_spin_inertia_kg_m2")?,
        wheel_yaw_inertia_kg_m2: section.number("wheel_yaw_inertia_kg_m2")?,
        wheel_radius_m: section.require("wheel_radius_m")?.number()?,
        half_track_m: section.require("half_track_m")?.number()?,
        com_to_axle_m: section.number("com_to_axle_m")?,
        com_to_caster_m: section.number("com_to_caster_m")?,
        com_height_m: section.number("com_height_m")?,
    })
}

fn parse_motor(section: &Section<'_>) -> std::result::Result<Motor, InputError> {
    section.allow_only(&MOTOR_KEYS)?;
    Ok(Motor {
        nominal_voltage_v: section.require("nominal_voltage_v")?.number()?,
        no_load_speed_rad_s: section.require("no_load_speed_rad_s")?.number()?,
        stall_torque_nm: section.require("stall_torque_nm")?.number()?,
    })
}

fn parse_encoder(section: &Section<'_>) -> std::result::Result<Encoder, InputError> {
    section.allow_only(&ENCODER_KEYS)?;
    Ok(Encoder {
        counts_per_rev: section.require("counts_per_rev")?.counts_per_rev()?,
    })
}

/// Parses effects: `id = {…}`, or `id = [{…}, {…}]` for an effect that occurs several times.
fn parse_effects(effects: &Entry<'_>) -> std::result::Result<Vec<EffectSpec>, InputError> {
    if effects.value.is_array() {
        let remedy = "write a table for each effect, such as [effects.wheel_slip]";
        return Err(effects.error("is an array", remedy));
    }
    let section = effects.section()?;
    let mut effects = Vec::new();
    for (id, entry) in section.entries() {
        for occurrence in entry.elements() {
            effects.push(EffectSpec {
                effect: id.to_owned(),
                parameters: occurrence
                    .section()?
                    .entries()
                    .map(|(name, value)| Ok((name.to_owned(), parse_parameter(&value)?)))
                    .collect::<std::result::Result<_, InputError>>()?,
            });
        }
    }
    Ok(effects)
}

fn parse_parameter(entry: &Entry<'_>) -> std::result::Result<Parameter, InputError> {
    match entry.value {
        DeValue::String(text) => Ok(Parameter::Text(text.to_string())),
        DeValue::Integer(_) | DeValue::Float(_) => Ok(Parameter::Number(entry.number()?)),
        DeValue::Array(_) => {
            let numbers = entry.elements().into_iter().map(|number| number.number());
            Ok(Parameter::List(
                numbers.collect::<std::result::Result<_, _>>()?,
            ))
        }
        _ => Err(entry.wrong_type("a number, a string or a list of numbers")),
    }
}

/// Writes a model to a file, replacing an existing one.
///
/// # Errors
/// If the file cannot be written.
pub fn write(model: &RobotModel, path: &Path) -> Result<()> {
    write_file(path, to_text(model).as_bytes())
}

/// The model as the text of a `robot.toml`. Parsing it gives the same model bit for bit.
pub fn to_text(model: &RobotModel) -> String {
    let mut text = String::from("format = 1\n[robot]\n");
    write_body(&mut text, &model.robot);
    if let Some(motor) = &model.motor {
        text.push_str("[motor]\n");
        for (key, value) in MOTOR_KEYS.into_iter().zip(motor_values(motor)) {
            write_line(&mut text, key, &number(value));
        }
    }
    if let Some(encoder) = &model.encoder {
        text.push_str("[encoder]\n");
        write_line(
            &mut text,
            "counts_per_rev",
            &counts_value(encoder.counts_per_rev).to_string(),
        );
    }
    if !model.effects.is_empty() {
        text.push_str("[effects]\n");
        write_effects(&mut text, &model.effects);
    }
    text
}

/// Writes the known keys of `[robot]`.
fn write_body(text: &mut String, body: &Body) {
    for (key, value) in BODY_KEYS.into_iter().zip(body_values(body)) {
        if let Some(value) = value {
            write_line(text, key, &number(value));
        }
    }
}

/// The values of `[robot]`, in the order of [`BODY_KEYS`].
fn body_values(body: &Body) -> [Option<f64>; 10] {
    let Body {
        body_mass_kg,
        body_yaw_inertia_kg_m2,
        wheel_mass_kg,
        wheel_spin_inertia_kg_m2,
        wheel_yaw_inertia_kg_m2,
        wheel_radius_m,
        half_track_m,
        com_to_axle_m,
        com_to_caster_m,
        com_height_m,
    } = *body;
    [
        body_mass_kg,
        body_yaw_inertia_kg_m2,
        wheel_mass_kg,
        wheel_spin_inertia_kg_m2,
        wheel_yaw_inertia_kg_m2,
        Some(wheel_radius_m),
        Some(half_track_m),
        com_to_axle_m,
        com_to_caster_m,
        com_height_m,
    ]
}

/// The value of a key of `[robot]` that a model may leave out.
pub(crate) fn body_value_mut<'a>(body: &'a mut Body, key: &str) -> Option<&'a mut Option<f64>> {
    Some(match key {
        "body_mass_kg" => &mut body.body_mass_kg,
        "body_yaw_inertia_kg_m2" => &mut body.body_yaw_inertia_kg_m2,
        "wheel_mass_kg" => &mut body.wheel_mass_kg,
        "wheel_spin_inertia_kg_m2" => &mut body.wheel_spin_inertia_kg_m2,
        "wheel_yaw_inertia_kg_m2" => &mut body.wheel_yaw_inertia_kg_m2,
        "com_to_axle_m" => &mut body.com_to_axle_m,
        "com_to_caster_m" => &mut body.com_to_caster_m,
        "com_height_m" => &mut body.com_height_m,
        _ => return None,
    })
}

/// All numbers of a model, in the order of writing: those of `[robot]` by their key, others with the name of
/// their table.
pub(crate) fn numbers(model: &RobotModel) -> Vec<(String, f64)> {
    let body = BODY_KEYS.into_iter().zip(body_values(&model.robot));
    let known = body.filter_map(|(key, value)| Some((key.to_owned(), value?)));
    let mut numbers: Vec<(String, f64)> = known.collect();
    if let Some(motor) = &model.motor {
        let values = motor_values(motor).into_iter().zip(MOTOR_KEYS);
        numbers.extend(values.map(|(value, key)| (format!("motor.{key}"), value)));
    }
    if let Some(encoder) = &model.encoder {
        let counts = encoder.counts_per_rev;
        numbers.push(("encoder.counts_per_rev".to_owned(), counts));
    }
    for effect in &model.effects {
        for (name, value) in &effect.parameters {
            if let Parameter::Number(value) = value {
                numbers.push((format!("effects.{}.{name}", effect.effect), *value));
            }
        }
    }
    numbers
}

/// The values of `[motor]`, in the order of [`MOTOR_KEYS`].
fn motor_values(motor: &Motor) -> [f64; 3] {
    [
        motor.nominal_voltage_v,
        motor.no_load_speed_rad_s,
        motor.stall_torque_nm,
    ]
}

/// Writes effects in the order of their first occurrence; an effect that occurs several times becomes
/// one array.
fn write_effects(text: &mut String, effects: &[EffectSpec]) {
    for (i, effect) in effects.iter().enumerate() {
        let same = |other: &&EffectSpec| other.effect == effect.effect;
        if effects.iter().take(i).any(|other| same(&other)) {
            continue;
        }
        let tables: Vec<String> = effects.iter().filter(same).map(inline_table).collect();
        let value = match tables.as_slice() {
            [one] => one.clone(),
            many => format!("[{}]", many.join(", ")),
        };
        write_line(text, &toml_key(&effect.effect), &value);
    }
}

fn inline_table(effect: &EffectSpec) -> String {
    if effect.parameters.is_empty() {
        return String::from("{}");
    }
    let parameters: Vec<String> = effect
        .parameters
        .iter()
        .map(|(name, value)| match value {
            Parameter::Number(value) => format!("{} = {}", toml_key(name), number(*value)),
            Parameter::Text(value) => {
                format!(
                    "{} = {}",
                    toml_key(name),
                    toml::Value::String(value.clone())
                )
            }
            Parameter::List(values) => {
                let values: Vec<String> = values.iter().copied().map(number).collect();
                format!("{} = [{}]", toml_key(name), values.join(", "))
            }
        })
        .collect();
    format!("{{ {} }}", parameters.join(", "))
}

fn write_line(text: &mut String, key: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{key} = {value}");
}

/// The shortest text that parses to the same number.
pub(crate) fn number(value: f64) -> String {
    toml::Value::Float(value).to_string()
}

/// The key, quoted where TOML requires it.
fn toml_key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if !name.is_empty() && name.chars().all(bare) {
        name.to_owned()
    } else {
        toml::Value::String(name.to_owned()).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> std::result::Result<RobotModel, String> {
        parse(text, Path::new("robot.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn the_papers_robot_round_trips() {
        let push = |t_s, impulse_n_s| {
            [
                ("t_s", t_s),
                ("impulse_n_s", impulse_n_s),
                ("direction_rad", 1.0),
            ]
        };
        let model = RobotModel::paper_with_slip()
            .with("push", &push(3.0, 0.1))
            .with("push", &push(4.0, 0.1 + 0.2));
        assert_eq!(parse_text(&to_text(&model)), Ok(model));
    }

    #[test]
    fn an_effect_can_have_a_text_parameter() {
        let text = "format = 1\n[robot]\nwheel_radius_m = 1\nhalf_track_m = 2\n\
                    [effects]\nclock_drift = { rate = 1e-5, stream = \"pose\" }\n";
        let model = parse_text(text).unwrap();
        assert_eq!(
            model.effects[0].parameters[1].1,
            Parameter::Text("pose".into())
        );
        assert_eq!(parse_text(&to_text(&model)), Ok(model));
    }

    #[test]
    fn an_effect_can_have_lists_of_numbers_and_occur_twice() {
        let text = "format = 1\n[robot]\nwheel_radius_m = 1\nhalf_track_m = 2\n\
                    [effects]\nmotion_law = [{ acts_on = \"speed\", driver = \"v\", knots = [0, 0.5], \
                    values = [-1e-3, 0.1] }, { acts_on = \"turn_rate\", driver = \"w\", knots = [0], \
                    values = [0.25] }]\n";
        let model = parse_text(text).unwrap();
        assert_eq!(model.effects.len(), 2);
        assert_eq!(
            model.effects[0].parameters[3].1,
            Parameter::List(vec![-1e-3, 0.1])
        );
        assert_eq!(parse_text(&to_text(&model)), Ok(model));
        let wrong = text.replace("[0, 0.5]", "[0, \"a\"]");
        assert_eq!(
            parse_text(&wrong).unwrap_err(),
            "robot.toml:6: effects.motion_law[0].knots[1] is a string; give a number"
        );
    }

    #[test]
    fn errors_name_line_key_and_remedy() {
        let ok = "format = 1\n[robot]\nwheel_radius_m = 0.1\nhalf_track_m = 0.2\n";
        let cases = [
            ("", "robot.toml:1: format is missing; "),
            ("format = 2\n", "robot.toml:1: format is 2; "),
            ("format = 1\n[robo]\n", "robot.toml:2: robo is not a key"),
            (
                "format = 1\n[robot]\nwheel_radius_m = 1\n",
                "robot.toml:2: robot.half_track_m is missing",
            ),
            (
                "format = 1\n[robot]\nwheel_radius_m = -1\nhalf_track_m = 1\n",
                "robot.toml:3: robot.wheel_radius_m is -1; give a number from 0.0001 to 1000",
            ),
            (
                &format!("{ok}[effects]\nwheel_radius = {{ right_scale = 1, left_scale = 9 }}\n"),
                "robot.toml:6: effects.wheel_radius.left_scale is 9; give a number from 0.4 to 2.5",
            ),
            (
                &format!("{ok}[effects]\npush = {{ t_s = \"x\" }}\n"),
                "robot.toml:6: effects.push.t_s is \"x\"; give a number",
            ),
            (
                &format!("{ok}[effects]\nice = {{}}\n"),
                "robot.toml:6: effects.ice is not a known effect; `slipstream effects` lists",
            ),
            (
                &format!("{ok}[[effects]]\nname = \"wheel_slip\"\n"),
                "robot.toml:5: effects is an array; write a table for each effect, such as \
                 [effects.wheel_slip]",
            ),
            (
                "format = 1\n[robot]\nwheel_radius_m = nan\nhalf_track_m = 1\n",
                "robot.toml:3: robot.wheel_radius_m is not finite",
            ),
            (
                "format = 1\n[robot]\nwheel_radius_m = \"1\"\n",
                "robot.toml:3: robot.wheel_radius_m is a string; give a number",
            ),
            (
                &format!("{ok}wheel_raduis_m = 1\n"),
                "robot.toml:5: robot.wheel_raduis_m is not a key of this table; remove it or write",
            ),
            (
                &format!("{ok}[encoder]\ncounts_per_rev = 0\n"),
                "robot.toml:6: encoder.counts_per_rev is not a valid number of counts",
            ),
            (
                &format!("{ok}[effects]\nwheel_slip = 3\n"),
                "robot.toml:6: effects.wheel_slip is an integer; give a table",
            ),
            (
                &format!("{ok}[effects]\npush = [{{ t_s = inf }}]\n"),
                "robot.toml:6: effects.push[0].t_s is not finite",
            ),
            ("format = 1\n[robot\n", "robot.toml:2: "),
        ];
        for (text, message) in cases {
            let error = parse_text(text).unwrap_err();
            assert!(error.starts_with(message), "{error}\n wanted {message}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
