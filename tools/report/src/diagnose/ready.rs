//! Lines to copy: into robot.toml, and into the parameters of a controller.

use maud::{Markup, html};
use slipstream_answer::calibration;
use slipstream_bus::{Parameter, RobotModel};
use slipstream_recording::robot_toml;

use super::diagnosis::Diagnosis;
use crate::parts::code_box;

/// Effects that a calibration corrects.
const CALIBRATED: [&str; 4] = [
    "wheel_radius",
    "track_width",
    "encoder_scale",
    "pose_offset",
];

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
    let controller = controller(diagnosis, robot, model);
    html! {
        div class="boxes" {
            (code_box("toml", "robot.toml", &place, &effects_of(model)))
            @if let Some(lines) = controller {
                (code_box("yaml", "diff_drive_controller", "by --calibration", &lines))
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

/// The calibration, where the controller is not as it should be.
fn controller(diagnosis: &Diagnosis<'_>, robot: &str, model: &RobotModel) -> Option<String> {
    let mut own = diagnosis
        .answer
        .findings
        .iter()
        .filter(|own| own.robot == robot);
    own.find(|own| CALIBRATED.contains(&own.effect.as_str()))?;
    let text = calibration(diagnosis.answer, robot, model, diagnosis.recordings);
    Some(text.trim_end().to_owned())
}
