//! What the diagnosis says of recordings whose truth is known.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

use slipstream_answer::{Answer, Verdict};
use slipstream_bus::{Body, RobotModel};
use slipstream_diagnose::{Request, diagnose};
use slipstream_recording::Recording;
use slipstream_recording::recording::{Command, Pose, Robot, Stream};
use slipstream_sim::effects::CATALOGUE;

fn answer(truth: &RobotModel, nominal: &RobotModel, seed: u64) -> (Answer, RobotModel) {
    let (answer, mut improved) = diagnose(&Request {
        recordings: &[slipstream_testkit::record(
            truth,
            slipstream_testkit::gentle,
            12.0,
            seed,
        )],
        against: &[],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    })
    .unwrap();
    (answer, improved.remove(0).1)
}

#[test]
fn a_model_that_is_right_matches() {
    let model = RobotModel::default();
    let (answer, _) = answer(&model, &model, 1);
    assert_eq!(
        answer.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&answer).unwrap()
    );
}

#[test]
fn what_is_left_out_is_named_and_measured_and_then_matches() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("rolling_resistance", &[("coefficient", 0.008)]);
    let (first, improved) = answer(&truth, &nominal, 2);
    let text = serde_json::to_string(&first).unwrap();
    assert_eq!(first.verdict, Verdict::Explained, "{text}");
    let found: Vec<&str> = first.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, ["rolling_resistance"], "{text}");
    let estimate = first.findings[0].parameters[0].estimate.unwrap();
    assert!((estimate - 0.008).abs() < 0.05 * 0.008, "{text}");
    assert!(
        first.held_out.nrmse_after < 0.5 * first.held_out.nrmse_before,
        "{text}"
    );
    let (again, _) = answer(&truth, &improved, 2);
    assert_eq!(
        again.verdict,
        Verdict::Match,
        "{}",
        serde_json::to_string(&again).unwrap()
    );
}

#[test]
fn what_swallows_little_is_found_beside_what_is_late() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("actuator_lag", &[("time_constant_s", 0.04)])
        .with("command_dead_band", &[("torque_nm", 0.004)]);
    let (answer, _) = answer(&truth, &nominal, 4);
    let text = serde_json::to_string(&answer).unwrap();
    let mut found: Vec<(&str, f64)> = answer
        .findings
        .iter()
        .map(|f| (f.effect.as_str(), f.parameters[0].estimate.unwrap()))
        .collect();
    found.sort_by(|a, b| a.0.cmp(b.0));
    let [("actuator_lag", lag_s), ("command_dead_band", band_nm)] = found[..] else {
        panic!("{text}")
    };
    // between which two commands the band ends is known, not where
    assert!((lag_s - 0.04).abs() < 2e-3, "{text}");
    assert!((band_nm - 0.004).abs() < 2e-4, "{text}");
}

#[test]
fn a_slope_that_leads_far_astray_is_found() {
    let nominal = RobotModel::default();
    let slope = [("grade", 0.02), ("downhill_rad", -1.1)];
    let truth = nominal.clone().with("floor_slope", &slope);
    let (answer, _) = answer(&truth, &nominal, 5);
    let text = serde_json::to_string(&answer).unwrap();
    assert_eq!(answer.findings.len(), 1, "{text}");
    for (found, (name, value)) in answer.findings[0].parameters.iter().zip(slope) {
        assert_eq!(found.name, name, "{text}");
        let estimate = found.estimate.unwrap();
        assert!((estimate - value).abs() < 0.02 * value.abs(), "{text}");
    }
}

fn listing(answer: &Answer) -> String {
    serde_json::to_string(answer).unwrap()
}

#[test]
fn what_is_found_brings_predictions_to_the_noise() {
    let nominal = RobotModel::default();
    let truth = nominal
        .clone()
        .with("rolling_resistance", &[("coefficient", 0.008)]);
    let (found, _) = answer(&truth, &nominal, 5);
    let (right, _) = answer(&truth, &truth, 5);
    let (before, after) = (found.held_out.nrmse_before, found.held_out.nrmse_after);
    let best = right.held_out.nrmse_before;
    assert!(before > 10.0, "{}", listing(&found));
    // 1 is the noise of the sensors; starts fitted to half a second leave a little beside it, under
    // the true model as well
    assert!((0.9..2.0).contains(&best), "{}", listing(&right));
    assert!((after / best - 1.0).abs() < 0.05, "{}", listing(&found));
}

#[test]
fn an_effect_that_the_model_has_is_not_found_again_but_with_other_numbers() {
    let resisted = |coefficient| {
        RobotModel::default().with("rolling_resistance", &[("coefficient", coefficient)])
    };
    let truth = resisted(0.008);
    let (right, _) = answer(&truth, &truth, 3);
    assert_eq!(right.verdict, Verdict::Match, "{}", listing(&right));
    let (wrong, improved) = answer(&truth, &resisted(0.004), 3);
    let text = listing(&wrong);
    assert_eq!(wrong.findings.len(), 1, "{text}");
    let own = &wrong.findings[0].parameters[0];
    assert_eq!(own.nominal, Some(0.004), "{text}");
    let [low, high] = own.ci95.unwrap();
    assert!(low < 0.00805 && high > 0.00795 && low > 0.007, "{text}");
    // in place of the old numbers, not beside them
    assert_eq!(improved.effects.len(), 1);
}

#[test]
fn a_push_is_not_seen_where_the_rest_is_left_out() {
    let nominal = RobotModel::default();
    let push = [("t_s", 9.0), ("impulse_n_s", 0.2), ("direction_rad", 1.0)];
    let recording = slipstream_testkit::record(
        &nominal.clone().with("push", &push),
        slipstream_testkit::gentle,
        12.0,
        4,
    );
    let others = CATALOGUE.iter().filter(|info| info.id != "push");
    let others: Vec<String> = others.map(|info| info.id.to_owned()).collect();
    let without = |excluded_s: &[[f64; 2]]| {
        let request = Request {
            recordings: std::slice::from_ref(&recording),
            against: &[],
            model_of: &|_| Some(nominal.clone()),
            excluded: &others,
            excluded_s,
            progress: &|_| (),
        };
        diagnose(&request).unwrap().0
    };
    let all = without(&[]);
    let found: Vec<&str> = all.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, ["push"], "{}", listing(&all));
    // alone, with what comes after it, and with all that came before
    for (excluded_s, verdict) in [
        ([8.9, 9.3], Verdict::Match),
        ([8.9, 12.0], Verdict::Match),
        // one window is left: nothing to test on
        ([0.0, 9.2], Verdict::Unexplained),
    ] {
        let hidden = without(&[excluded_s]);
        assert!(hidden.findings.is_empty(), "{}", listing(&hidden));
        assert_eq!(hidden.verdict, verdict, "{}", listing(&hidden));
    }
}

fn answered(recording: &Recording, nominal: &RobotModel) -> Answer {
    let request = Request {
        recordings: std::slice::from_ref(recording),
        against: &[],
        model_of: &|_| Some(nominal.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    };
    diagnose(&request).unwrap().0
}

/// `record`ed under torques of which the recording tells only the `gentle` part.
fn disturbed(torque: fn(f64) -> [f64; 2]) -> Answer {
    disturbed_beside(&RobotModel::default(), torque)
}

/// The same of a robot whose model is not the nominal one.
fn disturbed_beside(truth: &RobotModel, torque: fn(f64) -> [f64; 2]) -> Answer {
    let nominal = RobotModel::default();
    let mut recording = slipstream_testkit::record(truth, torque, 20.0, 11);
    let command = recording.robots[0].command.as_mut().unwrap();
    let told = command
        .t_s
        .iter()
        .map(|t_s| slipstream_testkit::gentle(t_s + 1e-6));
    let (right_nm, left_nm) = told.map(|[right, left]| (right, left)).unzip();
    command.values = Command::Torque { right_nm, left_nm };
    answered(&recording, &nominal)
}

/// Torques without pattern, a three hundredth of the driving ones.
fn wandering(t_s: f64) -> [f64; 2] {
    let waves = |first: f64| -> f64 {
        let wave = |k: i32| (first + f64::from(k * k) + t_s * (0.9 + 1.3 * f64::from(k))).sin();
        (0..9).map(wave).sum()
    };
    let [right, left] = slipstream_testkit::gentle(t_s);
    [right + 6e-5 * waves(0.3), left + 6e-5 * waves(2.1)]
}

fn gust(t_s: f64) -> [f64; 2] {
    let [right, left] = slipstream_testkit::gentle(t_s);
    let blows = (8.0..9.2).contains(&t_s);
    let more = if blows { 0.002 } else { 0.0 };
    [right + more, left + more]
}

#[test]
fn forces_without_pattern_are_no_finding() {
    let answer = disturbed(wandering);
    assert_eq!(answer.verdict, Verdict::Match, "{}", listing(&answer));
    let ids: Vec<&str> = answer.warnings.iter().map(|w| w.id.as_str()).collect();
    assert_eq!(ids, ["wandering_forces"]);
}

#[test]
fn an_effect_stands_out_of_forces_without_pattern() {
    let truth = RobotModel::default().with("viscous_drag", &[("coefficient", 0.3)]);
    let answer = disturbed_beside(&truth, wandering);
    let found: Vec<&str> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
    assert_eq!(found, ["viscous_drag"], "{}", listing(&answer));
    let [low, high] = answer.findings[0].parameters[0].ci95.unwrap();
    assert!((low..=high).contains(&0.3), "{}", listing(&answer));
    assert!(!answer.process_noise.is_empty(), "{}", listing(&answer));
}

#[test]
fn a_force_that_comes_and_goes_is_unknown_and_located() {
    let answer = disturbed(gust);
    assert_eq!(answer.verdict, Verdict::Unexplained, "{}", listing(&answer));
    let [left] = answer.unexplained.as_slice() else {
        panic!("{}", listing(&answer))
    };
    assert_eq!(left.driver, "t");
    for [from, to] in &left.intervals_s {
        assert!(*from > 7.5 && *to < 9.7, "{:?}", left.intervals_s);
    }
}

/// A robot that is told speeds and loses half of the forward one for each rad/s that it is told to turn by,
/// seen by a camera of which no noise is declared.
fn slow_in_arcs() -> Recording {
    let step_s = 1e-3;
    let [mut x, mut y, mut yaw] = [0.0, 0.0, 0.3_f64];
    let (mut told, mut seen) = ([vec![], vec![], vec![]], [vec![], vec![], vec![], vec![]]);
    // between -1 and 1, without a pattern that a robot could follow
    let noise = |seed: f64| 2.0 * ((seed * 12.9898).sin() * 43758.5453).rem_euclid(1.0) - 1.0;
    for k in 0..30_000_u32 {
        let t_s = f64::from(k) * step_s;
        let held_s = (t_s / 0.1).floor() * 0.1;
        let v = 0.3 + 0.1 * (0.31 * held_s).sin();
        let w = 0.5 * (0.7 * held_s).sin() + 0.4 * (1.9 * held_s + 1.0).sin();
        if k % 100 == 0 {
            [t_s, v, w]
                .iter()
                .zip(&mut told)
                .for_each(|(value, column)| column.push(*value));
        }
        if k % 20 == 0 {
            let [along, across, turn] = [0.0, 0.3, 0.7].map(|part| noise(f64::from(k) + part));
            let row = [t_s, x + 1e-3 * along, y + 1e-3 * across, yaw + 2e-3 * turn];
            row.iter()
                .zip(&mut seen)
                .for_each(|(value, column)| column.push(*value));
        }
        let way = v * (1.0 - 0.5 * w.abs()) * step_s;
        let middle = yaw + w * step_s / 2.0;
        x += way * middle.cos();
        y += way * middle.sin();
        yaw += w * step_s;
    }
    let [t_s, v_m_s, w_rad_s] = told;
    let mut robot = Robot::named("r1");
    robot.command = Some(Stream {
        t_s,
        values: Command::Twist { v_m_s, w_rad_s },
        unknown: vec![],
    });
    let [t_s, x_m, y_m, yaw] = seen;
    robot.pose = Some(Stream {
        t_s,
        values: Pose {
            x_m,
            y_m,
            yaw_rad: Some(yaw),
        },
        unknown: vec![],
    });
    Recording {
        name: "arcs".to_owned(),
        robots: vec![robot],
        ..Recording::default()
    }
}

#[test]
fn a_robot_that_drives_otherwise_than_told_has_an_unknown_motion() {
    let recording = slow_in_arcs();
    // no mass is known: nothing speaks of forces
    let mut nominal = RobotModel::default();
    nominal.robot.body_mass_kg = None;
    let answer = answered(&recording, &nominal);
    assert_eq!(answer.verdict, Verdict::Unexplained, "{}", listing(&answer));
    let mut findings = answer.findings.iter();
    let unknown = findings.find(|f| f.effect == "unknown").unwrap();
    assert_eq!(unknown.place.channel, "longitudinal");
    assert_eq!(unknown.driver.as_deref(), Some("w"));
    let shape = unknown.shape.as_deref().unwrap();
    assert!(
        shape.contains("forward speed that depends on the turn rate"),
        "{shape}"
    );
    // what it is missing where v, too, changes by a third is no function of w
    let predicted = &answer.held_out;
    assert!(
        predicted.nrmse_after < 0.5 * predicted.nrmse_before,
        "{}",
        listing(&answer)
    );
}

/// Forces of less than half a millinewton are what integrators differ by: a drag so small is no physics.
#[test]
fn what_moves_the_encoders_by_less_than_a_count_is_no_finding() {
    let nominal = RobotModel::default();
    let drag = |coefficient: f64| {
        let truth = nominal
            .clone()
            .with("viscous_drag", &[("coefficient", coefficient)]);
        answer(&truth, &nominal, 6).0
    };
    let found = |answer: &Answer| -> Vec<String> {
        answer.findings.iter().map(|f| f.effect.clone()).collect()
    };
    let slight = drag(5e-5);
    assert_eq!(slight.verdict, Verdict::Match, "{}", listing(&slight));
    let clear = drag(4e-3);
    assert_eq!(found(&clear), ["viscous_drag"], "{}", listing(&clear));
}

/// What the droop leaves in the window of the push is no part of the push: neither explains the
/// recording alone.
#[test]
fn a_push_is_found_beside_what_acts_always() {
    let nominal = RobotModel::default();
    let push = [("t_s", 7.0), ("impulse_n_s", 0.05), ("direction_rad", -0.3)];
    let truth = nominal
        .clone()
        .with("torque_speed_droop", &[("coefficient", 2e-5)])
        .with("push", &push);
    let (answer, _) = answer(&truth, &nominal, 7);
    let mut found: Vec<&str> = answer.findings.iter().map(|f| f.effect.as_str()).collect();
    found.sort_unstable();
    assert_eq!(
        found,
        ["push", "torque_speed_droop"],
        "{}",
        listing(&answer)
    );
}

/// A friction that is a few parts in a hundred off fits worse than wheels that never slide, where they
/// slide now and then: on any floor one has to begin close by.
#[test]
fn slip_is_found_on_any_floor() {
    let nominal = RobotModel::default();
    let soft = |t_s: f64| slipstream_testkit::gentle(t_s).map(|torque_nm| 0.5 * torque_nm);
    let strong = |t_s: f64| slipstream_testkit::gentle(t_s).map(|torque_nm| 2.0 * torque_nm);
    type Torque = fn(f64) -> [f64; 2];
    let floors: [(f64, Torque); 2] = [(0.068, soft), (0.28, strong)];
    for (friction, torque) in floors {
        let grip = [
            ("friction_static", friction),
            ("friction_kinetic", friction),
        ];
        let truth = nominal.clone().with("wheel_slip", &grip);
        let answer = answered(
            &slipstream_testkit::record(&truth, torque, 12.0, 11),
            &nominal,
        );
        let text = listing(&answer);
        let [slip] = answer.findings.as_slice() else {
            panic!("{friction}: {text}")
        };
        assert_eq!(slip.effect, "wheel_slip", "{friction}: {text}");
        let kinetic = slip.parameters[1].estimate.unwrap();
        assert!(
            (kinetic - friction).abs() < 0.01 * friction,
            "{friction}: {text}"
        );
    }
}

/// A robot of 68 kg on wheels of a third of a metre.
fn large() -> RobotModel {
    let robot = Body {
        body_mass_kg: Some(60.0),
        body_yaw_inertia_kg_m2: Some(4.0),
        wheel_mass_kg: Some(4.0),
        wheel_spin_inertia_kg_m2: Some(0.08),
        wheel_yaw_inertia_kg_m2: Some(0.04),
        wheel_radius_m: 0.165,
        half_track_m: 0.285,
        com_to_axle_m: Some(0.15),
        com_to_caster_m: Some(0.35),
        com_height_m: Some(0.2),
    };
    RobotModel {
        robot,
        motor: None,
        ..RobotModel::default()
    }
}

/// The sizes from which effects begin are those of a robot of 1.6 kg.
#[test]
fn effects_are_found_on_a_robot_of_any_size() {
    let nominal = large();
    let effects: [(&str, &[(&str, f64)]); 4] = [
        ("axle_friction", &[("torque_nm", 1.0)]),
        ("payload", &[("mass_kg", 8.0), ("x_m", 0.1), ("y_m", 0.1)]),
        (
            "push",
            &[("t_s", 6.0), ("impulse_n_s", 15.0), ("direction_rad", 1.0)],
        ),
        (
            "friction_patch",
            &[
                ("x_m", 5.12),
                ("y_m", 0.31),
                ("radius_m", 0.5),
                ("friction", 0.05),
            ],
        ),
    ];
    for (id, parameters) in effects {
        let truth = nominal.clone().with(id, parameters);
        let torque = |t_s: f64| slipstream_testkit::gentle(t_s).map(|torque_nm| 100.0 * torque_nm);
        let answer = answered(
            &slipstream_testkit::record(&truth, torque, 12.0, 11),
            &nominal,
        );
        let text = listing(&answer);
        let [found] = answer.findings.as_slice() else {
            panic!("{id}: {text}")
        };
        assert_eq!(found.effect, id, "{text}");
        for ((name, value), found) in parameters.iter().zip(&found.parameters) {
            let estimate = found.estimate.unwrap();
            assert!((estimate - value).abs() < 0.01 * value, "{name}: {text}");
        }
    }
}

#[test]
fn recordings_of_speeds_and_of_torques_are_not_mixed() {
    let model = RobotModel::default();
    let torques = slipstream_testkit::record(&model, slipstream_testkit::gentle, 10.0, 7);
    let mut speeds = torques.clone();
    let stream = speeds.robots[0].command.as_mut().unwrap();
    let still = vec![0.0; stream.t_s.len()];
    stream.values = Command::WheelSpeed {
        right_rad_s: still.clone(),
        left_rad_s: still,
    };
    let refused = diagnose(&Request {
        recordings: &[torques, speeds],
        against: &[],
        model_of: &|_| Some(model.clone()),
        excluded: &[],
        excluded_s: &[],
        progress: &|_| (),
    });
    let words = refused.unwrap_err().to_string();
    assert!(words.contains("told speeds in one recording"), "{words}");
}

#[test]
fn a_change_of_a_robot_with_masses_is_told_from_what_it_lacked_before() {
    let nominal = RobotModel::default();
    let before = nominal
        .clone()
        .with("rolling_resistance", &[("coefficient", 0.008)]);
    let today = before.clone().with("pose_latency", &[("latency_s", 0.05)]);
    let recorded = |truth: &RobotModel, seed: u64| {
        slipstream_testkit::record(truth, slipstream_testkit::gentle, 12.0, seed)
    };
    for (then, now, wanted) in [(&before, &today, 1), (&before, &before, 0)] {
        let (answer, _) = diagnose(&Request {
            recordings: &[recorded(now, 12)],
            against: &[recorded(then, 11)],
            model_of: &|_| Some(nominal.clone()),
            excluded: &[],
            excluded_s: &[],
            progress: &|_| (),
        })
        .unwrap();
        let text = serde_json::to_string(&answer).unwrap();
        assert_eq!(answer.findings.len(), wanted, "{text}");
        for finding in &answer.findings {
            assert_eq!(finding.effect, "pose_latency", "{text}");
            let parameter = &finding.parameters[0];
            assert_eq!(parameter.nominal, None, "{text}");
            assert!((parameter.estimate.unwrap() - 0.05).abs() < 2e-3, "{text}");
        }
    }
}
