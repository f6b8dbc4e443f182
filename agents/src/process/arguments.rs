//! What the launcher starts the program of an agent with.

use std::ffi::OsString;
use std::path::PathBuf;

use slipstream_bus::message::RobotIndex;
use slipstream_ipc::part::{Membership, PROTOCOL};
use slipstream_ipc::presence::Parent;

/// First of the arguments with which the launcher starts the program of an agent.
pub const ROLE: &str = "agent";

/// What the program of an agent is to do, and for which robot.
#[derive(Debug, Clone)]
pub struct Arguments {
    /// The robot.
    pub robot: RobotIndex,
    /// [`PROTOCOL`] of the launcher.
    pub protocol: String,
    /// What to do.
    pub task: Task,
}

/// What the program of an agent is to do.
#[derive(Debug, Clone)]
pub enum Task {
    /// Take part in a run.
    Run {
        /// What every process of a run is started with.
        membership: Membership,
        /// It replaces an agent that died.
        rejoins: bool,
    },
    /// Write into this folder what parameters the controller has.
    Describe(PathBuf),
}

impl Arguments {
    /// The arguments with which a launcher of this version starts a program: for a run in `run`, or, without a
    /// launcher, to describe its controller into `run`.
    pub fn to_start(
        run: &std::path::Path,
        robot: RobotIndex,
        launcher: Option<u32>,
    ) -> Vec<OsString> {
        let task = if launcher.is_some() {
            "--run"
        } else {
            "--describe"
        };
        let mut all: Vec<OsString> = [ROLE, "--protocol", PROTOCOL, "--robot"]
            .map(OsString::from)
            .into();
        all.push(robot.to_string().into());
        all.push(task.into());
        all.push(run.into());
        if let Some(launcher) = launcher {
            all.push("--launcher".into());
            all.push(launcher.to_string().into());
        }
        all
    }

    /// Finds the launcher's arguments among those of the program; `None` if no launcher has started it.
    pub fn find(arguments: &[OsString]) -> Option<Self> {
        let begins = |pair: &[OsString]| pair[0] == ROLE && pair[1] == "--protocol";
        let begin = arguments.windows(2).position(begins)?;
        let mut rest = arguments.get(begin + 1..)?.iter();
        let [mut protocol, mut robot, mut run, mut describe, mut launcher] = [const { None }; 5];
        let [mut rejoins, mut recording, mut trace] = [false; 3];
        while let Some(name) = rest.next() {
            let (value, flag) = match name.to_str()? {
                "--protocol" => (&mut protocol, None),
                "--robot" => (&mut robot, None),
                "--run" => (&mut run, None),
                "--describe" => (&mut describe, None),
                "--launcher" => (&mut launcher, None),
                "--rejoins" => (&mut None, Some(&mut rejoins)),
                "--recording" => (&mut None, Some(&mut recording)),
                "--trace" => (&mut None, Some(&mut trace)),
                // Another version knows more.
                _ => (&mut None, None),
            };
            match flag {
                Some(flag) => *flag = true,
                None => *value = rest.next().cloned(),
            }
        }
        let text = |value: Option<OsString>| value.and_then(|own| own.into_string().ok());
        let task = match describe {
            Some(folder) => Task::Describe(folder.into()),
            None => Task::Run {
                membership: Membership {
                    run: run?.into(),
                    launcher: Parent::or_ancestor(text(launcher)?.parse().ok()?),
                    recording,
                    trace,
                },
                rejoins,
            },
        };
        Some(Self {
            robot: text(robot)?.parse().ok()?,
            protocol: text(protocol)?,
            task,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_launchers_arguments_are_found_behind_those_of_the_program() {
        let mut all: Vec<OsString> = ["python3", "a.py", "agent", "--fast"]
            .map(OsString::from)
            .into();
        assert!(Arguments::find(&all).is_none());
        all.extend(Arguments::to_start(Path::new("/run"), 3, Some(7)));
        all.push("--recording".into());
        let found = Arguments::find(&all).unwrap();
        assert_eq!((found.robot, found.protocol.as_str()), (3, PROTOCOL));
        let Task::Run {
            membership,
            rejoins,
        } = found.task
        else {
            panic!("{:?}", found.task);
        };
        assert_eq!(membership.run, Path::new("/run"));
        assert!(membership.recording && !membership.trace && !rejoins);
    }
}
