//! String gain: the linear model's frequency response against a simulated platoon whose front robot's
//! speed oscillates at one frequency.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::TAU;

use slipstream_agents::Geometry;
use slipstream_bus::RobotModel;
use slipstream_bus::record::Record;
use slipstream_launch::{Request, in_process, resolve};
use slipstream_study::delay::string_gain_at;

/// Time for the transient at the start of coordination to decay, with k_x = 1 1/s (s).
const SETTLE_S: f64 = 25.0;
/// Number of periods measured.
const PERIODS: u32 = 12;
/// Delay on each link (s).
const DELAY_S: f64 = 0.2;

/// |E₂ / E₁| of three robots without wheel slip whose velocity profile oscillates at this frequency:
/// measured, and by the linear model.
fn gains(omega_rad_s: f64) -> [f64; 2] {
    let period_s = TAU / omega_rad_s;
    // Coordination starts at 3 s.
    let begin_s = 3.0 + SETTLE_S;
    let end_s = begin_s + period_s * f64::from(PERIODS);
    let set = [
        ("links.delay_s", DELAY_S.to_string()),
        ("links.protocol", "periodic".to_owned()),
        ("duration_s", end_s.to_string()),
        ("control.torque_max_nm", "10".to_owned()),
    ];
    let request = Request {
        robots: Some(3),
        set: set.map(|(key, value)| (key.to_owned(), value)).to_vec(),
        ..Request::default()
    };
    let mut experiment = resolve(&request).unwrap().experiment;
    let profile = &mut experiment.settings.profile;
    // The profile is piecewise linear, with forty pieces in a period.
    let points = (end_s / period_s * 40.0).ceil() as u32 + 1;
    profile.times_s = (0..points)
        .map(|i| f64::from(i) * period_s / 40.0)
        .collect();
    let speed = |t_s: &f64| 0.4 + 0.1 * (omega_rad_s * t_s).sin();
    profile.speeds_m_s = profile.times_s.iter().map(speed).collect();
    profile.yaw_rates_rad_s = vec![0.0; points as usize];
    for robot in &mut experiment.robots {
        // Without wheel slip.
        robot.model = RobotModel::default();
    }
    let (_, records) = in_process::run_recorded(&experiment, false, Vec::<Record>::new()).unwrap();
    let place = |robot: u32| {
        let states = records.iter().filter_map(move |record| match record {
            Record::State(state) if state.robot == robot => Some((state.t_ns, state.pose[0])),
            _ => None,
        });
        states.collect::<Vec<_>>()
    };
    let amplitude = |robot: u32| {
        let errors = place(robot - 1).into_iter().zip(place(robot));
        let errors = errors.map(|((t_ns, ahead), (_, own))| (t_ns as f64 / 1e9, ahead - own));
        let errors: Vec<(f64, f64)> = errors.filter(|(t_s, _)| *t_s > begin_s).collect();
        let mean = errors.iter().map(|(_, error)| error).sum::<f64>() / errors.len() as f64;
        let (mut sine, mut cosine) = (0.0, 0.0);
        for (t_s, error) in errors {
            sine += (error - mean) * (omega_rad_s * t_s).sin();
            cosine += (error - mean) * (omega_rad_s * t_s).cos();
        }
        f64::hypot(sine, cosine)
    };
    let control = &experiment.settings.control;
    let geometry = Geometry::new(&experiment.robots[0].model).unwrap();
    let linear = string_gain_at(control, &geometry, DELAY_S, omega_rad_s, 3).unwrap();
    [amplitude(2) / amplitude(1), linear]
}

#[test]
fn an_oscillating_platoon_has_the_gain_of_the_frequency_response() {
    for omega_rad_s in [0.5, 1.0, 2.0, 4.0, 8.0] {
        let [measured, linear] = gains(omega_rad_s);
        println!("{omega_rad_s} rad/s: measured {measured:.4}, linear model {linear:.4}");
        assert!(
            (measured / linear - 1.0).abs() < 0.015,
            "{omega_rad_s}: {measured} {linear}"
        );
    }
}
