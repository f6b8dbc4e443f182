//! Which experiment a command runs: its name or file, how many robots, their models and their programs.

use std::path::PathBuf;

use slipstream_launch::{Program, Request};

/// Arguments that all commands which run an experiment share.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Subject {
    /// Built-in experiment (platoon, single, circle, figure_eight, lane_change), a TOML file, or a recording (MCAP), whose
    /// experiment is simulated with the models of its robots [default: platoon]
    experiment: Option<String>,
    /// Number of robots [default: the experiment's]
    #[arg(long, value_name = "N")]
    robots: Option<u32>,
    /// Robot model for all robots, or for the robot NAME: robot.toml, URDF or controller YAML; several of one robot fill
    /// what the others lack [default: the experiment's]
    #[arg(long = "robot", value_name = "[NAME=]FILE")]
    models: Vec<String>,
    /// Program that controls the robot NAME, or all robots, in place of the built-in controller
    #[arg(long = "agent", value_name = "[NAME=]PROGRAM")]
    agents: Vec<String>,
}

impl Subject {
    /// The experiment as the user named it.
    pub(crate) fn name(&self) -> &str {
        self.experiment.as_deref().unwrap_or("platoon")
    }

    /// The request for this experiment.
    pub(crate) fn request(&self) -> Request {
        Request {
            experiment: self.experiment.clone(),
            robots: self.robots,
            models: self.models.iter().map(|own| named_file(own)).collect(),
            agents: named_programs(&self.agents),
            ..Request::default()
        }
    }
}

/// Name and file of an argument `[NAME=]FILE`.
pub(crate) fn named_file(argument: &str) -> (Option<String>, PathBuf) {
    match argument.split_once('=') {
        Some((name, file)) => (Some(name.to_owned()), PathBuf::from(file)),
        None => (None, PathBuf::from(argument)),
    }
}

/// Name of the robot, or `*`, and command of each argument `[NAME=]PROGRAM`.
pub(crate) fn named_programs(arguments: &[String]) -> Vec<(String, String)> {
    let pair = |argument: &String| {
        let (name, command) = Program::named(argument);
        (name.to_owned(), command.to_owned())
    };
    arguments.iter().map(pair).collect()
}
