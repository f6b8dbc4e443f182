//! Effects of a given size, within the ranges that occur on robots.

use slipstream_bus::{EffectSpec, Parameter};

use super::random::RandomStream;
use slipstream_trial_plant::OutsideEffect;

/// All effects of the vocabulary.
pub const VOCABULARY: [&str; 29] = [
    "wheel_slip",
    "friction_patch",
    "rolling_resistance",
    "viscous_drag",
    "quadratic_drag",
    "caster_drag",
    "yaw_scrub",
    "axle_friction",
    "torque_speed_droop",
    "actuator_lag",
    "actuator_delay",
    "motor_gain",
    "supply_sag",
    "command_dead_band",
    "command_saturation",
    "backlash",
    "load_transfer",
    "wheel_radius",
    "track_width",
    "payload",
    "floor_slope",
    "pose_offset",
    "pose_latency",
    "wheels_latency",
    "imu_latency",
    "encoder_scale",
    "clock_drift",
    "link_delay",
    "push",
];

/// What the draw of an effect depends on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting<'a> {
    /// Commands are speeds.
    pub(crate) speeds: bool,
    /// Length of the recording (s).
    pub(crate) duration_s: f64,
    /// Pose of the centre of mass at every command, without the effect.
    pub(crate) path: &'a [[f64; 3]],
    /// There is an inertial sensor.
    pub(crate) imu: bool,
    /// There is a camera.
    pub(crate) camera: bool,
    /// There are encoders.
    pub(crate) wheels: bool,
}

/// Draws an effect of this size, from the smallest (0) to the largest (1).
pub(crate) fn effect(
    id: &str,
    size: f64,
    setting: &Setting<'_>,
    random: &mut RandomStream,
) -> EffectSpec {
    let within = |from: f64, to: f64| rounded(from * (to / from).powf(size));
    let one = |name: &str, from: f64, to: f64| vec![number(name, within(from, to))];
    let parameters = match id {
        "wheel_slip" => slip(within(0.33, 0.05), random),
        "friction_patch" => patch(within(0.07, 0.25), setting, random),
        "rolling_resistance" => one("coefficient", 8e-4, 0.02),
        "viscous_drag" => one("coefficient", 0.02, 0.8),
        "quadratic_drag" => one("coefficient", 0.04, 1.5),
        "caster_drag" => one("friction", 0.005, 0.15),
        "yaw_scrub" => one("moment_nm", 0.001, 0.025),
        "axle_friction" => one("torque_nm", 4e-4, 0.01),
        "torque_speed_droop" => one("coefficient", 6e-5, 2.5e-3),
        "actuator_lag" => one("time_constant_s", 0.004, 0.08),
        "actuator_delay" => one("delay_s", 0.003, 0.08),
        "motor_gain" => gains(within(0.006, 0.12), random),
        "supply_sag" => one("rate_per_s", 4e-4, 8e-3),
        "command_dead_band" if setting.speeds => one("speed_rad_s", 0.2, 2.0),
        "command_dead_band" => one("torque_nm", 0.004, 0.03),
        "command_saturation" if setting.speeds => one("speed_rad_s", 22.0, 8.0),
        "command_saturation" => one("torque_nm", 0.065, 0.025),
        "backlash" => one("gap_rad", 0.006, 0.08),
        "load_transfer" => one("com_height_m", 0.02, 0.1),
        "wheel_radius" => scales(within(1.5e-3, 0.03), random),
        "track_width" => vec![number(
            "scale",
            rounded(1.0 + random.sign() * within(3e-3, 0.06)),
        )],
        "payload" => payload(within(0.03, 0.5), random),
        "floor_slope" => slope(within(6e-4, 0.015), random),
        "push" => push(within(0.02, 0.4), setting, random),
        "pose_offset" => pose_offset(within(2e-3, 0.06), within(0.004, 0.1), random),
        "pose_latency" => one("latency_s", 0.003, 0.08),
        "wheels_latency" => one("latency_s", 0.002, 0.06),
        "imu_latency" => one("latency_s", 0.004, 0.08),
        "encoder_scale" => scales(within(1.5e-3, 0.03), random),
        "clock_drift" => drift(within(1e-4, 3e-3), setting, random),
        "link_delay" => one("delay_s", 0.02, 0.2),
        _ => Vec::new(),
    };
    EffectSpec {
        effect: id.to_owned(),
        parameters,
    }
}

fn number(name: &str, value: f64) -> (String, Parameter) {
    (name.to_owned(), Parameter::Number(value))
}

/// Rounded to six decimals, so that labels are readable.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Wheel slip with static friction up to 8 % above the kinetic one.
fn slip(kinetic: f64, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    let above = rounded(kinetic * random.uniform(1.0, 1.08));
    vec![
        number("friction_static", above),
        number("friction_kinetic", kinetic),
    ]
}

/// A payload anywhere on the robot.
fn payload(mass_kg: f64, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    vec![
        number("mass_kg", mass_kg),
        number("x_m", rounded(random.uniform(-0.05, 0.08))),
        number("y_m", rounded(random.uniform(-0.06, 0.06))),
    ]
}

/// A slope in any direction.
fn slope(grade: f64, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    vec![
        number("grade", grade),
        number("downhill_rad", rounded(random.uniform(-3.1, 3.1))),
    ]
}

/// A push at any time, in any direction.
fn push(
    impulse_n_s: f64,
    setting: &Setting<'_>,
    random: &mut RandomStream,
) -> Vec<(String, Parameter)> {
    vec![
        number(
            "t_s",
            rounded(random.uniform(3.0, setting.duration_s - 3.0)),
        ),
        number("impulse_n_s", impulse_n_s),
        number("direction_rad", rounded(random.uniform(-3.1, 3.1))),
    ]
}

/// A pose offset in any direction.
fn pose_offset(
    distance_m: f64,
    yaw_rad: f64,
    random: &mut RandomStream,
) -> Vec<(String, Parameter)> {
    let angle = random.uniform(-3.1, 3.1);
    let yaw = random.sign() * yaw_rad;
    vec![
        number("x_m", rounded(distance_m * angle.cos())),
        number("y_m", rounded(distance_m * angle.sin())),
        number("yaw_rad", rounded(yaw)),
    ]
}

/// A friction patch on the path, where the robot moves.
fn patch(
    radius: f64,
    setting: &Setting<'_>,
    random: &mut RandomStream,
) -> Vec<(String, Parameter)> {
    let moves = |k: &usize| {
        let ([x, y, _], [to_x, to_y, _]) = (setting.path[*k], setting.path[*k + 5]);
        (to_x - x).hypot(to_y - y) > 0.02
    };
    let last = setting.path.len().saturating_sub(60);
    let places: Vec<usize> = (50..last).filter(moves).collect();
    let [x, y, _] = places
        .get((random.unit() * places.len() as f64) as usize)
        .map_or([0.0; 3], |k| setting.path[*k]);
    let mut aside = || rounded(random.uniform(-0.3, 0.3) * radius);
    vec![
        number("x_m", rounded(x + aside())),
        number("y_m", rounded(y + aside())),
        number("radius_m", radius),
        number("friction", rounded(random.uniform(0.04, 0.12))),
    ]
}

/// Motor gains that differ on one side or on both.
fn gains(size: f64, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    let (first, second) = (random.sign() * size, random.sign() * size * random.unit());
    let [right, left] =
        *random.choose(&[[first, 0.0], [0.0, first], [first, second], [second, first]]);
    vec![
        number("right", rounded(1.0 + right)),
        number("left", rounded(1.0 + left)),
    ]
}

fn scales(size: f64, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    let (first, second) = (random.sign() * size, random.sign() * size * random.unit());
    let [right, left] = *random.choose(&[[first, second], [second, first], [first, first]]);
    vec![
        number("right_scale", rounded(1.0 + right)),
        number("left_scale", rounded(1.0 + left)),
    ]
}

fn drift(size: f64, setting: &Setting<'_>, random: &mut RandomStream) -> Vec<(String, Parameter)> {
    let mut streams = Vec::new();
    if setting.wheels {
        streams.push("wheels");
    }
    if setting.camera {
        streams.push("pose");
    }
    if setting.imu {
        streams.push("imu");
    }
    let stream = (*random.choose(&streams)).to_owned();
    vec![
        number("rate", rounded(random.sign() * size)),
        ("stream".to_owned(), Parameter::Text(stream)),
    ]
}

/// The effect scaled by `factor`; unchanged if it does not vanish with its parameter.
pub(crate) fn scaled(effect: &EffectSpec, factor: f64) -> EffectSpec {
    let value = |name: &str, number: f64| match (effect.effect.as_str(), name) {
        (
            "wheel_slip" | "friction_patch" | "command_saturation" | "command_dead_band"
            | "load_transfer",
            _,
        ) => number,
        ("push", "t_s" | "direction_rad") | ("floor_slope", "downhill_rad") => number,
        // The size of a payload is its mass.
        ("payload", "x_m" | "y_m") => number,
        ("motor_gain" | "wheel_radius" | "track_width" | "encoder_scale", _) => {
            1.0 + (number - 1.0) * factor
        }
        _ => number * factor,
    };
    let parameters = effect.parameters.iter().map(|(name, parameter)| {
        let parameter = match parameter {
            Parameter::Number(number) => Parameter::Number(fine(value(name, *number))),
            other => other.clone(),
        };
        (name.clone(), parameter)
    });
    EffectSpec {
        effect: effect.effect.clone(),
        parameters: parameters.collect(),
    }
}

/// Rounded to nine decimals.
fn fine(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Number of kinds of effects outside the vocabulary.
pub(crate) const OUTSIDE_KINDS: usize = 8;

/// Draws an effect outside the vocabulary, of this kind and size.
pub(crate) fn outside_effect(
    kind: usize,
    size: f64,
    setting: &Setting<'_>,
    random: &mut RandomStream,
) -> OutsideEffect {
    let within = |from: f64, to: f64| rounded(from * (to / from).powf(size));
    let places = setting.path.iter().map(|[x, ..]| *x);
    let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    match kind % OUTSIDE_KINDS {
        0 => {
            let from = rounded(low + random.uniform(0.3, 0.5) * (high - low));
            let to = rounded(from + random.uniform(0.15, 0.4) * (high - low).max(0.2));
            OutsideEffect::Carpet {
                x_m: [from, to],
                force_n: within(0.15, 0.9),
            }
        }
        1 => OutsideEffect::Cogging {
            torque_nm: within(0.003, 0.03),
            per_turn: *random.choose(&[1.0, 2.0, 3.0, 6.0]),
        },
        2 => {
            let from = rounded(random.uniform(4.0, setting.duration_s - 6.0));
            let to = rounded(from + random.uniform(0.8, 3.0));
            OutsideEffect::Gust {
                force_n: within(0.1, 0.8),
                direction_rad: rounded(random.uniform(-3.1, 3.1)),
                t_s: [from, to],
            }
        }
        3 => OutsideEffect::Tether {
            moment_nm: within(0.003, 0.03),
            heading_rad: rounded(random.uniform(-3.1, 3.1)),
        },
        4 => OutsideEffect::Stribeck {
            force_n: within(0.15, 0.8),
            speed_m_s: rounded(random.uniform(0.1, 0.25)),
        },
        5 => OutsideEffect::Sticking {
            force_n: within(0.6, 2.0),
            time_s: rounded(random.uniform(0.2, 0.6)),
        },
        6 => OutsideEffect::Paddle {
            moment_nm_s2: within(1e-3, 0.01),
        },
        _ => OutsideEffect::Waves {
            force_n: within(0.1, 0.6),
            length_m: rounded(random.uniform(0.2, 0.6)),
        },
    }
}
