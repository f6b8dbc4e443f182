//! Physical laws that hold for every robot and every command.

use crate::support::{
    STEP_S, assert_near, drive, kinetic_energy, mixed, robot, torque, with_friction,
};
use proptest::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_sim::{Command, Robot, State};

fn mixed_torque(size_nm: f64) -> impl Fn(f64) -> Command {
    move |t_s| {
        let [right, left] = mixed(t_s, size_nm);
        torque(right, left)
    }
}

/// Without input energy never grows, with any friction. Heun's method may add energy in the
/// inertial terms, of third order in the step: 1e-9 of it per step.
#[test]
fn energy_never_grows_without_input() {
    let frictions = [
        RobotModel::default(),
        with_friction(0.05),
        with_friction(0.24),
        with_friction(0.24).with("axle_friction", &[("torque_nm", 0.004)]),
        with_friction(0.15).with("caster_drag", &[("friction", 0.1)]),
        RobotModel::default()
            .with("rolling_resistance", &[("coefficient", 0.01)])
            .with("yaw_scrub", &[("moment_nm", 0.01)])
            .with("viscous_drag", &[("coefficient", 0.3)])
            .with("quadratic_drag", &[("coefficient", 0.3)])
            .with("torque_speed_droop", &[("coefficient", 1e-3)]),
    ];
    for model in frictions {
        let robot = robot(&model);
        for start_nm in [[0.2, 0.2], [0.2, -0.1], [0.03, 0.25]] {
            let mut state = robot.start([0.0; 3]);
            drive(&robot, &mut state, 0.0, 0.7, STEP_S, |_| {
                torque(start_nm[0], start_nm[1])
            });
            let mut energy = kinetic_energy(&model, &state);
            for k in 0..4000 {
                robot.step(
                    &mut state,
                    0.7 + f64::from(k) * STEP_S,
                    STEP_S,
                    &torque(0.0, 0.0),
                );
                let next = kinetic_energy(&model, &state);
                assert!(
                    next <= energy * (1.0 + 1e-9),
                    "{energy} grew to {next} in step {k}"
                );
                energy = next;
            }
        }
    }
}

/// Rolling without friction is conservative: the kinetic energy is the work of the motors.
#[test]
fn energy_is_the_work_of_the_motors() {
    let model = RobotModel::default();
    let robot = robot(&model);
    let mut state = robot.start([0.0; 3]);
    let mut work = 0.0;
    for k in 0..5000 {
        let [right, left] = mixed(f64::from(k) * STEP_S, 0.05);
        let before = state.wheel_angle();
        robot.step(
            &mut state,
            f64::from(k) * STEP_S,
            STEP_S,
            &torque(right, left),
        );
        let after = state.wheel_angle();
        work += right * (after[0] - before[0]) + left * (after[1] - before[1]);
    }
    let energy = kinetic_energy(&model, &state);
    assert_near("energy", energy, work, 1e-6 * work);
}

/// The forces of each wheel stay inside its friction disc.
#[test]
fn forces_stay_inside_the_friction_disc() {
    let (friction, height) = (0.24, 0.0216);
    let robot = robot(&with_friction(friction));
    let mut state = robot.start([0.0; 3]);
    let (mut slid, mut stuck) = (0, 0);
    for k in 0..20_000 {
        let t_s = f64::from(k) * STEP_S;
        robot.step(&mut state, t_s, STEP_S, &mixed_torque(0.1)(t_s));
        let contact = state.contact_forces();
        let [right, left] = contact.normal_n;
        let limits = contact.normal_n.map(|n| friction * n);
        let spare = [0, 1].map(|i| limits[i].powi(2) - contact.longitudinal_n[i].powi(2));
        let tolerance = 1e-8 * (limits[0] + limits[1]);
        assert!(
            spare[0] > -tolerance && spare[1] > -tolerance,
            "{contact:?}"
        );
        let across = spare[0].max(0.0).sqrt() + spare[1].max(0.0).sqrt();
        assert!(
            contact.lateral_n.abs() <= across + 1e-3 * across.max(1e-3),
            "{contact:?}"
        );
        assert_near(
            "Eq. 5",
            (right - left) * 0.105,
            contact.lateral_n * height,
            1e-12,
        );
        if state.slides() == [true, true] {
            slid += 1;
        } else if state.slides() == [false, false] {
            stuck += 1;
        }
    }
    assert!(
        slid > 500 && stuck > 500,
        "both modes occur: {slid} and {stuck}"
    );
}

fn drive_mixed(model: &RobotModel, pose: [f64; 3], size_nm: f64, swap: bool) -> State {
    let robot = robot(model);
    let mut state = robot.start(pose);
    drive(&robot, &mut state, 0.0, 5.0, STEP_S, |t_s| {
        let [right, left] = mixed(t_s, size_nm);
        if swap {
            torque(left, right)
        } else {
            torque(right, left)
        }
    });
    state
}

/// Exchanging left and right gives the mirror image. Sums in another order round differently; with
/// slip, differences in the last digit grow to 1e-7 in 5 s.
#[test]
fn mirror_symmetry() {
    for (model, size_nm, tolerance) in [
        (RobotModel::default(), 0.05, 1e-11),
        (with_friction(0.24), 0.1, 1e-6),
    ] {
        let [x, y, phi] = drive_mixed(&model, [0.0; 3], size_nm, false).pose();
        let mirrored = drive_mixed(&model, [0.0; 3], size_nm, true).pose();
        assert_near("x", mirrored[0], x, tolerance);
        assert_near("y", mirrored[1], -y, tolerance);
        assert_near("phi", mirrored[2], -phi, tolerance);
    }
}

/// The motion does not depend on position and orientation of the world frame.
#[test]
fn frame_invariance() {
    for (model, size_nm) in [(RobotModel::default(), 0.05), (with_friction(0.24), 0.1)] {
        let [x, y, phi] = drive_mixed(&model, [0.0; 3], size_nm, false).pose();
        let (x0, y0, turn) = (3.0, -7.0, 1.1_f64);
        let moved = drive_mixed(&model, [x0, y0, turn], size_nm, false).pose();
        let (sin, cos) = turn.sin_cos();
        assert_near("x", moved[0], x0 + x * cos - y * sin, 1e-11);
        assert_near("y", moved[1], y0 + x * sin + y * cos, 1e-11);
        assert_near("phi", moved[2], turn + phi, 1e-11);
    }
}

/// On almost frictionless floor the wheels spin and the robot keeps the linear momentum of a push.
#[test]
fn momentum_is_kept_on_a_frictionless_floor() {
    let model = with_friction(1e-3)
        .with(
            "friction_patch",
            &[
                ("x_m", 0.0),
                ("y_m", 0.0),
                ("radius_m", 1e3),
                ("friction", 1e-3),
            ],
        )
        .with(
            "push",
            &[("t_s", 0.1), ("impulse_n_s", 0.5), ("direction_rad", 0.7)],
        );
    let robot = robot(&model);
    let mut state = robot.start([0.0, 0.0, 0.3]);
    drive(&robot, &mut state, 0.0, 0.2, STEP_S, |_| {
        torque(0.05, -0.02)
    });
    let momentum = |state: &State| {
        let [u, w, rate] = state.velocity();
        let (sin, cos) = state.pose()[2].sin_cos();
        // of body and wheels; the wheels' masses are d behind c
        let (m, back) = (1.5 + 2.0 * 0.064, 2.0 * 0.064 * 0.055);
        let (along, across) = (m * u, m * w - back * rate);
        [along * cos - across * sin, along * sin + across * cos]
    };
    let before = momentum(&state);
    let friction_n = 1e-3 * 1.628 * 9.81;
    // the push's 0.5 N s less what friction of 0.001 takes in 0.2 s
    assert_near("x", before[0], 0.5 * 0.7_f64.cos(), 0.2 * friction_n);
    assert_near("y", before[1], 0.5 * 0.7_f64.sin(), 0.2 * friction_n);
    drive(&robot, &mut state, 0.2, 1.0, STEP_S, |_| {
        torque(0.05, -0.02)
    });
    let after = momentum(&state);
    assert_near("x", after[0], before[0], friction_n);
    assert_near("y", after[1], before[1], friction_n);
}

/// Without dissipation the motion is reversible: from opposite velocities, the torques in reverse
/// order lead back to the start. Heun's method itself is not reversible: 1e-6 in 4 s.
#[test]
fn motion_is_reversible_without_friction() {
    let robot = robot(&RobotModel::default());
    let mut forth = robot.start([0.0; 3]);
    let command = mixed_torque(0.05);
    drive(&robot, &mut forth, 0.0, 4.0, STEP_S, &command);
    let mut back = robot.start(forth.pose());
    let (velocity, wheels) = (forth.velocity(), forth.wheel_speed());
    robot.set_motion(&mut back, velocity.map(|v| -v), wheels.map(|w| -w));
    drive(&robot, &mut back, 0.0, 4.0, STEP_S, |t_s| {
        command(4.0 - t_s)
    });
    for (axis, value) in back.pose().into_iter().enumerate() {
        assert_near("pose", value, 0.0, 2e-6 * (1.0 + axis as f64));
    }
}

/// Wheels of almost no inertia roll, spin and stop like any others.
#[test]
fn any_positive_wheel_inertia_is_stable() {
    for inertia in [1e-12, 1e-9, 1e-6, 1e-3, 1.0] {
        for friction in [None, Some(0.24)] {
            let mut model = friction.map_or_else(RobotModel::default, with_friction);
            model.robot.wheel_spin_inertia_kg_m2 = Some(inertia);
            let robot = robot(&model);
            let mut state = robot.start([0.0; 3]);
            drive(&robot, &mut state, 0.0, 3.0, STEP_S, mixed_torque(0.04));
            let [u, w, rate] = state.velocity();
            assert!(
                u.hypot(w) < 10.0 && rate.abs() < 100.0,
                "I_wy {inertia}: {u} {w} {rate}"
            );
            // Eq. 1 while the wheels roll
            if state.slides() == [false, false] {
                for slip in robot.slip_m_s(&state) {
                    assert_near("slip", slip, 0.0, 1e-12);
                }
            }
        }
    }
}

/// Without wheel slip, Eq. 1 holds to 1e-12 after every step.
#[test]
fn rolling_satisfies_eq_1() {
    let robot = robot(&RobotModel::default());
    let mut state = robot.start([0.0; 3]);
    for k in 0..10_000 {
        let t_s = f64::from(k) * STEP_S;
        robot.step(&mut state, t_s, STEP_S, &mixed_torque(0.08)(t_s));
        for slip in robot.slip_m_s(&state) {
            assert_near("slip", slip, 0.0, 1e-12);
        }
    }
}

/// The fast paths agree with the general step, which a push of zero in the far future forces a
/// robot to take.
#[test]
fn fast_paths_agree_with_the_general_step() {
    let zero_push = [("t_s", 1e5), ("impulse_n_s", 0.0), ("direction_rad", 0.0)];
    for (model, size_nm) in [
        (RobotModel::default(), 0.05),
        (RobotModel::paper_with_slip(), 0.03),
        (RobotModel::paper_with_slip(), 0.11),
    ] {
        let fast = drive_mixed(&model, [0.1, 0.2, 0.3], size_nm, false);
        let general = drive_mixed(
            &model.with("push", &zero_push),
            [0.1, 0.2, 0.3],
            size_nm,
            false,
        );
        for (a, b) in fast.pose().into_iter().zip(general.pose()) {
            // sums in another order; with slip, differences in the last digit grow
            assert_near("pose", a, b, 1e-7);
        }
    }
}

fn any_robot() -> impl Strategy<Value = RobotModel> {
    let masses = (0.05..50.0, 0.001..2.0, 1e-6..1e-2_f64, 0.02..0.3_f64);
    let lengths = (0.05..0.5_f64, 0.0..0.3_f64, 0.05..0.5_f64, 0.0..0.2_f64);
    let effects = proptest::collection::vec(0..12_usize, 0..5);
    (masses, lengths, 0.02..1.2_f64, 0.5..1.0_f64, effects).prop_map(
        |((mass, wheel, spin, radius), (b, d, e, h), friction, share, effects)| {
            let mut model = RobotModel::default().with(
                "wheel_slip",
                &[
                    ("friction_static", friction),
                    ("friction_kinetic", friction * share),
                ],
            );
            model.robot.body_mass_kg = Some(mass);
            model.robot.body_yaw_inertia_kg_m2 = Some(mass * b * b);
            model.robot.wheel_mass_kg = Some(wheel);
            model.robot.wheel_spin_inertia_kg_m2 = Some(spin * (1.0 + wheel * 100.0));
            model.robot.wheel_radius_m = radius;
            model.robot.half_track_m = b;
            model.robot.com_to_axle_m = Some(d);
            model.robot.com_to_caster_m = Some(e);
            model.robot.com_height_m = Some(h);
            let weight = mass * 9.81;
            let list: [(&str, &[(&str, f64)]); 12] = [
                ("rolling_resistance", &[("coefficient", 0.02)]),
                ("viscous_drag", &[("coefficient", 1.0)]),
                ("quadratic_drag", &[("coefficient", 0.1)]),
                ("caster_drag", &[("friction", 0.1)]),
                ("yaw_scrub", &[("moment_nm", 0.02 * weight * b)]),
                ("axle_friction", &[("torque_nm", 0.01 * weight * radius)]),
                ("backlash", &[("gap_rad", 0.05)]),
                ("actuator_lag", &[("time_constant_s", 0.03)]),
                ("load_transfer", &[("com_height_m", h)]),
                ("floor_slope", &[("grade", 0.05), ("downhill_rad", 2.0)]),
                ("actuator_delay", &[("delay_s", 0.0133)]),
                (
                    "wheel_radius",
                    &[("right_scale", 0.97), ("left_scale", 1.02)],
                ),
            ];
            for i in effects {
                let (effect, parameters) = list[i];
                if !model.effects.iter().any(|known| known.effect == effect) {
                    model = model.with(effect, parameters);
                }
            }
            model
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Random robots with random effects under random commands of every kind stay finite and slower
    /// than their input allows.
    #[test]
    fn motion_stays_bounded(
        model in any_robot(),
        kind in 0..4,
        sizes in proptest::collection::vec((-2.0..2.0_f64, -2.0..2.0_f64), 25),
    ) {
        let Ok(robot) = Robot::new(&model) else { return Ok(()) };
        let mut state = robot.start([0.0; 3]);
        let scale = model.robot.body_mass_kg.unwrap() * 9.81 * model.robot.wheel_radius_m * 0.3;
        for (k, (right, left)) in sizes.iter().flat_map(|pair| std::iter::repeat_n(pair, 40)).enumerate() {
            let command = match kind {
                0 => torque(right * scale, left * scale),
                1 => Command::Voltage { right_v: right * 6.0, left_v: left * 6.0 },
                2 => Command::Speed { right_rad_s: right * 5.0, left_rad_s: left * 5.0 },
                _ => Command::Twist { v_m_s: *right, w_rad_s: *left },
            };
            robot.step(&mut state, k as f64 * STEP_S, STEP_S, &command);
        }
        let [u, w, rate] = state.velocity();
        let all = [state.pose(), state.velocity()];
        prop_assert!(all.iter().flatten().all(|value| value.is_finite()), "{all:?}");
        prop_assert!(u.hypot(w) < 60.0 && rate.abs() < 600.0, "{u} {w} {rate}");
    }
}
