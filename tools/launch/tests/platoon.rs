//! The paper's experiments in one process: slip, torque limits, formation, delay, ring protocol, watchdog.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use slipstream_bus::experiment::{Protocol, TorqueLimit};
use slipstream_bus::record::{EventKind, Fate, Record};
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_launch::Reports;
use slipstream_launch::in_process::{run, run_recorded};

fn experiment(mut settings: Settings, change: impl Fn(&mut Settings)) -> Experiment {
    change(&mut settings);
    settings.validate().unwrap();
    Experiment::new(settings, &RobotModel::paper_with_slip())
}

fn platoon(change: impl Fn(&mut Settings)) -> Reports {
    run(&experiment(Settings::default(), change), false).unwrap()
}

fn slip_s(reports: &Reports) -> f64 {
    reports
        .plant
        .robots
        .iter()
        .flat_map(|robot| robot.slip_time_s)
        .fold(0.0, f64::max)
}

/// Section 4: with a torque limit the wheels do not slip. Without it they do, and the odometry reads more than
/// the true distance.
#[test]
fn the_torque_limit_prevents_slip() {
    for protocol in [Protocol::Ring, Protocol::Periodic] {
        for delay_s in [0.0, 0.1] {
            let with = |limit| {
                platoon(|s| {
                    s.control.torque_limit = limit;
                    s.links.protocol = protocol;
                    s.links.delay_s = delay_s;
                })
            };
            let free = with(TorqueLimit::None);
            assert!(slip_s(&free) > 0.2, "{protocol:?} {delay_s}");
            let odometry_m = free.agents[0].final_odometry[0];
            assert!(odometry_m > free.plant.robots[0].final_true[0] + 0.02);
            for limit in [TorqueLimit::Inner, TorqueLimit::Outer] {
                let slip = slip_s(&with(limit));
                assert!(slip == 0.0, "{limit:?} {protocol:?} {delay_s}: {slip}");
            }
            // The adaptive limit estimates the friction from slip, so that some slip remains.
            let adaptive = slip_s(&with(TorqueLimit::Adaptive));
            assert!(adaptive > 0.0 && adaptive < slip_s(&free), "{adaptive}");
        }
    }
}

/// The robots drive the 4.302 m of the profile and stop 0.6096 m apart.
#[test]
fn the_platoon_arrives_in_formation() {
    let reports = platoon(|s| s.control.torque_limit = TorqueLimit::Inner);
    let x: Vec<f64> = reports
        .plant
        .robots
        .iter()
        .map(|robot| robot.final_true[0])
        .collect();
    assert!((x[0] - (0.6096 + 4.302)).abs() < 0.01, "{x:?}");
    assert!(
        (x[0] - x[1] - 0.6096).abs() < 0.01 && (x[1] - x[2] - 0.6096).abs() < 0.01,
        "{x:?}"
    );
    assert_eq!(reports.plant.robots[0].max_spacing_error_m, None);
}

/// Delayed positions cause larger corrections and larger spacing errors (the paper's result on delay).
#[test]
fn spacing_error_grows_with_delay() {
    let error = |delay_s| {
        let reports = platoon(|s| s.links.delay_s = delay_s);
        reports.plant.robots[1].max_spacing_error_m.unwrap()
    };
    let errors = [error(0.0), error(0.1), error(0.3)];
    assert!(errors[0] < errors[1] && errors[1] < errors[2], "{errors:?}");
}

/// In a curve, the reference of a follower lies on the path of the robot ahead, not straight behind that robot.
#[test]
fn a_turning_platoon_follows_the_path() {
    let reports = platoon(|s| {
        s.profile.times_s = vec![0.0, 1.0, 4.0, 5.0];
        s.profile.speeds_m_s = vec![0.0, 0.3, 0.3, 0.3];
        s.profile.yaw_rates_rad_s = vec![0.0, 0.0, 0.0, 0.3];
        s.formation.start_s = 1.0;
        s.links.protocol = Protocol::Periodic;
        s.duration_s = 20.0;
    });
    // From 5 s on the front robot drives a circle of radius 1 m; the others must be on the same circle.
    let poses: Vec<[f64; 3]> = reports
        .plant
        .robots
        .iter()
        .map(|robot| robot.final_true)
        .collect();
    let d = 0.055;
    let centre = |[x, y, yaw]: [f64; 3]| {
        let (sin, cos) = yaw.sin_cos();
        [x - d * cos - sin, y - d * sin + cos]
    };
    let [cx, cy] = centre(poses[0]);
    for [x, y, yaw] in &poses[1..] {
        let radius = (x - d * yaw.cos() - cx).hypot(y - d * yaw.sin() - cy);
        assert!((radius - 1.0).abs() < 0.03, "{radius} {poses:?}");
    }
    for robot in &reports.plant.robots[1..] {
        assert!(robot.max_spacing_error_m.unwrap() < 0.06, "{robot:?}");
    }
}

/// Section 3: at 0.13 N m the wheels slip and the odometry runs ahead; limited by Eq. 11 it agrees with the
/// true position.
#[test]
fn the_limit_keeps_odometry_and_truth_together() {
    let gap_m = |limit| {
        let experiment = experiment(Settings::single(), |s| s.control.torque_limit = limit);
        let reports = run(&experiment, false).unwrap();
        assert!((reports.plant.duration_s - 2.0).abs() < 1e-12);
        let [odometry_m, true_m] = [
            reports.agents[0].final_odometry[0],
            reports.plant.robots[0].final_true[0],
        ];
        assert!(true_m > 0.5);
        (odometry_m - true_m, slip_s(&reports))
    };
    let (free, slip) = gap_m(TorqueLimit::None);
    assert!(free > 0.05 && slip > 0.5, "{free} {slip}");
    let (limited, slip) = gap_m(TorqueLimit::Inner);
    assert!(limited.abs() < 1e-3 && slip == 0.0, "{limited} {slip}");
}

fn records(change: impl Fn(&mut Settings)) -> Vec<Record> {
    run_recorded(&experiment(Settings::default(), change), false, Vec::new())
        .unwrap()
        .1
}

/// Section 4: a robot sends after it has received. With a delay of two outer ticks, one token round of three
/// robots takes six ticks.
#[test]
fn ring_messages_are_sent_in_order() {
    let records = records(|s| {
        s.links.delay_s = 0.1;
        s.duration_s = 2.0;
    });
    let sent: Vec<(u32, i64)> = records
        .iter()
        .filter_map(|record| match record {
            Record::Sent { position, .. } => Some((position.from, position.sent_ns / 1_000_000)),
            _ => None,
        })
        .collect();
    let expected: Vec<(u32, i64)> = (0..20).map(|k| (k % 3, i64::from(k) * 100)).collect();
    assert_eq!(sent, expected);
}

/// A ring whose message is lost is restarted by timeout.
#[test]
fn a_ring_with_a_lost_message_is_restarted() {
    let records = records(|s| {
        s.links.loss = 0.3;
        s.duration_s = 10.0;
    });
    let restarts = records.iter().filter(|record| {
        matches!(
            record,
            Record::Event {
                kind: EventKind::RingRestarted,
                ..
            }
        )
    });
    assert!(restarts.count() > 3);
    // At most one message is in flight even after restarts, so that no message is ever stale.
    let stale = |record: &&Record| {
        matches!(
            record,
            Record::Taken {
                fate: Fate::Stale,
                ..
            }
        )
    };
    assert_eq!(records.iter().filter(stale).count(), 0);
}

/// Without new positions the watchdog brakes a follower to a stop.
#[test]
fn the_watchdog_stops_a_follower_without_positions() {
    let records = records(|s| {
        s.links.protocol = Protocol::Periodic;
        s.links.loss = 0.999_999;
        s.robots.count = 2;
        s.control.torque_limit = TorqueLimit::Inner;
    });
    let fired = records.iter().find_map(|record| match record {
        Record::Event {
            t_ns,
            kind: EventKind::WatchdogFired,
            ..
        } => Some(*t_ns),
        _ => None,
    });
    let fired_ns = fired.unwrap();
    assert!(
        (4_000_000_000..4_300_000_000).contains(&fired_ns),
        "{fired_ns}"
    );
    let last = records.iter().rev().find_map(|record| match record {
        Record::State(state) if state.robot == 1 => Some(*state),
        _ => None,
    });
    assert!(last.unwrap().velocity[0].abs() < 0.01, "{last:?}");
}
