//! `slipstream effects`: the catalogue of physics that a model may have or lack.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use slipstream_bus::InputError;
use slipstream_sim::effects::{CATALOGUE, Domain, Info, LIST_MAX, ParameterInfo, find};

use crate::exit::{Error, Exit};
use crate::print::print_line;

/// List the effects of the catalogue: summary, equation, parameters, and channels where each is visible
///
/// Example: slipstream effects wheel_slip
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Effect to list [default: all]
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
        let effects: Vec<Value> = chosen.iter().map(|info| to_json(info)).collect();
        let answer = json!({"format": 1, "effects": effects});
        crate::output_file::write_json(file, &answer)?;
    }
    for info in chosen {
        print_line!("{}", describe(info));
    }
    Ok(Exit::Done)
}

fn describe(info: &Info) -> String {
    let channels: Vec<&str> = info.channels.iter().map(|channel| channel.name()).collect();
    let mut text = format!(
        "{}\n  {}\n  {}    [{}]\n  acts {}; visible in {}\n  best observed by {}\n",
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
        let _ = writeln!(text, "  {}", describe_parameter(parameter));
    }
    text
}

fn describe_parameter(parameter: &ParameterInfo) -> String {
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
        Domain::List {
            lower,
            upper,
            increasing,
        } => {
            let order = if *increasing { ", rising" } else { "" };
            format!("{name} ({unit}): 1 to {LIST_MAX} numbers from {lower} to {upper}{order}")
        }
    }
}

fn to_json(info: &Info) -> Value {
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
            Domain::List {
                lower,
                upper,
                increasing,
            } => json!({
                "name": parameter.name, "role": parameter.role.name(), "unit": parameter.unit, "lower": lower, "upper": upper,
                "list": true, "longest": LIST_MAX, "increasing": increasing,
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
