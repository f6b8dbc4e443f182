//! Resolution of an experiment: a built-in one, a file over it, command-line arguments over both.

use std::path::Path;

use slipstream_bus::experiment::{Clock, EVERY_ROBOT};
use slipstream_bus::message::robot_name;
use slipstream_bus::{Experiment, InputError, Settings};
use slipstream_robots::lab::Lab;
use toml::Value;

use super::key_tree::{BUILT_IN, KeyTree};
use super::request::{Origin, Request, Resolved};
use super::robots::{check, robots};
use super::{keys, lab, recorded, round_trips};
use crate::program::{Program, Programs};

/// Resolves a request: a built-in experiment, a file over it, arguments over both.
///
/// # Errors
/// A key, value or file that cannot be used.
pub fn resolve(request: &Request) -> Result<Resolved, InputError> {
    let (mut tree, recorded) = base(request.experiment.as_deref())?;
    let mut lab = request.real.as_deref().map(Lab::read).transpose()?;
    // The rear robots of a lab stay where they are if fewer are to drive.
    if let (Some(lab), Some(robots)) = (&mut lab, request.robots) {
        lab.robots.truncate(robots as usize);
    }
    let models = match &lab {
        Some(lab) => {
            lab::set_keys(lab, &mut tree)?;
            lab::models(lab, &request.models)
        }
        None => request.models.clone(),
    };
    for (key, value) in &request.set {
        let argument = Origin::Argument(format!("--set {key}={value}"));
        tree.set(key, keys::parse_value(value), &argument)?;
    }
    for (name, program) in &request.agents {
        let argument = Origin::Argument(format!("--agent {name}={program}"));
        let key = format!("agents.{name}");
        tree.set(&key, Value::String(program.clone()), &argument)?;
    }
    if let Some(robots) = request.robots {
        let argument = Origin::Argument(format!("--robots {robots}"));
        tree.set("robots.count", Value::Integer(robots.into()), &argument)?;
    }
    if let Some(seed) = request.seed {
        let argument = Origin::Argument(format!("--seed {seed}"));
        let seed = i64::try_from(seed).map_err(|_| {
            InputError::new(
                "--seed",
                format!("is {seed}"),
                format!("give at most {}", i64::MAX),
            )
        })?;
        tree.set("seed", Value::Integer(seed), &argument)?;
    }
    if let Some(clock) = request.clock {
        let name = if clock == Clock::Wall {
            "wall"
        } else {
            "virtual"
        };
        let argument = Origin::Argument(format!("--clock {name}"));
        tree.set("clock", Value::String(name.to_owned()), &argument)?;
    }
    for (_, path) in request.models.iter().filter(|(name, _)| name.is_none()) {
        let argument = Origin::Argument(format!("--robot {}", path.display()));
        tree.set(
            "robots.model",
            Value::String(path.display().to_string()),
            &argument,
        )?;
    }
    let settings = tree.settings()?;
    settings.validate().map_err(|error| located(&tree, error))?;
    let mut experiment = Experiment {
        robots: robots(&settings, &tree, &models, &recorded)?,
        half_round_trips_ns: match settings.links.trace.as_str() {
            "" => Vec::new(),
            trace => round_trips::read(&tree.path("links.trace", trace))?,
        },
        settings,
    };
    if let Some(lab) = &mut lab {
        lab::apply(lab, &mut experiment)?;
    }
    check(&experiment, &models)?;
    let began = slipstream_sim::run::Changes::new(&experiment);
    began.map_err(|error| located(&tree, error))?;
    Ok(Resolved {
        programs: programs(&experiment.settings, &tree),
        experiment,
        keys: tree.listing(),
        assumptions: tree.assumptions(),
        lab,
    })
}

/// An error about a key with the place at which the key is set.
fn located(tree: &KeyTree, error: InputError) -> InputError {
    let problem = format!("{} {}", error.place, error.problem);
    InputError::new(tree.place_of(&error.place), problem, error.remedy)
}

/// The programs of agents, each started in the folder of the file that names it.
fn programs(settings: &Settings, tree: &KeyTree) -> Programs {
    let program = |robot| {
        let command = settings.program(robot)?.to_owned();
        let own = robot_name(robot);
        let named = settings.agents.contains_key(&own);
        let key = format!("agents.{}", if named { &own } else { EVERY_ROBOT });
        let folder = tree.path(&key, "");
        Some((robot, Program { command, folder }))
    };
    (0..settings.robots.count).filter_map(program).collect()
}

/// A built-in experiment, or a file applied to the built-in experiment that it names as its base, or that of a recording
/// with the models of its robots.
fn base(experiment: Option<&str>) -> Result<(KeyTree, recorded::Models), InputError> {
    let name_or_path = experiment.unwrap_or("platoon");
    if let Some(tree) = KeyTree::built_in(name_or_path)? {
        return Ok((tree, recorded::Models::new()));
    }
    let path = Path::new(name_or_path);
    if path.extension().is_some_and(|own| own == "mcap") {
        return recorded::read(path);
    }
    let text = std::fs::read_to_string(path).map_err(|error| {
        let remedy = format!("give a file, or one of {}", BUILT_IN.join(", "));
        InputError::new(name_or_path, format!("cannot be read: {error}"), remedy)
    })?;
    let file = keys::File::parse(path, &text)?;
    let name = file.base().unwrap_or_else(|| "platoon".to_owned());
    let mut tree = KeyTree::built_in(&name)?.ok_or_else(|| {
        let remedy = format!("give one of {}", BUILT_IN.join(", "));
        InputError::new(file.place("base"), format!("base is {name:?}"), remedy)
    })?;
    let stem = path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    tree.set(
        "name",
        Value::String(stem),
        &Origin::File(path.to_owned(), 1),
    )?;
    for (key, value, line) in file.keys() {
        tree.set(&key, value, &Origin::File(path.to_owned(), line))?;
    }
    tree.assume(&file)?;
    Ok((tree, recorded::Models::new()))
}

#[cfg(test)]
mod tests {
    use slipstream_bus::experiment::Settings;
    use toml::Table;

    use super::*;

    /// The defaults in the code equal the values in the files of the experiments.
    #[test]
    fn the_papers_files_hold_the_defaults() {
        for (name, settings) in [
            ("platoon", Settings::default()),
            ("single", Settings::single()),
        ] {
            let request = Request {
                experiment: Some(name.to_owned()),
                ..Request::default()
            };
            let resolved = resolve(&request).unwrap();
            assert_eq!(resolved.experiment.settings, settings);
            assert!(resolved.assumptions.len() >= 3);
            for assumption in &resolved.assumptions {
                assert!(!assumption.keys.is_empty() && assumption.reason.len() > 40);
            }
            let text = resolved.to_toml();
            assert!(
                text.contains("; assumption friction") && text.contains("# assumption motor: ")
            );
            assert!(text.parse::<Table>().is_ok());
        }
    }
}
