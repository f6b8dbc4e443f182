//! `slipstream effects`: the catalogue of physics that a model may have or lack.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use slipstream_bus::InputError;
use slipstream_sim::effects::{CATALOGUE, Domain, Info, ParameterInfo, find};

use crate::exit::{Error, Exit};
use crate::print::say;

/// List the effects: summary, equation, parameters, and where each one shows
///
/// Example: slipstream effects wheel_slip
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// One effect only
    effect: Option<String>,
    /// Write the catalogue as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    let chosen: Vec<&Info> = match &arguments.effect {
        None => CATALOGUE.iter().collect(),
        Some(id) => vec![
            find(id)
                .ok_or_else(|| InputError::new(id, "is not an effect", "see slipstream effects"))?,
        ],
    };
    if let Some(file) = &arguments.json {
        let effects: Vec<Value> = chosen.iter().map(|info| as_json(info)).collect();
        let answer = json!({"format": 1, "effects": effects});
        crate::output_file::write_json(file, &answer)?;
    }
    for info in chosen {
        say!("{}", in_words(info));
    }
    Ok(Exit::Done)
}

fn in_words(info: &Info) -> String {
    let channels: Vec<&str> = info.channels.iter().map(|channel| channel.name()).collect();
    let mut words = format!(
        "{}\n  {}\n  {}    [{}]\n  acts {}; shows in {}\n  best observed by {}\n",
        info.id,
        info.summary,
        info.equation,
        info.source,
        info.condition,
        channels.join(", "),
        info.manoeuvre.words()
    );
    for parameter in info.parameters {
        // Writing to a string cannot fail.
        let _ = writeln!(words, "  {}", parameter_in_words(parameter));
    }
    words
}

fn parameter_in_words(parameter: &ParameterInfo) -> String {
    let ParameterInfo {
        name,
        unit,
        domain,
        alternative,
        ..
    } = parameter;
    let or = if *alternative { ", one of these" } else { "" };
    match domain {
        Domain::Number { lower, upper, .. } => {
            format!("{name} ({unit}) from {lower} to {upper}{or}")
        }
        Domain::Text(words) => format!("{name}: one of {}", words.join(", ")),
    }
}

fn as_json(info: &Info) -> Value {
    let channels: Vec<&str> = info.channels.iter().map(|channel| channel.name()).collect();
    let parameters: Vec<Value> = info
        .parameters
        .iter()
        .map(|parameter| match parameter.domain {
            Domain::Number { lower, upper, .. } => json!({
                "name": parameter.name, "role": parameter.role.name(), "unit": parameter.unit, "lower": lower, "upper": upper,
            }),
            Domain::Text(words) => json!({
                "name": parameter.name, "role": parameter.role.name(), "unit": parameter.unit, "words": words,
            }),
        })
        .collect();
    json!({
        "id": info.id, "summary": info.summary, "equation": info.equation,
        "source": info.source, "channels": channels, "parameters": parameters,
        "repeats": info.repeats, "kinematic": info.kinematic,
        "acts": info.condition, "experiment": info.manoeuvre.words(),
    })
}
