//! Lines to copy: into robot.toml, and into the parameters of a controller.

use std::fmt::Write as _;

use maud::{Markup, html};
use slipstream_bus::{Parameter, RobotModel};
use slipstream_recording::robot_toml;

use super::diagnosis::Diagnosis;
use crate::parts::{code_box, digits_of};

/// Lines to copy: what robot.toml gains, and the parameters of ros2_control's diff_drive_controller.
pub(super) fn ready(diagnosis: &Diagnosis<'_>) -> Markup {
    let named = |robot: &str| {
        let mut own = diagnosis.answer.findings.iter();
        own.any(|own| own.robot == robot && own.effect != "unknown")
    };
    let models: Vec<&(String, RobotModel)> = diagnosis
        .improved
        .iter()
        .filter(|(robot, _)| named(robot))
        .collect();
    let Some((robot, model)) = models.first() else {
        return html! {};
    };
    let several = models.len() > 1;
    let place = if several {
        format!("of {robot}, by --improved")
    } else {
        "by --improved".to_owned()
    };
    let controller = controller(diagnosis, robot);
    html! {
        div class="boxes" {
            (code_box("toml", "robot.toml", &place, &effects_of(model)))
            @if let Some(lines) = controller {
                (code_box("yaml", "diff_drive_controller", "parameters", &lines))
            }
        }
    }
}

/// The effects of a model as its file lists them, numbers to five digits.
fn effects_of(model: &RobotModel) -> String {
    let mut rounded = model.clone();
    let to_digits = |value: &mut f64| {
        if let Ok(own) = format!("{value:.4e}").parse() {
            *value = own;
        }
    };
    for (_, parameter) in rounded
        .effects
        .iter_mut()
        .flat_map(|own| &mut own.parameters)
    {
        match parameter {
            Parameter::Number(value) => to_digits(value),
            Parameter::List(values) => values.iter_mut().for_each(to_digits),
            Parameter::Text(_) => {}
        }
    }
    let text = robot_toml::to_text(&rounded);
    let from = text.find("[effects]").unwrap_or(text.len());
    text[from..].trim_end().to_owned()
}

fn controller(diagnosis: &Diagnosis<'_>, robot: &str) -> Option<String> {
    let mut lines = String::new();
    for finding in diagnosis
        .answer
        .findings
        .iter()
        .filter(|own| own.robot == robot)
    {
        let keys: &[(&str, &str)] = match finding.effect.as_str() {
            "wheel_radius" => &[
                ("right_scale", "right_wheel_radius_multiplier"),
                ("left_scale", "left_wheel_radius_multiplier"),
            ],
            "track_width" => &[("scale", "wheel_separation_multiplier")],
            _ => &[],
        };
        for (parameter, key) in keys {
            let own = finding.parameters.iter().find(|own| own.name == *parameter);
            if let Some(own) = own.filter(|_| finding.runs.is_none()) {
                let digits = own.ci95.map_or(4, digits_of).max(3);
                let _ = write!(lines, "\n  {key}: {:.digits$}", own.estimate?);
            }
        }
    }
    (!lines.is_empty()).then(|| format!("ros__parameters:{lines}"))
}
