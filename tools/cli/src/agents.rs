//! Programs of agents on the command line: `--agent NAME=PROGRAM`, or `--agent PROGRAM` for all robots.

use slipstream_launch::Program;

/// Name of the robot, or `*`, and command of each argument.
pub(crate) fn named(arguments: &[String]) -> Vec<(String, String)> {
    let pair = |argument: &String| {
        let (name, command) = Program::named(argument);
        (name.to_owned(), command.to_owned())
    };
    arguments.iter().map(pair).collect()
}
