//! Program of an agent in place of the built-in controller: how it is started.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use slipstream_bus::message::RobotIndex;

/// Programs of agents, by robot.
pub type Programs = BTreeMap<RobotIndex, Program>;

/// The program of an agent.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Program {
    /// A command of the shell, to which the launcher adds its arguments.
    pub command: String,
    /// Where it is started: the folder of the file that names it, or the current one.
    pub folder: PathBuf,
}

impl Program {
    /// Name and command of `[NAME=]PROGRAM`; without a name, for all robots.
    ///
    /// A program may contain `=` itself, so only a name of a robot or `*` counts as one.
    pub fn named(argument: &str) -> (&str, &str) {
        let is_robot = |name: &str| {
            let number = name.strip_prefix('r').unwrap_or_default();
            !number.is_empty() && number.bytes().all(|own| own.is_ascii_digit())
        };
        match argument.split_once('=') {
            Some((name, program)) if name == "*" || is_robot(name) => (name, program),
            _ => ("*", argument),
        }
    }

    /// The command, before its arguments. The shell is replaced by the program, so that both have one process id.
    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new("sh");
        command
            .arg("-c")
            .arg(format!("exec {} \"$@\"", self.command))
            .arg("sh");
        if !self.folder.as_os_str().is_empty() {
            command.current_dir(&self.folder);
        }
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_robots_and_the_star_are_names() {
        assert_eq!(Program::named("r2=./a --b=c"), ("r2", "./a --b=c"));
        assert_eq!(Program::named("*=./a"), ("*", "./a"));
        assert_eq!(Program::named("A=1 ./a"), ("*", "A=1 ./a"));
        assert_eq!(Program::named("./a"), ("*", "./a"));
        assert_eq!(Program::named("r=./a"), ("*", "r=./a"));
    }
}
