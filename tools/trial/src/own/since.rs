//! A change that begins within a recording.

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Robot, Wheels};
use slipstream_recording::{Recording, joined};

use super::change::Change;
use super::rows::keep_all_rows;

/// The recording with a change in the rows of its robots from `since_s` on; what is counted runs on.
pub fn changed_since(
    recording: &Recording,
    model: &RobotModel,
    change: &Change,
    since_s: f64,
) -> Recording {
    let [mut before, mut after] = [recording.clone(), recording.clone()];
    for robot in &mut before.robots {
        keep_all_rows(robot, robot_times(robot), &|t_s| t_s < since_s);
    }
    for (robot, own) in after.robots.iter_mut().zip(&recording.robots) {
        change.apply(robot, model);
        run_on(robot, own, since_s);
        keep_all_rows(robot, robot_times(own), &|t_s| t_s >= since_s);
    }
    let links = recording.links.clone();
    let whole = joined([before, after].iter(), f64::NEG_INFINITY).unwrap_or_default();
    Recording { links, ..whole }
}

/// The times of each stream of a robot before anything moved them.
type StreamTimes = [Vec<f64>; 6];

fn robot_times(robot: &Robot) -> StreamTimes {
    let of = |own: Option<&Vec<f64>>| own.cloned().unwrap_or_default();
    [
        of(robot.command.as_ref().map(|own| &own.t_s)),
        of(robot.wheels.as_ref().map(|own| &own.t_s)),
        of(robot.odometry.as_ref().map(|own| &own.t_s)),
        of(robot.pose.as_ref().map(|own| &own.t_s)),
        of(robot.imu.as_ref().map(|own| &own.t_s)),
        of(robot.motor.as_ref().map(|own| &own.t_s)),
    ]
}

/// Counts and angles go on from where they were at the begin of the change.
fn run_on(robot: &mut Robot, own: &Robot, since_s: f64) {
    let (Some(wheels), Some(own)) = (robot.wheels.as_mut(), own.wheels.as_ref()) else {
        return;
    };
    let row = own
        .t_s
        .partition_point(|t_s| *t_s < since_s)
        .saturating_sub(1);
    match (&mut wheels.values, &own.values) {
        (Wheels::Ticks { right, left }, Wheels::Ticks { right: a, left: b }) => {
            for (column, own) in [(right, a), (left, b)] {
                if let (Some(Some(now)), Some(Some(was))) = (column.get(row).copied(), own.get(row))
                {
                    let by = was - now;
                    column.iter_mut().flatten().for_each(|own| *own += by);
                }
            }
        }
        (
            Wheels::Angle {
                right_rad,
                left_rad,
            },
            Wheels::Angle {
                right_rad: a,
                left_rad: b,
            },
        ) => {
            for (column, own) in [(right_rad, a), (left_rad, b)] {
                let (Some(now), Some(was)) = (column.get(row).copied(), own.get(row)) else {
                    continue;
                };
                column.iter_mut().for_each(|own| *own += was - now);
            }
        }
        _ => (),
    }
}

#[cfg(test)]
mod tests {
    use slipstream_recording::recording::{Command, Stream};

    use super::*;

    #[test]
    fn counts_run_on_and_only_later_rows_change() {
        let mut robot = Robot::named("r1");
        robot.wheels = Some(Stream {
            t_s: (0..10).map(f64::from).collect(),
            values: Wheels::Ticks {
                right: (0..10).map(|k| Some(100 * k)).collect(),
                left: (0..10).map(|k| Some(100 * k)).collect(),
            },
            unknown: Vec::new(),
        });
        let recording = Recording {
            robots: vec![robot],
            ..Recording::default()
        };
        let change = Change::Counts([1.5, 1.0]);
        let own = changed_since(&recording, &RobotModel::default(), &change, 4.5);
        let Some(Wheels::Ticks { right, left }) =
            own.robots[0].wheels.as_ref().map(|own| own.values.clone())
        else {
            panic!("no wheels")
        };
        let counts = |own: &[Option<i64>]| own.iter().flatten().copied().collect::<Vec<i64>>();
        assert_eq!(
            counts(&right),
            [0, 100, 200, 300, 400, 550, 700, 850, 1000, 1150]
        );
        assert_eq!(
            counts(&left),
            (0..10).map(|k| 100 * k).collect::<Vec<i64>>()
        );
    }

    #[test]
    fn commands_act_later_from_then_on() {
        let mut robot = Robot::named("r1");
        robot.command = Some(Stream {
            t_s: (0..10).map(f64::from).collect(),
            values: Command::Twist {
                v_m_s: (0..10).map(f64::from).collect(),
                w_rad_s: vec![0.0; 10],
            },
            unknown: Vec::new(),
        });
        let recording = Recording {
            robots: vec![robot],
            ..Recording::default()
        };
        let change = Change::CommandLate(0.25);
        let own = changed_since(&recording, &RobotModel::default(), &change, 4.5);
        let times_s = &own.robots[0].command.as_ref().unwrap().t_s;
        assert_eq!(
            times_s[..],
            [0.0, 1.0, 2.0, 3.0, 4.0, 4.75, 5.75, 6.75, 7.75, 8.75]
        );
    }
}
