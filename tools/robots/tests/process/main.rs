//! Robots in boxes, the process that stands before them, and real agents: all that a run of real robots has but the
//! network, which is a set of channels here.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod run;

use std::time::Duration;

use slipstream_agents::{
    AgentContext, BuiltIn, Controller, ControllerError, DesiredTwist, OuterInput,
};
use slipstream_bus::experiment::OnDeath;
use slipstream_bus::transport::BusError;
use slipstream_ipc::join::ProcessStatus;

use run::{Drive, LIMITS, Net, TORQUE_NM, drive, experiment, experiment_by_torques};

/// How much later than it has to a robot may stand here: the machine may be busy.
const BUSY_S: f64 = 1.0;

fn built_in(context: &AgentContext<'_>) -> Result<Box<dyn Controller>, ControllerError> {
    Ok(Box::new(BuiltIn::new(context)?))
}

/// Desires what no robot can do, and from a time on what is no number.
struct Wild {
    nan_from_s: f64,
}

impl Controller for Wild {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let v = if now.t_s < self.nan_from_s {
            9.0
        } else {
            f64::NAN
        };
        let w = if (now.t_s * 4.0) as i64 % 2 == 0 {
            50.0
        } else {
            -50.0
        };
        Ok(DesiredTwist { v, w })
    }
}

#[test]
fn a_platoon_of_boxes_drives_and_stands_at_the_end() {
    let driven = drive(Drive {
        experiment: experiment(2, 2.5, OnDeath::Stop),
        make: &built_in,
        meanwhile: &|_| (),
        silent: None,
    });
    let outcome = driven.outcome.unwrap();
    assert_eq!(outcome.ended, ProcessStatus::Done);
    for (report, seen) in outcome.robots.iter().zip(&driven.boxes) {
        assert!(
            report.commands > 40 && report.wheels.messages > 80,
            "{report:?}"
        );
        assert_eq!((report.stops, report.jumps, &report.problem), (0, 0, &None));
        assert!(
            seen.largest[0] > 0.1 && seen.largest[0] <= LIMITS.speed_m_s,
            "{seen:?}"
        );
    }
    // 0.2 m/s for about two seconds, from 0.6096 m on.
    let driven_m = driven.boxes[0].final_pose[0] - 0.6096;
    assert!((0.2..0.6).contains(&driven_m), "{driven_m}");
    assert!(
        driven.last_moved_s.iter().all(|own| *own < 2.5 + BUSY_S),
        "{:?}",
        driven.last_moved_s
    );
}

#[test]
fn robots_that_take_torques_drive_by_the_inner_loop() {
    let driven = drive(Drive {
        experiment: experiment_by_torques(2, 2.5),
        make: &built_in,
        meanwhile: &|_| (),
        silent: None,
    });
    let outcome = driven.outcome.unwrap();
    assert_eq!(outcome.ended, ProcessStatus::Done);
    for (report, seen) in outcome.robots.iter().zip(&driven.boxes) {
        // The inner loop is faster than the outer one.
        assert!(report.commands > 80, "{report:?}");
        assert!(
            report.odometry.messages > 80 && report.imu.messages > 150,
            "{report:?}"
        );
        assert!(
            seen.largest.iter().all(|nm| *nm > 0.0 && *nm <= TORQUE_NM),
            "{seen:?}"
        );
    }
    // As above, and it rolls on without torque until the box ends.
    let driven_m = driven.boxes[0].final_pose[0] - 0.6096;
    assert!((0.2..0.9).contains(&driven_m), "{driven_m}");
}

#[test]
fn a_robot_that_takes_torques_and_is_too_fast_ends_the_run() {
    let mut experiment = experiment_by_torques(1, 2.5);
    // Its own speed loop thinks that it has to be faster than the robot may be.
    experiment.settings.control.limits = slipstream_bus::TwistLimits::NONE;
    let driven = drive(Drive {
        experiment,
        make: &|_| Ok(Box::new(Wild { nan_from_s: 9.0 }) as Box<dyn Controller>),
        meanwhile: &|_| (),
        silent: None,
    });
    let ended = driven.outcome.unwrap().ended;
    let expected =
        "r1: its wheels were faster than its limits allow; all robots were told to stand";
    assert_eq!(ended, ProcessStatus::Failed(expected.to_owned()));
    assert!(driven.boxes[0].largest.iter().all(|nm| *nm <= TORQUE_NM));
}

#[test]
fn no_command_is_beyond_the_limits_whatever_an_agent_wants() {
    let driven = drive(Drive {
        experiment: experiment(1, 2.0, OnDeath::Stop),
        make: &|_| Ok(Box::new(Wild { nan_from_s: 1.0 }) as Box<dyn Controller>),
        meanwhile: &|_| (),
        silent: None,
    });
    let [seen] = &driven.boxes[..] else { panic!() };
    assert!(seen.commands > 10);
    assert!(
        seen.largest[0] <= LIMITS.speed_m_s && seen.largest[1] <= LIMITS.yaw_rate_rad_s,
        "{seen:?}"
    );
    // Commands that come together may be two periods apart.
    assert!(
        seen.largest_step[0] <= 2.0 * 0.05 * LIMITS.acceleration_m_s2 + 1e-9,
        "{seen:?}"
    );
    assert!(
        driven.agents[0]
            .as_ref()
            .is_err_and(|problem| problem.contains("NaN")),
        "{:?}",
        driven.agents
    );
    assert!(
        driven.last_moved_s[0] < 1.0 + BUSY_S,
        "{:?}",
        driven.last_moved_s
    );
}

#[test]
fn a_robot_that_is_not_heard_ends_the_run_or_stands_alone() {
    for on_death in [OnDeath::Stop, OnDeath::Continue] {
        let driven = drive(Drive {
            experiment: experiment(2, 2.5, on_death),
            make: &built_in,
            meanwhile: &|net: &Net| {
                net.await_time(1.0);
                net.mute(1);
            },
            silent: None,
        });
        let outcome = driven.outcome.unwrap();
        let ended = &outcome.ended;
        let watchdog_s = 0.3;
        assert!(
            driven.last_moved_s[1] < 1.0 + watchdog_s + BUSY_S,
            "{:?}",
            driven.last_moved_s
        );
        match on_death {
            OnDeath::Stop => {
                let expected = "r2: nothing came from /tb2/joint_states for 0.3 s; all robots were told to stand";
                assert_eq!(*ended, ProcessStatus::Failed(expected.to_owned()));
            }
            _ => {
                assert_eq!(*ended, ProcessStatus::Done);
                assert_eq!(outcome.robots[1].stops, 1);
                assert!(driven.last_moved_s[0] > 2.0, "{:?}", driven.last_moved_s);
            }
        }
    }
}

#[test]
fn a_cut_link_leaves_no_robot_moving_and_no_jump_after_it() {
    let driven = drive(Drive {
        experiment: experiment(2, 3.5, OnDeath::Continue),
        make: &built_in,
        meanwhile: &|net: &Net| {
            net.await_time(0.8);
            net.cut(0, true);
            std::thread::sleep(Duration::from_millis(900));
            net.cut(0, false);
        },
        silent: None,
    });
    let outcome = driven.outcome.unwrap();
    assert_eq!(outcome.ended, ProcessStatus::Done);
    let report = &outcome.robots[0];
    assert_eq!(report.stops, 1, "{report:?}");
    let seen = &driven.boxes[0];
    assert!(
        seen.largest_step[0] <= 2.0 * 0.05 * LIMITS.acceleration_m_s2 + 1e-9,
        "{seen:?}"
    );
    assert!(
        driven.last_moved_s[0] > 2.0,
        "it drives again: {:?}",
        driven.last_moved_s
    );
}

#[test]
fn nothing_is_told_to_any_robot_while_one_is_not_heard() {
    let driven = drive(Drive {
        experiment: experiment(2, 1.0, OnDeath::Stop),
        make: &built_in,
        meanwhile: &|net: &Net| net.stop_run_after(Duration::from_secs(1)),
        silent: Some(1),
    });
    assert!(matches!(driven.outcome, Err(BusError::Stopped)));
    assert!(
        driven.boxes.iter().all(|seen| seen.commands == 0),
        "{:?}",
        driven.boxes
    );
}
