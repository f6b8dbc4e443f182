//! Lockstep co-simulation on virtual time: the plant advances to the next instant at which a
//! control loop is due, exchanges measurements and torques with the agents, and goes on. No wall
//! clock.

use slipstream_bus::Experiment;
use slipstream_bus::experiment::Drive;
use slipstream_bus::message::{Actuation, DriveCommand, Encoders};
use slipstream_bus::record::{Record, Recorder};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::transport::{BusError, LockstepLink};

use super::changes::Changes;
use super::observer::Observer;
use crate::{Command, World};

/// Observer of the progress of a run. `()` ignores it.
pub trait Progress {
    /// Called after every round of the agents, at true time `now_ns` (ns).
    fn at(&mut self, now_ns: i64, world: &World, observer: &Observer);

    /// Called after every step of the plant.
    fn stepped(&mut self) {}
}

impl Progress for () {
    fn at(&mut self, _: i64, _: &World, _: &Observer) {}
}

/// Runs `world` from the start to the end of `experiment`, exchanging messages with the agents over
/// `link` and writing applied commands and sensor samples to `recorder`.
///
/// # Errors
/// When an agent does not answer, the run is stopped, or a robot's state is no number any more.
/// World and observer then hold the state reached.
pub fn lockstep(
    experiment: &Experiment,
    world: &mut World,
    observer: &mut Observer,
    link: &mut impl LockstepLink,
    recorder: &mut impl Recorder,
    progress: &mut impl Progress,
) -> Result<(), BusError> {
    let settings = &experiment.settings;
    let schedule = settings.schedule();
    let end_ns = ns_from_s(settings.duration_s);
    let step_ns = ns_from_s(settings.plant.step_s);
    let robots = experiment.robots.len();
    let mut encoders = vec![Encoders::default(); robots];
    let mut told = vec![DriveCommand::default(); robots];
    let mut commands = vec![no_command(settings.control.drive); robots];
    let mut changes = changes(experiment)?;
    let mut now_ns = 0;
    while now_ns < end_ns {
        if schedule.due(now_ns).any() {
            read_encoders(world, now_ns, &mut encoders);
            link.round(now_ns, &encoders, &mut told)?;
            for (acting, told) in commands.iter_mut().zip(&told) {
                *acting = command(&told.actuation);
                if told.tick_ns == now_ns {
                    recorder.record(&applied(now_ns, now_ns, told));
                }
            }
            progress.at(now_ns, world, observer);
            require_finite(experiment, world)?;
        }
        let grid_ns = (now_ns / step_ns + 1) * step_ns;
        let next_ns = grid_ns.min(schedule.next_after(now_ns)).min(end_ns);
        changes.apply(world);
        world.step(next_ns - now_ns, &commands);
        observer.step(world, next_ns - now_ns, recorder);
        record_sensors(world, robots, recorder);
        progress.stepped();
        now_ns = next_ns;
    }
    require_finite(experiment, world)?;
    read_encoders(world, now_ns, &mut encoders);
    link.publish_final(now_ns, &encoders)
}

/// What begins within the run.
pub(super) fn changes(experiment: &Experiment) -> Result<Changes, BusError> {
    Changes::new(experiment).map_err(|error| BusError::Failed {
        what: "plant".to_owned(),
        reason: error.to_string(),
    })
}

/// Ends a run whose numbers mean nothing any more.
pub(super) fn require_finite(experiment: &Experiment, world: &World) -> Result<(), BusError> {
    world.first_not_finite().map_or(Ok(()), |robot| {
        Err(BusError::Failed {
            what: experiment.robots[robot].name.clone(),
            reason: format!(
                "its state is no finite number any more at {} s; give a smaller plant.step_s, or \
                 less extreme values of its model and its control",
                s_from_ns(world.time_ns())
            ),
        })
    })
}

/// Reads the encoders of all robots at `now_ns`.
pub(super) fn read_encoders(world: &World, now_ns: i64, encoders: &mut [Encoders]) {
    for (i, reading) in encoders.iter_mut().enumerate() {
        *reading = Encoders {
            sampled_ns: now_ns,
            counts: world.encoder_counts(i),
        };
    }
}

/// What drives are told, as a command of the plant.
pub(super) fn command(actuation: &Actuation) -> Command {
    match *actuation {
        Actuation::Torque([right_nm, left_nm]) => Command::Torque { right_nm, left_nm },
        Actuation::Twist([v_m_s, w_rad_s]) => Command::Twist { v_m_s, w_rad_s },
    }
}

/// The command of drives that nobody tells anything: no torque, or standstill.
pub(super) fn no_command(drive: Drive) -> Command {
    command(&match drive {
        Drive::Torque => Actuation::Torque([0.0; 2]),
        Drive::Twist => Actuation::Twist([0.0; 2]),
    })
}

/// Record of a command that acts from `t_ns` on and was received at `taken_ns`.
pub(super) fn applied(t_ns: i64, taken_ns: i64, command: &DriveCommand) -> Record {
    Record::Applied {
        t_ns,
        taken_ns,
        robot: command.robot,
        tick_ns: command.tick_ns,
        actuation: command.actuation,
    }
}

/// Records what cameras and inertial sensors measure after a step.
pub(super) fn record_sensors(world: &mut World, robots: usize, recorder: &mut impl Recorder) {
    for (i, robot) in (0..robots).zip(0..) {
        if let Some(sample) = world.camera(i) {
            recorder.record(&Record::Camera {
                t_ns: sample.stamp_ns,
                robot,
                pose: sample.value,
            });
        }
        if let Some(sample) = world.imu(i) {
            let [ax, ay, yaw_rate_rad_s] = sample.value;
            let acceleration_m_s2 = [ax, ay];
            let t_ns = sample.stamp_ns;
            recorder.record(&Record::Imu {
                t_ns,
                robot,
                acceleration_m_s2,
                yaw_rate_rad_s,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::record::NoRecorder;
    use slipstream_bus::{RobotModel, Settings};

    use super::*;
    use crate::run::world;

    /// Agents that command the same torque in every round (N m).
    struct Constant(f64);

    impl LockstepLink for Constant {
        fn round(
            &mut self,
            _: i64,
            _: &[Encoders],
            commands: &mut [DriveCommand],
        ) -> Result<(), BusError> {
            commands
                .iter_mut()
                .for_each(|command| command.actuation = Actuation::Torque([self.0; 2]));
            Ok(())
        }

        fn publish_final(&mut self, _: i64, _: &[Encoders]) -> Result<(), BusError> {
            Ok(())
        }
    }

    fn run(torque_nm: f64, duration_s: f64) -> Result<(), BusError> {
        let mut settings = Settings::single();
        settings.duration_s = duration_s;
        let experiment = Experiment::new(settings, &RobotModel::default());
        let mut world = world(&experiment).unwrap();
        let mut observer = Observer::new(&experiment, false);
        let link = &mut Constant(torque_nm);
        let recorder = &mut NoRecorder;
        lockstep(
            &experiment,
            &mut world,
            &mut observer,
            link,
            recorder,
            &mut (),
        )
    }

    #[test]
    fn a_state_that_is_no_number_ends_the_run_with_a_sentence() {
        assert_eq!(run(0.1, 1.0), Ok(()));
        // At the next round, or at the end of a run that has no other.
        for (duration_s, at) in [(1.0, "0.02 s"), (0.01, "0.01 s")] {
            let error = run(f64::NAN, duration_s).unwrap_err().to_string();
            let expected = format!("r1: its state is no finite number any more at {at}; ");
            assert!(error.starts_with(&expected), "{error}");
        }
    }
}
