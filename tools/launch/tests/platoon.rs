//! The platoon of the paper, in one process.

use slipstream_bus::experiment::{Protocol, TorqueLimit};
use slipstream_bus::{Experiment, RobotModel, RobotSetup, Settings};
use slipstream_launch::in_process::{run, run_recorded};

fn experiment(change: impl Fn(&mut Settings)) -> Experiment {
    let mut settings = Settings::default();
    change(&mut settings);
    let robots = (0..settings.robots.count)
        .map(|index| RobotSetup {
            name: format!("r{}", index + 1),
            model: RobotModel::paper_with_slip(),
            pose: settings.start_pose(index),
        })
        .collect();
    Experiment {
        settings,
        robots,
        half_round_trips_ns: Vec::new(),
    }
}

#[test]
fn look() {
    for limit in [
        TorqueLimit::None,
        TorqueLimit::Inner,
        TorqueLimit::Outer,
        TorqueLimit::Adaptive,
    ] {
        for delay in [0.0, 0.1] {
            for protocol in [Protocol::Ring, Protocol::Periodic] {
                let e = experiment(|s| {
                    s.control.torque_limit = limit;
                    s.links.protocol = protocol;
                    s.links.delay_s = delay;
                });
                let r = run(&e, true).unwrap();
                println!("{limit:?} {protocol:?} {delay} wall {:.4}", r.wall_s);
                for (p, a) in r.plant.robots.iter().zip(&r.agents) {
                    println!(
                        "   {:?} odo {:?} slip {:?} {:?} spacing {:?} vmax {:.3} {:?}",
                        p.final_true,
                        a.final_odometry,
                        p.slip_time_s,
                        p.max_slip_m_s,
                        p.max_spacing_error_m,
                        a.max_desired_speed_m_s,
                        a.received
                    );
                }
            }
        }
    }
    let e = experiment(|s| {
        s.control.torque_limit = TorqueLimit::Adaptive;
    });
    let (_, records) = run_recorded(&e, false, Vec::new()).unwrap();
    println!("{} records", records.len());
}
