//! Words for effects: what a person calls them, and their parameters in units of the robot.

use slipstream_answer::{Finding, ParameterEstimate};
use slipstream_bus::RobotModel;

use crate::parts::{digits_of, fixed, interval, with_unit};

/// A parameter as a person reads it.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    pub(crate) label: &'static str,
    /// What the model has; none where nothing stands for "without it".
    pub(crate) was: Option<f64>,
    pub(crate) is: f64,
    pub(crate) interval: [f64; 2],
    pub(crate) unit: &'static str,
    pub(crate) digits: usize,
}

impl Shown {
    /// What the model has, with its unit.
    pub(crate) fn was_words(&self) -> Option<String> {
        let was = self.was?;
        Some(with_unit(&fixed(was, self.digits.min(3)), self.unit))
    }

    /// The estimate with its unit.
    pub(crate) fn is_words(&self) -> String {
        with_unit(&fixed(self.is, self.digits), self.unit)
    }

    /// The interval.
    pub(crate) fn interval_words(&self) -> String {
        interval(self.interval[0], self.interval[1], self.digits)
    }
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
pub(crate) fn unit_of(effect: &str, parameter: &str) -> &'static str {
    let info = slipstream_sim::effects::find(effect);
    let own = info.and_then(|info| info.parameter(parameter));
    own.map_or("1", |own| own.unit)
}

/// How sizes of a parameter in this unit are shown: factor and unit.
pub(crate) fn scale_of(
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
pub(crate) fn shown(
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

/// What a law depends on: words and unit.
pub(crate) fn driver(id: &str) -> (&'static str, &'static str) {
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

/// The parameters of a finding that are numbers, as a person reads them.
pub(crate) fn all_shown(finding: &Finding, model: Option<&RobotModel>) -> Vec<Shown> {
    let parameters = finding.parameters.iter();
    let shown = parameters.filter_map(|own| shown(&finding.effect, own, model));
    shown.collect()
}
