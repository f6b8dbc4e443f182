//! The program of an agent, from its arguments to its exit code.

use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

use slipstream_bus::message::robot_name;
use slipstream_bus::transport::BusError;
use slipstream_ipc::part::{self, PROTOCOL};
use slipstream_ipc::report;

use super::agent_process;
use super::arguments::{Arguments, Task};
use super::describe::{self, Description};
use super::panics;
use crate::controller::{AgentContext, Controller, ControllerError};

/// Exit code of a program that was not started by a launcher, or by one of another version.
const UNUSABLE: u8 = 2;

/// Runs the agent that the arguments of this program name, with the controller that `make` makes: the whole `main` of a
/// program for `slipstream run --agent NAME=PROGRAM`.
///
/// ```no_run
/// use std::process::ExitCode;
///
/// use slipstream_agents::process::run_agent;
/// use slipstream_agents::{Controller, ControllerError, DesiredTwist, OuterInput};
///
/// struct Slow;
///
/// impl Controller for Slow {
///     fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
///         let [v, w] = now.reference_velocity;
///         Ok(DesiredTwist { v: v + now.error[0], w })
///     }
/// }
///
/// fn main() -> ExitCode {
///     run_agent(|_| Ok(Slow))
/// }
/// ```
pub fn run_agent<C: Controller>(
    make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    ExitCode::from(run_agent_with(&arguments, make))
}

/// As [`run_agent`], with the arguments of the program; returns its exit code.
pub fn run_agent_with<C: Controller>(
    arguments: &[OsString],
    make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> u8 {
    let Some(arguments) = Arguments::find(arguments) else {
        say("this is the program of an agent: start it with slipstream run --agent r2=PROGRAM");
        return UNUSABLE;
    };
    let robot = arguments.robot;
    let is_other = arguments.protocol != PROTOCOL;
    let other = || {
        let theirs = &arguments.protocol;
        format!(
            "its program is of another version of slipstream ({PROTOCOL}, the launcher is {theirs}): build it anew"
        )
    };
    match &arguments.task {
        Task::Describe(folder) => {
            let described = match is_other {
                true => Err(other().into()),
                false => panics::catch(|| describe::describe(folder, robot, make))
                    .unwrap_or_else(|said| Err(said.into())),
            };
            match describe::write(folder, &Description::new(described)) {
                Ok(()) => 0,
                Err(error) => {
                    say(&format!("{}: {error}", folder.display()));
                    1
                }
            }
        }
        Task::Run { membership, .. } if is_other => {
            part::leave_problem(membership, &robot_name(robot), &other());
            UNUSABLE
        }
        Task::Run {
            membership,
            rejoins,
        } => {
            let name = robot_name(robot);
            let work = || {
                let outcome = agent_process::run(membership, robot, *rejoins, make)?;
                report::write(&membership.run, &name, &outcome)
            };
            let caught = || match panics::catch(work) {
                Ok(done) => done,
                Err(said) => Err(BusError::Panicked(said)),
            };
            u8::from(!part::play(membership, &name, caught))
        }
    }
}

/// Says something to who started the program. Standard error may be closed.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "slipstream: {text}");
}
