//! Derivatives by dual numbers against central differences, for every parameter of every effect,
//! through events too.

use std::collections::BTreeSet;

use crate::support::{STEP_S, mixed};
use num_dual::DualSVec64;
use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_sim::effects::{CATALOGUE, Domain, Info, ParameterInfo};
use slipstream_sim::{
    Command, CommandKind, Robot, Scalar, Stream, lift, lift_entries, read_effects,
};

type Dual = DualSVec64<1>;

/// All quantities that a recording of 1.5 s may contain.
fn observe<S: Scalar>(robot: &Robot<S>, kind: CommandKind, size: f64) -> Vec<S> {
    let mut state = robot.start([0.0, 0.0, 0.3].map(S::constant));
    for k in 0..1500 {
        let t_s = f64::from(k) * STEP_S;
        let [right, left] = mixed(t_s + STEP_S / 2.0, size).map(S::constant);
        let command = match kind {
            CommandKind::Torque => Command::Torque {
                right_nm: right,
                left_nm: left,
            },
            CommandKind::Voltage => Command::Voltage {
                right_v: right,
                left_v: left,
            },
            CommandKind::Speed => Command::Speed {
                right_rad_s: right,
                left_rad_s: left,
            },
        };
        robot.step(&mut state, t_s, STEP_S, &command);
    }
    let second = S::constant(1.5);
    let mut observed = robot.measured_pose(state.pose()).to_vec();
    observed.extend(state.velocity());
    observed.extend(robot.measured_angle(&state));
    observed.extend(state.wheel_angle());
    observed.extend([Stream::Pose, Stream::Wheels, Stream::Imu].map(|s| robot.stamp_s(s, second)));
    observed.push(robot.link_delay_s());
    observed
}

#[derive(Clone, Copy)]
struct Case {
    effect: &'static str,
    parameters: &'static [(&'static str, f64)],
    kind: CommandKind,
    size: f64,
    slips: bool,
}

const fn case(
    effect: &'static str,
    parameters: &'static [(&'static str, f64)],
    kind: CommandKind,
    size: f64,
) -> Case {
    Case {
        effect,
        parameters,
        kind,
        size,
        slips: false,
    }
}

const fn slipping(effect: &'static str, parameters: &'static [(&'static str, f64)]) -> Case {
    Case {
        effect,
        parameters,
        kind: CommandKind::Torque,
        size: 0.08,
        slips: true,
    }
}

const TORQUE: CommandKind = CommandKind::Torque;
const SPEED: CommandKind = CommandKind::Speed;
const VOLTAGE: CommandKind = CommandKind::Voltage;

const CASES: &[Case] = &[
    case(
        "wheel_slip",
        &[("friction_static", 0.222), ("friction_kinetic", 0.22)],
        TORQUE,
        0.08,
    ),
    case(
        "wheel_slip",
        &[("friction_static", 0.26), ("friction_kinetic", 0.21)],
        TORQUE,
        0.081,
    ),
    case(
        "friction_patch",
        &[
            ("x_m", 0.15),
            ("y_m", 0.02),
            ("radius_m", 0.2),
            ("friction", 0.12),
        ],
        TORQUE,
        0.05,
    ),
    case("rolling_resistance", &[("coefficient", 0.01)], TORQUE, 0.05),
    case("viscous_drag", &[("coefficient", 0.4)], TORQUE, 0.05),
    case("quadratic_drag", &[("coefficient", 0.4)], TORQUE, 0.05),
    case("caster_drag", &[("friction", 0.05)], TORQUE, 0.05),
    case("yaw_scrub", &[("moment_nm", 0.01)], TORQUE, 0.05),
    case("actuator_delay", &[("delay_s", 0.0234)], TORQUE, 0.05),
    case("actuator_delay", &[("delay_s", 0.0234)], SPEED, 5.0),
    case("command_dead_band", &[("torque_nm", 0.012)], TORQUE, 0.05),
    case("command_saturation", &[("torque_nm", 0.04)], TORQUE, 0.05),
    case("command_saturation", &[("torque_nm", 0.04)], VOLTAGE, 2.0),
    case("command_saturation", &[("speed_rad_s", 3.0)], SPEED, 5.0),
    case("actuator_lag", &[("time_constant_s", 0.03)], TORQUE, 0.05),
    case("actuator_lag", &[("time_constant_s", 0.03)], SPEED, 5.0),
    case(
        "motor_gain",
        &[("right", 0.95), ("left", 1.04)],
        TORQUE,
        0.05,
    ),
    case("motor_gain", &[("right", 0.95), ("left", 1.04)], SPEED, 5.0),
    case("supply_sag", &[("rate_per_s", 0.01)], VOLTAGE, 2.0),
    case("torque_speed_droop", &[("coefficient", 2e-3)], TORQUE, 0.05),
    case("backlash", &[("gap_rad", 0.03)], TORQUE, 0.05),
    case("axle_friction", &[("torque_nm", 0.006)], TORQUE, 0.05),
    slipping("load_transfer", &[("com_height_m", 0.03)]),
    case(
        "wheel_radius",
        &[("right_scale", 1.01), ("left_scale", 0.99)],
        TORQUE,
        0.05,
    ),
    case(
        "wheel_radius",
        &[("right_scale", 1.01), ("left_scale", 0.99)],
        SPEED,
        5.0,
    ),
    case(
        "slip_ratio",
        &[("ratio", 0.1), ("asymmetry", 0.04)],
        SPEED,
        5.0,
    ),
    case(
        "slip_ratio",
        &[("ratio", 0.1), ("asymmetry", 0.04)],
        VOLTAGE,
        2.0,
    ),
    slipping("slip_ratio", &[("ratio", 0.1), ("asymmetry", 0.04)]),
    case("command_dead_zone", &[("torque_nm", 0.008)], TORQUE, 0.05),
    case("command_dead_zone", &[("voltage_v", 0.4)], VOLTAGE, 2.0),
    case("command_dead_zone", &[("speed_rad_s", 1.0)], SPEED, 5.0),
    case("track_width", &[("scale", 1.1)], SPEED, 5.0),
    slipping("track_width", &[("scale", 1.1)]),
    case(
        "payload",
        &[("mass_kg", 0.2), ("x_m", 0.02), ("y_m", -0.03)],
        TORQUE,
        0.05,
    ),
    slipping(
        "payload",
        &[("mass_kg", 0.2), ("x_m", 0.02), ("y_m", -0.03)],
    ),
    case(
        "floor_slope",
        &[("grade", 0.01), ("downhill_rad", 0.9)],
        TORQUE,
        0.05,
    ),
    case(
        "push",
        &[
            ("t_s", 0.4321),
            ("impulse_n_s", 0.1),
            ("direction_rad", 1.0),
        ],
        TORQUE,
        0.05,
    ),
    case(
        "pose_offset",
        &[("x_m", 0.02), ("y_m", 0.01), ("yaw_rad", 0.03)],
        TORQUE,
        0.05,
    ),
    case("pose_latency", &[("latency_s", 0.04)], TORQUE, 0.05),
    case("wheels_latency", &[("latency_s", 0.04)], TORQUE, 0.05),
    case("imu_latency", &[("latency_s", 0.04)], TORQUE, 0.05),
    case(
        "encoder_scale",
        &[("right_scale", 1.01), ("left_scale", 0.98)],
        TORQUE,
        0.05,
    ),
    case("link_delay", &[("delay_s", 0.04)], TORQUE, 0.05),
    case("clock_drift", &[("rate", 1e-3)], TORQUE, 0.05),
];

/// The cases above, and one of torques at the first probe values for every effect without a case.
fn cases() -> Vec<Case> {
    let known: BTreeSet<&str> = CASES.iter().map(|case| case.effect).collect();
    let new = CATALOGUE
        .iter()
        .filter(|info| !known.contains(info.id) && !info.is_table());
    CASES.iter().copied().chain(new.map(of_probes)).collect()
}

fn of_probes(info: &Info) -> Case {
    let probe = |parameter: &ParameterInfo| match parameter.domain {
        Domain::Number { probes, .. } if !parameter.alternative || parameter.unit == "N m" => {
            Some((parameter.name, probes.first().copied().unwrap_or(0.1)))
        }
        _ => None,
    };
    let parameters: Vec<_> = info.parameters.iter().filter_map(probe).collect();
    case(info.id, Vec::leak(parameters), TORQUE, 0.05)
}

fn model(case: &Case) -> RobotModel {
    let mut model = RobotModel::default();
    if case.slips {
        model = RobotModel::paper_with_slip();
    }
    let mut spec = EffectSpec::new(case.effect, case.parameters);
    if case.effect == "clock_drift" {
        spec.parameters
            .push(("stream".to_owned(), Parameter::Text("pose".to_owned())));
    }
    model.effects.push(spec);
    model
}

/// Largest deviation of the derivatives of all observed quantities from central differences, and
/// the largest derivative.
fn compare(case: &Case, parameter: &str, value: f64) -> (f64, f64) {
    let model = model(case);
    let list = read_effects(&model).unwrap();
    let effect = list.len() - 1;
    let shifted = |shift: f64| {
        let list = lift(&list, |i, name, value| {
            value
                + if i == effect && name == parameter {
                    shift
                } else {
                    0.0
                }
        });
        observe(
            &Robot::assemble(&model, &list).unwrap(),
            case.kind,
            case.size,
        )
    };
    let dual = lift(&list, |i, name, value| {
        let constant = Dual::from_re(value);
        if i == effect && name == parameter {
            constant.derivative(0)
        } else {
            constant
        }
    });
    let dual = observe(
        &Robot::assemble(&model, &dual).unwrap(),
        case.kind,
        case.size,
    );
    let step = 5e-4 * value.abs().max(1e-2);
    let (above, below) = (shifted(step), shifted(-step));
    let mut largest: f64 = 0.0;
    let mut deviation: f64 = 0.0;
    for ((dual, above), below) in dual.iter().zip(above).zip(below) {
        let derivative = dual.eps.0.map_or(0.0, |eps| eps[0]);
        largest = largest.max(derivative.abs());
        deviation = deviation.max((derivative - (above - below) / (2.0 * step)).abs());
    }
    (deviation, largest)
}

/// Relative accuracy of a difference over 5e-4 of the value where events are located to 0.1 µs.
const TOLERANCE: f64 = 5e-3;

#[test]
fn dual_numbers_agree_with_central_differences() {
    let mut wrong = Vec::new();
    for case in &cases() {
        for &(parameter, value) in case.parameters {
            let (deviation, largest) = compare(case, parameter, value);
            let label = format!("{} {parameter} ({:?})", case.effect, case.kind);
            println!("{label}: {deviation:.2e} of {largest:.2e}");
            // no command crosses the dead band's edge: the derivative is zero
            let flat = case.effect == "command_dead_band" && deviation == 0.0;
            if !flat && (largest == 0.0 || deviation > TOLERANCE * largest) {
                wrong.push(format!("{label}: {deviation:e} of {largest:e}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_parameter_is_covered() {
    let covered: BTreeSet<_> = cases()
        .iter()
        .flat_map(|case| case.parameters.iter().map(|&(name, _)| (case.effect, name)))
        .collect();
    for info in CATALOGUE {
        for parameter in info.parameters {
            if matches!(parameter.domain, Domain::Number { .. }) {
                let key = (info.id, parameter.name);
                // the dead band on speeds shares its code with the one on torques
                let twin = key == ("command_dead_band", "speed_rad_s");
                assert!(covered.contains(&key) || twin, "{key:?} has no case");
            }
        }
    }
}

/// A law of `driver` with bends inside the motion.
struct LawCase {
    effect: &'static str,
    acts_on: &'static str,
    driver: &'static str,
    knots: &'static [f64],
    values: &'static [f64],
    kind: CommandKind,
    size: f64,
}

const KNOTS: [&str; 2] = ["knots", "values"];

impl LawCase {
    const fn force(acts_on: &'static str, driver: &'static str, knots: &'static [f64]) -> Self {
        Self {
            effect: "force_law",
            acts_on,
            driver,
            knots,
            values: &[0.05, -0.03, 0.04],
            kind: TORQUE,
            size: 0.05,
        }
    }

    const fn motion(acts_on: &'static str, driver: &'static str, knots: &'static [f64]) -> Self {
        Self {
            effect: "motion_law",
            kind: SPEED,
            size: 5.0,
            ..Self::force(acts_on, driver, knots)
        }
    }

    fn model(&self) -> RobotModel {
        let text = |name: &str, word: &str| (name.to_owned(), Parameter::Text(word.to_owned()));
        let list = |name: &str, list: &[f64]| (name.to_owned(), Parameter::List(list.to_vec()));
        let mut model = RobotModel::default();
        model.effects.push(EffectSpec {
            effect: self.effect.to_owned(),
            parameters: vec![
                text("acts_on", self.acts_on),
                text("driver", self.driver),
                list("knots", self.knots),
                list("values", self.values),
            ],
        });
        model
    }
}

const LAWS: &[LawCase] = &[
    LawCase::force("surge_force", "v", &[-0.05, 0.05, 0.3]),
    LawCase::force("yaw_moment", "w", &[-0.5, 0.3, 1.0]),
    LawCase::force("surge_force", "t", &[0.2, 0.7, 1.3]),
    LawCase::force("surge_force", "x", &[0.02, 0.06, 0.2]),
    LawCase::force("yaw_moment", "heading", &[0.2, 0.4, 1.0]),
    LawCase::motion("speed", "v", &[-0.05, 0.05, 0.3]),
    LawCase::motion("turn_rate", "w", &[-0.5, 0.3, 1.0]),
    LawCase::motion("speed", "t", &[0.2, 0.7, 1.3]),
    LawCase::motion("turn_rate", "x", &[0.02, 0.06, 0.2]),
    LawCase::motion("speed", "y", &[0.0, 0.03, 0.2]),
    LawCase::motion("speed", "heading", &[0.2, 0.4, 1.0]),
];

/// Every entry of a table against a central difference. A bend that a step crosses costs the difference
/// some of its accuracy.
#[test]
fn entries_of_tables_have_derivatives() {
    let mut wrong = Vec::new();
    let mut moving = 0;
    for law in LAWS {
        let model = law.model();
        let list = read_effects(&model).unwrap();
        for (name, at) in KNOTS
            .into_iter()
            .flat_map(|n| (0..3).map(move |at| (n, at)))
        {
            let observed = |shift: f64| {
                let list = lift_entries(&list, |_, other, i, value| {
                    value + if other == name && i == at { shift } else { 0.0 }
                });
                observe(&Robot::assemble(&model, &list).unwrap(), law.kind, law.size)
            };
            let dual = lift_entries(&list, |_, other, i, value| {
                let constant = Dual::from_re(value);
                if other == name && i == at {
                    constant.derivative(0)
                } else {
                    constant
                }
            });
            let dual = observe(&Robot::assemble(&model, &dual).unwrap(), law.kind, law.size);
            let step = 1e-5;
            let (above, below) = (observed(step), observed(-step));
            let mut largest: f64 = 0.0;
            let mut deviation: f64 = 0.0;
            for ((dual, above), below) in dual.iter().zip(above).zip(below) {
                let derivative = dual.eps.0.map_or(0.0, |eps| eps[0]);
                largest = largest.max(derivative.abs());
                deviation = deviation.max((derivative - (above - below) / (2.0 * step)).abs());
            }
            let label = format!(
                "{} {} over {}, {name}[{at}]",
                law.effect, law.acts_on, law.driver
            );
            println!("{label}: {deviation:.2e} of {largest:.2e}");
            moving += usize::from(largest > 1e-6);
            if deviation > 2e-2 * largest + 1e-9 {
                wrong.push(format!("{label}: {deviation:e} of {largest:e}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // Some outer entries are never reached.
    assert!(moving > LAWS.len() * 4, "{moving}");
}
