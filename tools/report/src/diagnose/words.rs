//! Words for effects: what a person calls them, their parameters in units of the robot, what they mean, and
//! what to do about them.

use slipstream_bus::RobotModel;
use slipstream_diagnose::{Finding, ParameterEstimate};

use crate::parts::{digits_of, fixed, short, with_unit};

/// A parameter as a person reads it.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    pub(super) label: &'static str,
    /// What the model has; none where nothing stands for "without it".
    pub(super) was: Option<f64>,
    pub(super) is: f64,
    pub(super) interval: [f64; 2],
    pub(super) unit: &'static str,
    pub(super) digits: usize,
}

/// How a parameter is shown: its label, a factor, the unit, and what it is without the effect.
type Display = (&'static str, f64, &'static str, Option<f64>);

/// What an effect is called.
pub fn name(effect: &str) -> &'static str {
    match effect {
        "wheel_slip" => "Wheel slip",
        "friction_patch" => "Slippery patch",
        "rolling_resistance" => "Rolling resistance",
        "viscous_drag" => "Drag with speed",
        "quadratic_drag" => "Drag with speed squared",
        "caster_drag" => "Caster friction",
        "yaw_scrub" => "Scrub in turns",
        "axle_friction" => "Axle friction",
        "torque_speed_droop" => "Torque falls with speed",
        "actuator_lag" => "Lag of the drive",
        "actuator_delay" => "Delay of the command",
        "motor_gain" => "Strength of the drive",
        "supply_sag" => "Supply sags",
        "command_dead_band" => "Dead band",
        "command_saturation" => "Limit of the drive",
        "command_dead_zone" => "Dead zone",
        "backlash" => "Play in the gears",
        "load_transfer" => "Load transfer",
        "wheel_radius" => "Wheel radii",
        "slip_ratio" => "Slip of the wheels",
        "force_law" => "Force by a law",
        "motion_law" => "Speed by a law",
        "track_width" => "Effective track",
        "payload" => "Payload",
        "floor_slope" => "Slope of the floor",
        "pose_offset" => "Sensor position",
        "pose_latency" => "Clock of the poses",
        "wheels_latency" => "Clock of the wheels",
        "imu_latency" => "Clock of the IMU",
        "encoder_scale" => "Encoder counts",
        "clock_drift" => "Clock rate",
        "link_delay" => "Age of messages",
        "push" => "Push",
        "unexplained" => "Unexplained",
        "sensor noise" => "Noise",
        _ => "Outside of the catalogue",
    }
}

fn display(
    effect: &str,
    parameter: &str,
    unit: &'static str,
    model: Option<&RobotModel>,
) -> Display {
    let radius_mm = model.map(|own| 1000.0 * own.robot.wheel_radius_m);
    let track_cm = model.map(|own| 200.0 * own.robot.half_track_m);
    let none_without = [
        "command_saturation",
        "payload",
        "push",
        "floor_slope",
        "friction_patch",
    ];
    match (effect, parameter) {
        ("wheel_radius", "right_scale") => scaled("right", radius_mm, "mm"),
        ("wheel_radius", "left_scale") => scaled("left", radius_mm, "mm"),
        ("track_width", "scale") => scaled("track", track_cm, "cm"),
        (_, "right_scale" | "right") => ("right", 100.0, "%", Some(1.0)),
        (_, "left_scale" | "left") => ("left", 100.0, "%", Some(1.0)),
        (_, "scale") => ("scale", 100.0, "%", Some(1.0)),
        ("pose_offset", "x_m") => ("forward", 100.0, "cm", Some(0.0)),
        ("pose_offset", "y_m") => ("left", 100.0, "cm", Some(0.0)),
        ("pose_offset", "yaw_rad") => ("turned", degrees(), "°", Some(0.0)),
        (_, "latency_s") => ("late by", 1000.0, "ms", Some(0.0)),
        (_, "delay_s") => ("delay", 1000.0, "ms", Some(0.0)),
        (_, "time_constant_s") => ("time constant", 1000.0, "ms", Some(0.0)),
        ("clock_drift", "rate") => ("gains", 100.0, "%", Some(0.0)),
        (_, "rate_per_s") => ("loses", 100.0, "%/s", Some(0.0)),
        ("rolling_resistance", "coefficient") => ("of the weight", 100.0, "%", Some(0.0)),
        (_, "ratio") => ("loses", 100.0, "%", Some(0.0)),
        (_, "asymmetry") => ("right minus left", 100.0, "%", Some(0.0)),
        (_, "friction_static") => ("at rest", 1.0, "", None),
        (_, "friction_kinetic") => ("sliding", 1.0, "", None),
        ("caster_drag", "friction") => ("friction", 1.0, "", Some(0.0)),
        (_, "friction") => ("friction", 1.0, "", None),
        (_, "grade") => ("grade", 100.0, "%", Some(0.0)),
        (_, "downhill_rad") => ("downhill", degrees(), "°", None),
        (_, "direction_rad") => ("direction", degrees(), "°", None),
        (_, "gap_rad") => ("gap", degrees(), "°", Some(0.0)),
        (_, "com_height_m") => ("height", 100.0, "cm", None),
        ("payload", "x_m") => ("forward", 100.0, "cm", None),
        ("payload", "y_m") => ("left", 100.0, "cm", None),
        (_, "mass_kg") => ("mass", 1.0, "kg", Some(0.0)),
        (_, "x_m") => ("x", 1.0, "m", None),
        (_, "y_m") => ("y", 1.0, "m", None),
        (_, "radius_m") => ("radius", 1.0, "m", None),
        (_, "t_s") => ("at", 1.0, "s", None),
        (_, "impulse_n_s") => ("impulse", 1.0, "N s", Some(0.0)),
        (_, "moment_nm") => ("moment", 1.0, "N m", Some(0.0)),
        (_, "torque_nm") => ("torque", 1.0, "N m", without(effect, &none_without)),
        (_, "speed_rad_s") => ("speed", 1.0, "rad/s", without(effect, &none_without)),
        (_, "voltage_v") => ("voltage", 1.0, "V", without(effect, &none_without)),
        (_, "coefficient") => ("coefficient", 1.0, plain(unit), Some(0.0)),
        _ => ("", 1.0, plain(unit), None),
    }
}

fn degrees() -> f64 {
    1.0_f64.to_degrees()
}

fn plain(unit: &'static str) -> &'static str {
    if unit == "1" { "" } else { unit }
}

fn without(effect: &str, none: &[&str]) -> Option<f64> {
    (!none.contains(&effect)).then_some(0.0)
}

fn scaled(label: &'static str, size: Option<f64>, unit: &'static str) -> Display {
    match size {
        Some(size) => (label, size, unit, Some(1.0)),
        None => (label, 100.0, "%", Some(1.0)),
    }
}

/// Units of the catalogue, as static text.
pub(super) fn unit_of(effect: &str, parameter: &str) -> &'static str {
    let info = slipstream_sim::effects::find(effect);
    let own = info.and_then(|info| info.parameter(parameter));
    own.map_or("1", |own| own.unit)
}

/// How sizes of a parameter in this unit are shown: factor and unit.
pub(super) fn scale_of(
    effect: &str,
    parameter: &str,
    unit: &'static str,
    model: Option<&RobotModel>,
) -> (f64, &'static str) {
    match (parameter, unit) {
        // what the catalogue has no parameter for
        ("both wheels" | "right over left", _) => (100.0, "%"),
        (_, "m/s") => (100.0, "cm/s"),
        _ => {
            let (_, factor, unit, _) = display(effect, parameter, unit, model);
            (factor, unit)
        }
    }
}

/// A parameter as a person reads it; none for words and for what has no estimate.
pub(super) fn shown(
    effect: &str,
    parameter: &ParameterEstimate,
    model: Option<&RobotModel>,
) -> Option<Shown> {
    let unit = unit_of(effect, &parameter.name);
    let (label, factor, unit, nothing) = display(effect, &parameter.name, unit, model);
    let interval = parameter.ci95?.map(|end| factor * end);
    Some(Shown {
        label,
        was: parameter.nominal.or(nothing).map(|was| factor * was),
        is: factor * parameter.estimate?,
        interval,
        unit,
        digits: digits_of(interval),
    })
}

/// Parameters of a finding in words.
struct Told<'a> {
    finding: &'a Finding,
    model: Option<&'a RobotModel>,
}

impl Told<'_> {
    fn get(&self, name: &str) -> Option<Shown> {
        let own = self.finding.parameters.iter().find(|p| p.name == name)?;
        shown(&self.finding.effect, own, self.model)
    }

    /// The size of a parameter with its unit.
    fn text(&self, name: &str) -> String {
        let own = self.get(name);
        own.map_or_else(
            || "an unknown amount".to_owned(),
            |own| with_unit(&fixed(own.is.abs(), own.digits.min(2)), own.unit),
        )
    }

    /// The size of a threshold, whatever it is a threshold of.
    fn size(&self) -> String {
        let own = self.finding.parameters.first();
        own.map_or_else(String::new, |own| self.text(&own.name))
    }

    fn word(&self) -> &str {
        let mut words = self
            .finding
            .parameters
            .iter()
            .filter_map(|p| p.text.as_deref());
        words.next().unwrap_or_default()
    }

    /// How late a clock is: early where that is negative.
    fn late(&self) -> String {
        let is_early = self.get("latency_s").is_some_and(|own| own.is < 0.0);
        let side = if is_early { "early" } else { "late" };
        format!("{} {side}", self.text("latency_s"))
    }
}

/// What a finding says in physics, without a full stop, beginning small.
pub fn headline(finding: &Finding, model: Option<&RobotModel>) -> String {
    let told = Told { finding, model };
    let said = of_force(&told)
        .or_else(|| of_drive(&told))
        .or_else(|| of_sensor(&told));
    said.unwrap_or_else(|| outside(finding))
}

/// What acts between robot and floor.
fn of_force(told: &Told<'_>) -> Option<String> {
    let text = |name: &str| told.text(name);
    Some(match told.finding.effect.as_str() {
        "wheel_slip" => format!("the wheels slip: friction is {}", text("friction_kinetic")),
        "friction_patch" => format!(
            "a patch of the floor at ({}, {}) has a friction of {}",
            text("x_m"),
            text("y_m"),
            text("friction")
        ),
        "rolling_resistance" => format!("rolling costs {} of the weight", text("coefficient")),
        "viscous_drag" => format!("a drag of {} acts on the body", text("coefficient")),
        "quadratic_drag" => format!("a drag of {} times speed squared acts", text("coefficient")),
        "caster_drag" => format!("the caster drags with a friction of {}", text("friction")),
        "yaw_scrub" => format!("turning meets a moment of {}", text("moment_nm")),
        "load_transfer" => format!(
            "acceleration shifts load: the centre of mass is {} high",
            text("com_height_m")
        ),
        "slip_ratio" => format!(
            "the wheels lose {} of their way to the floor",
            text("ratio")
        ),
        "track_width" => track(told.finding),
        "payload" => format!("the robot carries {}", text("mass_kg")),
        "floor_slope" => format!("the floor falls by {}", text("grade")),
        "push" => format!(
            "something pushed the robot with {} at {}",
            text("impulse_n_s"),
            text("t_s")
        ),
        "force_law" | "motion_law" => "a measured law has other values".to_owned(),
        _ => return None,
    })
}

/// What acts between command and wheel.
fn of_drive(told: &Told<'_>) -> Option<String> {
    let text = |name: &str| told.text(name);
    Some(match told.finding.effect.as_str() {
        "axle_friction" => format!("each axle has a friction of {}", text("torque_nm")),
        "torque_speed_droop" => {
            format!("torque falls by {} with wheel speed", text("coefficient"))
        }
        "actuator_lag" => format!(
            "the drive lags with a time constant of {}",
            text("time_constant_s")
        ),
        "actuator_delay" => format!("commands act {} late", text("delay_s")),
        "motor_gain" => format!(
            "the right wheel gets {} and the left {} of what is commanded",
            text("right"),
            text("left")
        ),
        "supply_sag" => format!("the drive loses {}", text("rate_per_s")),
        "command_dead_band" => format!("commands below {} do nothing", told.size()),
        "command_saturation" => format!("commands above {} are cut", told.size()),
        "command_dead_zone" => format!("every command loses {}", told.size()),
        "backlash" => format!("the gears have a play of {}", text("gap_rad")),
        _ => return None,
    })
}

/// What belongs to geometry, sensors, clocks and messages.
fn of_sensor(told: &Told<'_>) -> Option<String> {
    let finding = told.finding;
    Some(match finding.effect.as_str() {
        "wheel_radius" => radii("the wheels are", "wheel", "smaller", "larger", finding),
        "encoder_scale" => radii(
            "the encoders count",
            "encoder",
            "too little",
            "too much",
            finding,
        ),
        "pose_offset" => {
            let yaw = told.get("yaw_rad");
            mounting(
                told.get("x_m").as_ref(),
                told.get("y_m").as_ref(),
                yaw.as_ref(),
            )
        }
        "pose_latency" => format!("the poses are stamped {}", told.late()),
        "wheels_latency" => format!("the wheels are stamped {}", told.late()),
        "imu_latency" => format!("the IMU is stamped {}", told.late()),
        "clock_drift" => {
            let gains = told.get("rate").is_none_or(|own| own.is > 0.0);
            let verb = if gains { "gains" } else { "loses" };
            format!(
                "the clock of the {} {verb} {}",
                stream(told.word()),
                told.text("rate")
            )
        }
        "link_delay" => format!(
            "messages to {} are {} older than stamped",
            finding.robot,
            told.text("delay_s")
        ),
        _ => return None,
    })
}

/// What the catalogue does not hold, by what it acts on and what it follows.
fn outside(finding: &Finding) -> String {
    let shape = finding.shape.as_deref().unwrap_or_default();
    let what = [
        "forward speed",
        "force along the body",
        "moment about the vertical",
    ];
    let what = what
        .into_iter()
        .find(|own| shape.contains(own))
        .unwrap_or("force");
    match finding.driver.as_deref() {
        Some(id) => format!(
            "a {what} that follows {} is missing from the model",
            driver(id).0
        ),
        None => format!("a {what} is missing from the model"),
    }
}

/// What a law depends on: words and unit.
pub(super) fn driver(id: &str) -> (&'static str, &'static str) {
    match id {
        "t" => ("time", "s"),
        "v" => ("speed", "m/s"),
        "w" => ("the turn rate", "rad/s"),
        "wheel_angle" => ("the wheel angle", "rad"),
        "heading" => ("the heading", "rad"),
        "x" => ("x", "m"),
        "y" => ("y", "m"),
        "torque" => ("torque", "N m"),
        "time_at_rest" => ("the time at rest", "s"),
        _ => ("the position", "m"),
    }
}

fn stream(word: &str) -> &str {
    match word {
        "pose" => "poses",
        "imu" => "IMU",
        other => other,
    }
}

/// Two factors of the wheels in words.
fn radii(both: &str, each: &str, less: &str, more: &str, finding: &Finding) -> String {
    let factor = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| Some((own.estimate? / own.nominal.unwrap_or(1.0), own.ci95?)))
    };
    let change = |factor: f64| {
        let side = if factor < 1.0 { less } else { more };
        format!("{}\u{202f}% {side}", short(100.0 * (factor - 1.0).abs()))
    };
    match (factor("right_scale"), factor("left_scale")) {
        (Some((right, own)), Some((left, other))) => {
            let apart = own[0] > left || left > own[1] || other[0] > right || right > other[1];
            if apart {
                format!(
                    "the right {each} is {}, the left {}",
                    change(right),
                    change(left)
                )
                .replace("encoder is", "encoder counts")
            } else {
                format!("{both} {}", change(f64::midpoint(right, left)))
            }
        }
        (Some((one, _)), None) | (None, Some((one, _))) => format!("{both} {}", change(one)),
        _ => format!("{both} other than the model has them"),
    }
}

fn track(finding: &Finding) -> String {
    let own = finding.parameters.first();
    let factor = own.and_then(|own| Some(own.estimate? / own.nominal.unwrap_or(1.0)));
    factor.map_or_else(String::new, |factor| {
        let side = if factor < 1.0 { "narrower" } else { "wider" };
        let change = short(100.0 * (factor - 1.0).abs());
        format!("it turns as if its track were {change}\u{202f}% {side}")
    })
}

fn mounting(x: Option<&Shown>, y: Option<&Shown>, yaw: Option<&Shown>) -> String {
    let part = |own: Option<&Shown>| own.map_or(0.0, |own| own.is - own.was.unwrap_or(0.0));
    let off_cm = part(x).hypot(part(y));
    let is_known = |own: &&Shown| own.interval[0] > 0.0 || own.interval[1] < 0.0;
    let turned = yaw
        .filter(is_known)
        .map(|own| fixed(own.is.abs(), own.digits.min(2)));
    let place = (x.is_some() || y.is_some()).then(|| {
        format!(
            "the pose sensor sits {} cm from where the model has it",
            short(off_cm)
        )
    });
    match (place, turned) {
        (Some(place), Some(turned)) => format!("{place} and is turned by {turned}°"),
        (Some(place), None) => place,
        (None, Some(turned)) => format!("the pose sensor is turned by {turned}°"),
        (None, None) => "the pose sensor sits elsewhere".to_owned(),
    }
}

/// What to do about a finding, as an imperative.
pub fn action(finding: &Finding, model: Option<&RobotModel>) -> String {
    let get = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| own.estimate)
    };
    let digits = |name: &str| {
        let own = finding.parameters.iter().find(|p| p.name == name);
        own.and_then(|own| own.ci95).map_or(3, digits_of)
    };
    let number = |name: &str| {
        let own = get(name).map(|value| format!("{value:.*}", digits(name)));
        own.unwrap_or_default()
    };
    let shift = |what: &str, name: &str| {
        let late_s = get(name).unwrap_or(0.0);
        let side = if late_s > 0.0 { "earlier" } else { "later" };
        format!("Stamp the {what} {:.3} s {side}", late_s.abs())
    };
    match finding.effect.as_str() {
        "pose_offset" => {
            let yaw = get("yaw_rad").map(|_| format!(" rpy=\"0 0 {}\"", number("yaw_rad")));
            format!(
                "Set its joint to xyz=\"{} {} 0\"{}",
                number("x_m"),
                number("y_m"),
                yaw.unwrap_or_default()
            )
        }
        "wheel_radius" => format!(
            "Set right_wheel_radius_\u{200b}multiplier to {}, left to {}",
            number("right_scale"),
            number("left_scale")
        ),
        "track_width" => format!(
            "Set wheel_separation_\u{200b}multiplier to {}",
            number("scale")
        ),
        "encoder_scale" => match model.and_then(|own| own.encoder.as_ref()) {
            Some(encoder) => {
                let counts = |name: &str| {
                    get(name).map_or_else(String::new, |factor| {
                        fixed(f64::from(encoder.counts_per_rev) * factor, 1)
                    })
                };
                format!(
                    "Set the counts per turn to {} (right) and {} (left)",
                    counts("right_scale"),
                    counts("left_scale")
                )
            }
            None => "Correct the counts per turn by these factors".to_owned(),
        },
        "pose_latency" => shift("poses", "latency_s"),
        "wheels_latency" => shift("wheels", "latency_s"),
        "imu_latency" => shift("IMU", "latency_s"),
        "clock_drift" => "Let both computers follow one clock (chrony, PTP)".to_owned(),
        "actuator_delay" => format!(
            "Let the simulator apply commands {} s late",
            number("delay_s")
        ),
        "motor_gain" => "Divide each wheel's command by its factor".to_owned(),
        "command_dead_zone" => "Add this size to each command, with its sign".to_owned(),
        "slip_ratio" => "Count it to the floor: keep the radii".to_owned(),
        "push" => "Leave this moment out (--exclude-time)".to_owned(),
        "unknown" => "Use the law of --improved, or look for what acts there".to_owned(),
        _ => "Put the line below into robot.toml".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_sim::effects::CATALOGUE;

    /// A finding with numbers for every parameter of an effect.
    fn finding(effect: &str) -> Finding {
        let info = slipstream_sim::effects::find(effect).unwrap();
        let numbers = info.parameters.iter().filter(|own| own.unit != "text");
        Finding {
            robot: "r1".to_owned(),
            effect: effect.to_owned(),
            statement: String::new(),
            parameters: numbers
                .map(|own| ParameterEstimate {
                    name: own.name.to_owned(),
                    unit: own.unit.to_owned(),
                    nominal: None,
                    estimate: Some(0.9),
                    ci95: Some([0.88, 0.92]),
                    text: None,
                })
                .collect(),
            place: slipstream_diagnose::Place {
                channel: "longitudinal".to_owned(),
                intervals_s: Vec::new(),
                condition: "always".to_owned(),
            },
            runs: None,
            confused_with: Vec::new(),
            evidence: slipstream_diagnose::Evidence {
                log_likelihood_gain: 10.0,
                p_value: 1e-6,
            },
            shape: None,
            driver: None,
        }
    }

    #[test]
    fn every_effect_of_the_catalogue_has_words() {
        for info in CATALOGUE {
            let own = finding(info.id);
            assert_ne!(name(info.id), "Outside of the catalogue", "{}", info.id);
            let said = headline(&own, None);
            assert!(
                !said.is_empty() && !said.contains("unknown"),
                "{}: {said}",
                info.id
            );
            assert!(!action(&own, None).is_empty());
            if !info.is_table() {
                for parameter in own.parameters.iter().filter(|p| p.unit != "text") {
                    let own = shown(info.id, parameter, None).unwrap();
                    assert!(!own.label.is_empty(), "{}: {}", info.id, parameter.name);
                }
            }
        }
    }

    #[test]
    fn wheels_that_do_not_differ_are_told_together() {
        let own = finding("wheel_radius");
        assert_eq!(headline(&own, None), "the wheels are 10.0\u{202f}% smaller");
        let mut apart = own.clone();
        apart.parameters[0].estimate = Some(1.05);
        apart.parameters[0].ci95 = Some([1.04, 1.06]);
        assert_eq!(
            headline(&apart, None),
            "the right wheel is 5.0\u{202f}% larger, the left 10.0\u{202f}% smaller"
        );
    }
}
