//! The page about the catalogue of effects.

use slipstream_recording::robot_toml;
use slipstream_sim::effects::{CATALOGUE, Domain, Info, LIST_MAX, ParameterInfo};

use crate::examples;
use crate::markdown::{code, head, sentence, table};
use crate::simulate::model;

pub(crate) fn page() -> String {
    let mut text = head("Effects", "`sim/src/effects`");
    text += "
The catalogue of physics that a model may have or lack. `robot.toml` lists effects under `[effects]`; `slipstream diagnose`
names those that a model lacks. Each picture has the robot of the paper without the effect in grey and with it in blue,
under the same commands. Sizes are chosen to be visible.
";
    let rows = CATALOGUE.iter().map(|info| {
        let link = format!("[`{id}`](#{id})", id = info.id);
        vec![link, sentence(info.summary)]
    });
    text += &table(&["effect", "what it is"], rows);
    text + &CATALOGUE.iter().map(section).collect::<String>()
}

fn section(info: &Info) -> String {
    let example = examples::of(info.id);
    let channels: Vec<&str> = info.channels.iter().map(|channel| channel.name()).collect();
    let models = if info.kinematic {
        "kinematic and dynamic"
    } else {
        "dynamic"
    };
    let facts = [
        ("equation", code(info.equation)),
        ("source", info.source.to_owned()),
        ("acts", info.condition.to_owned()),
        ("seen in", channels.join(", ")),
        ("best seen by", info.manoeuvre.words().to_owned()),
        ("models", models.to_owned()),
        (
            "may be listed",
            if info.repeats {
                "more than once"
            } else {
                "once"
            }
            .to_owned(),
        ),
    ];
    let facts = facts.map(|(name, fact)| vec![name.to_owned(), fact]);
    let parameters = info.parameters.iter().map(parameter);
    let toml = robot_toml::to_text(&model(example, true));
    let start = format!("{} = ", info.id);
    let line = toml.lines().find(|line| line.starts_with(&start)).unwrap();
    [
        format!("\n## {id}\n\n{}\n", sentence(info.summary), id = info.id),
        table(&["", ""], facts),
        table(&["parameter", "unit", "values"], parameters),
        format!("\n```toml\n[effects]\n{line}\n```\n"),
        format!(
            "\n![without and with {id}](pictures/{id}.svg)\n",
            id = info.id
        ),
        format!("\n{}\n", sentence(&example.caption())),
    ]
    .concat()
}

fn parameter(parameter: &ParameterInfo) -> Vec<String> {
    let values = match parameter.domain {
        Domain::Number { lower, upper, .. } => format!("{lower} to {upper}"),
        Domain::Text(words) => words
            .iter()
            .map(|word| code(word))
            .collect::<Vec<_>>()
            .join(", "),
        Domain::List {
            lower,
            upper,
            increasing,
        } => {
            let order = if increasing { ", rising" } else { "" };
            format!("1 to {LIST_MAX} numbers from {lower} to {upper}{order}")
        }
    };
    let note = match (parameter.alternative, parameter.optional) {
        (true, _) => "; one of these parameters",
        (_, true) => "; 0 where it is left out",
        _ => "",
    };
    let unit = match parameter.domain {
        Domain::Text(_) => "",
        _ => parameter.unit,
    };
    vec![code(parameter.name), unit.to_owned(), values + note]
}
