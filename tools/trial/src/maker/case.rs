//! A scene played, recorded and labelled.

use std::collections::BTreeMap;

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_recording::Recording;

use super::drive::{Played, play};
use super::record::record;
use super::scene::{Eye, Scene};
use super::size::sizes;
use crate::label::{Hidden, Label, Unknown, Value, Verdict};
use crate::plant::Push;

/// A case: what the diagnosis gets, and the truth.
#[derive(Debug)]
pub struct Made {
    /// The recording.
    pub recording: Recording,
    /// The nominal model.
    pub model: RobotModel,
    /// The truth.
    pub label: Label,
}

/// Makes a case of a scene; `name` names its recording.
///
/// # Errors
/// A model that cannot move.
pub fn make(scene: &Scene, name: &str) -> Result<Made, String> {
    let played = play(scene)?;
    Ok(Made {
        recording: record(scene, &played, name),
        model: scene.nominal.clone(),
        label: label(scene, &played, name)?,
    })
}

fn label(scene: &Scene, played: &Played, name: &str) -> Result<Label, String> {
    let mut effects = Vec::new();
    let mut unknown = None;
    for (i, (robot, actor)) in scene.robots.iter().zip(&played.robots).enumerate() {
        if robot.hidden.is_empty() && robot.strange.is_none() {
            continue;
        }
        let sizes = sizes(scene, i, actor)?;
        for ((effect, gain), deviations) in
            robot.hidden.iter().zip(sizes.gains).zip(sizes.deviations)
        {
            let link = effect.effect == "link_delay";
            let hidden = Hidden {
                effect: effect.effect.clone(),
                robot: Scene::name(i),
                parameters: effect.parameters.iter().map(value).collect(),
                channels: words(channels(&effect.effect)),
                confusions: Vec::new(),
                intervals_s: intervals(effect, &actor.trace),
                expected_gain: (!link).then_some(gain),
                deviations: finite(deviations),
            };
            if scene.without.contains(&effect.effect) {
                unknown = Some(withheld(hidden));
            } else {
                effects.push(hidden);
            }
        }
        if let Some(strange) = robot.strange {
            let (kind, driver, channels) = strange.describe();
            let parameters = strange.parameters().into_iter();
            unknown = Some(Unknown {
                robot: Scene::name(i),
                kind: kind.to_owned(),
                parameters: parameters
                    .map(|(name, number)| (name.to_owned(), Value::Number(number)))
                    .collect(),
                channels: words(channels),
                driver: words(driver),
                intervals_s: rounded(&actor.trace.strange),
                expected_gain: Some(sizes.strange),
            });
        }
    }
    Ok(Label {
        verdict: match (&unknown, effects.is_empty()) {
            (Some(_), _) => Verdict::Unexplained,
            (None, false) => Verdict::Explained,
            (None, true) => Verdict::Match,
        },
        robot_toml: format!("robots/{name}.toml"),
        kind: scene.kind.clone(),
        notes: notes(scene),
        without: scene.without.clone(),
        effects,
        unknown,
    })
}

fn notes(scene: &Scene) -> BTreeMap<String, String> {
    let blind = scene
        .robots
        .iter()
        .enumerate()
        .filter(|(_, robot)| robot.eye == Eye::Blind);
    let blind: Vec<String> = blind.map(|(i, _)| Scene::name(i)).collect();
    let word = |what: &dyn std::fmt::Debug| format!("{what:?}").to_lowercase();
    [
        ("control", word(&scene.control)),
        ("command", word(&scene.told)),
        ("style", word(&scene.style)),
        ("duration_s", scene.duration_s.to_string()),
        ("without_pose", blind.join(" ")),
        ("wandering_n", scene.wandering_n.to_string()),
    ]
    .into_iter()
    .map(|(key, text)| (key.to_owned(), text))
    .collect()
}

/// An effect of the vocabulary that the diagnosis does not have.
fn withheld(hidden: Hidden) -> Unknown {
    let driver = match hidden.effect.as_str() {
        "floor_slope" => &["heading"][..],
        "supply_sag" | "push" => &["t"],
        "command_dead_band" | "command_saturation" => &["torque"],
        "yaw_scrub" => &["w"],
        "friction_patch" => &["position", "x", "y"],
        _ => &["v", "w"],
    };
    let mut channels = hidden.channels;
    // without its name, the channel in which it moves the robot is as right
    for wheel in ["wheel_right", "wheel_left"] {
        if !channels.iter().any(|channel| channel == wheel) {
            channels.push(wheel.to_owned());
        }
    }
    Unknown {
        robot: hidden.robot,
        kind: hidden.effect,
        parameters: hidden.parameters,
        channels,
        driver: words(driver),
        intervals_s: hidden.intervals_s,
        expected_gain: hidden.expected_gain,
    }
}

fn value((name, value): &(String, Parameter)) -> (String, Value) {
    let value = match value {
        Parameter::Number(number) => Value::Number(*number),
        Parameter::Text(text) => Value::Text(text.clone()),
    };
    (name.clone(), value)
}

fn finite(deviations: Vec<(String, f64)>) -> BTreeMap<String, f64> {
    deviations
        .into_iter()
        .filter(|(_, deviation)| deviation.is_finite() && *deviation > 1e-12)
        .collect()
}

fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(|word| (*word).to_owned()).collect()
}

fn rounded(intervals: &[[f64; 2]]) -> Vec<[f64; 2]> {
    intervals
        .iter()
        .map(|ends| ends.map(|t_s| (t_s * 1e3).round() / 1e3))
        .collect()
}

/// When an effect is at work, where it is not always.
fn intervals(effect: &EffectSpec, trace: &super::trace::Trace) -> Vec<[f64; 2]> {
    match effect.effect.as_str() {
        "wheel_slip" => rounded(&trace.slips),
        "friction_patch" => rounded(&trace.patches),
        "push" => {
            let begin = effect
                .parameters
                .iter()
                .find_map(|(name, value)| match value {
                    Parameter::Number(number) if name == "t_s" => Some(*number),
                    _ => None,
                });
            begin
                .map(|t_s| rounded(&[[t_s, t_s + Push::LASTS_S]]))
                .unwrap_or_default()
        }
        _ => Vec::new(),
    }
}

/// Channels any of which is right for an effect of the vocabulary.
fn channels(effect: &str) -> &'static [&'static str] {
    match effect {
        "wheel_slip" | "friction_patch" | "caster_drag" => &[
            "longitudinal",
            "lateral",
            "yaw",
            "wheel_right",
            "wheel_left",
        ],
        "rolling_resistance" | "viscous_drag" | "quadratic_drag" | "load_transfer" => {
            &["longitudinal", "wheel_right", "wheel_left"]
        }
        "yaw_scrub" | "track_width" => &["yaw"],
        "backlash" | "wheel_radius" => &[
            "longitudinal",
            "yaw",
            "wheel_right",
            "wheel_left",
            "sensor_wheels",
        ],
        "payload" | "floor_slope" | "push" => &["longitudinal", "lateral", "yaw"],
        "pose_offset" | "pose_latency" => &["sensor_pose"],
        "wheels_latency" | "encoder_scale" => &["sensor_wheels"],
        "imu_latency" => &["sensor_imu"],
        "clock_drift" => &["sensor_pose", "sensor_wheels", "sensor_imu"],
        "link_delay" => &["link"],
        _ => &["longitudinal", "yaw", "wheel_right", "wheel_left"],
    }
}
