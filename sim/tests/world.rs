//! N robots with sensors and noise.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use slipstream_bus::{Camera, Imu, RobotModel, Sensors};
use slipstream_sim::{Command, Setup, World};

fn setup(name: &str) -> Setup {
    Setup {
        name: name.to_owned(),
        model: RobotModel::paper_with_slip(),
        pose: [0.0; 3],
        sensors: Sensors {
            camera: Some(Camera::default()),
            imu: Some(Imu::default()),
        },
    }
}

const DRIVE: Command = Command::Torque {
    right_nm: 0.1,
    left_nm: 0.08,
};

/// All measurements of robot `i` in one second.
fn measurements(names: &[&str], i: usize, seed: u64) -> Vec<(i64, [f64; 3])> {
    let setups: Vec<Setup> = names.iter().map(|name| setup(name)).collect();
    let mut world = World::new(&setups, seed).unwrap();
    let mut measured = Vec::new();
    for _ in 0..1000 {
        world.step(1_000_000, &vec![DRIVE; names.len()]);
        let [right, left] = world.encoder_counts(i);
        measured.push((world.time_ns(), [right as f64, left as f64, 0.0]));
        let samples = [world.camera(i), world.imu(i)];
        measured.extend(samples.into_iter().flatten().map(|s| (s.stamp_ns, s.value)));
    }
    measured
}

#[test]
fn noise_of_a_robot_does_not_depend_on_the_others() {
    let alone = measurements(&["r1"], 0, 7);
    assert_eq!(alone, measurements(&["r1", "r2", "r3"], 0, 7));
    assert_eq!(alone, measurements(&["r0", "r1"], 1, 7));
    assert_ne!(
        alone,
        measurements(&["r1"], 0, 8),
        "another seed gives other noise"
    );
    assert_ne!(
        alone,
        measurements(&["r2"], 0, 7),
        "another robot has other noise"
    );
}

#[test]
fn sensors_have_the_configured_rates_and_deviations() {
    let mut still = setup("r1");
    still.sensors.camera = Some(Camera {
        dropout: 0.25,
        ..Camera::default()
    });
    let mut world = World::new(&[still], 3).unwrap();
    let (mut frames, mut samples) = (Vec::new(), Vec::new());
    for _ in 0..400_000 {
        world.step(1_000_000, &[Command::zero_torque()]);
        frames.extend(world.camera(0));
        samples.extend(world.imu(0));
    }
    // 400 s: 12,000 frames, a quarter of them lost; 40,000 inertial samples
    assert!((8_800..9_200).contains(&frames.len()), "{}", frames.len());
    assert!(
        (39_999..=40_001).contains(&samples.len()),
        "{}",
        samples.len()
    );
    let deviation = |values: &[f64]| {
        let square: f64 = values.iter().map(|value| value * value).sum();
        (square / values.len() as f64).sqrt()
    };
    // within five standard errors of an estimate from that many samples
    let near = |value: f64, expected: f64, count: usize| {
        let tolerance = 5.0 * expected / (2.0 * count as f64).sqrt();
        assert!(
            (value - expected).abs() < tolerance,
            "{value} is not {expected}"
        );
    };
    let axis = |k: usize| frames.iter().map(|f| f.value[k]).collect::<Vec<_>>();
    near(deviation(&axis(0)), 0.002, frames.len());
    near(deviation(&axis(2)), 0.009, frames.len());
    let yaw: Vec<f64> = samples.iter().map(|s| s.value[2]).collect();
    near(deviation(&yaw), 0.006, yaw.len());
}

/// The counter is floor(angle · counts / 2π + phase): within one count of the wheel angle.
#[test]
fn encoder_counts_follow_the_wheel_angle() {
    let mut world = World::new(&[setup("r1")], 5).unwrap();
    for _ in 0..3000 {
        world.step(1_000_000, &[DRIVE]);
        let exact = world
            .truth(0)
            .wheel_angle_rad
            .map(|a| a * 1856.0 / std::f64::consts::TAU);
        for (count, exact) in world.encoder_counts(0).into_iter().zip(exact) {
            let apart = count as f64 - exact;
            assert!(apart > -1.0 && apart < 1.0, "{count} {exact}");
        }
    }
}

#[test]
fn rejects_invalid_sensors_naming_the_robot() {
    let mut wrong = setup("r9");
    wrong.sensors.camera = Some(Camera {
        rate_hz: 0.0,
        ..Camera::default()
    });
    let error = World::new(&[wrong], 1).unwrap_err();
    assert_eq!(error.place, "r9: sensors.camera.rate_hz");
}

/// A step allocates nothing: rolling, slipping, with every kind of friction, backlash and delay.
#[test]
fn steps_allocate_nothing() {
    let slipping = RobotModel::paper_with_slip();
    let with_effects = slipping
        .clone()
        .with("axle_friction", &[("torque_nm", 0.004)])
        .with("caster_drag", &[("friction", 0.05)])
        .with("yaw_scrub", &[("moment_nm", 0.003)])
        .with("backlash", &[("gap_rad", 0.03)])
        .with("actuator_delay", &[("delay_s", 0.0234)])
        .with("actuator_lag", &[("time_constant_s", 0.02)])
        .with(
            "friction_patch",
            &[
                ("x_m", 0.3),
                ("y_m", 0.0),
                ("radius_m", 0.1),
                ("friction", 0.1),
            ],
        )
        .with(
            "push",
            &[("t_s", 0.5), ("impulse_n_s", 0.2), ("direction_rad", 1.0)],
        )
        .with("floor_slope", &[("grade", 0.01), ("downhill_rad", 1.0)]);
    for model in [RobotModel::default(), slipping, with_effects] {
        let setups: Vec<Setup> = ["r1", "r2"]
            .map(|name| Setup {
                model: model.clone(),
                ..setup(name)
            })
            .into();
        let mut world = World::new(&setups, 1).unwrap();
        let counted = allocation_counter::measure(|| {
            for k in 0..2000 {
                let torque = 0.13 * f64::from(k / 20).sin();
                let command = Command::Torque {
                    right_nm: torque,
                    left_nm: -0.7 * torque,
                };
                world.step(1_000_000, &[command; 2]);
                let _ = (
                    world.camera(0),
                    world.imu(0),
                    world.encoder_counts(0),
                    world.truth(0),
                );
            }
        });
        assert_eq!(counted.count_total, 0, "{:?}", model.effects);
    }
}
