//! A case: a scene simulated, recorded and labelled.

use std::collections::BTreeMap;

use slipstream_bus::{EffectSpec, Parameter, RobotModel};
use slipstream_recording::Recording;

use super::detectability::detectability;
use super::record::record;
use super::scene::{Camera, Recorded, Scene, Start};
use super::simulate::{SimulatedScene, simulate};
use super::truth::Truth;
use crate::label::{ConcealedEffect, DiagnosisVerdict, Label, ParameterValue, UnknownPhysics};
use slipstream_trial_plant::{OutsideEffect, Push};

/// A case: the input of the diagnosis, and the label.
#[derive(Debug)]
pub struct MadeCase {
    /// The recording.
    pub recording: Recording,
    /// The nominal model.
    pub model: RobotModel,
    /// The label.
    pub label: Label,
}

/// Makes the case of a scene; `name` is the name of its recording.
///
/// # Errors
/// A model that cannot be simulated.
pub fn make(scene: &Scene, name: &str) -> Result<MadeCase, String> {
    let simulated = simulate(scene)?;
    Ok(MadeCase {
        recording: record(scene, &simulated, name),
        model: scene.published(),
        label: label(scene, &simulated, name)?,
    })
}

/// The label of a simulated scene.
fn label(scene: &Scene, simulated: &SimulatedScene, name: &str) -> Result<Label, String> {
    let mut effects = Vec::new();
    let mut unknown = None;
    for (i, (robot, robot_run)) in scene.robots.iter().zip(&simulated.robots).enumerate() {
        if robot.concealed.is_empty() && robot.outside.is_none() {
            continue;
        }
        let detectability = detectability(scene, i, robot_run)?;
        let bounds = detectability
            .gains
            .into_iter()
            .zip(detectability.deviations);
        for (effect, (gain, deviations)) in robot.concealed.iter().zip(bounds) {
            let concealed = concealed(effect, i, &robot_run.truth, gain, deviations);
            if scene.without.contains(&effect.effect) {
                unknown = Some(withheld(concealed));
            } else {
                effects.push(concealed);
            }
        }
        if let Some(effect) = &robot.outside {
            let gain = detectability.outside;
            unknown = Some(outside(effect, i, &robot_run.truth, gain));
        }
    }
    Ok(Label {
        verdict: match (&unknown, effects.is_empty()) {
            (Some(_), _) => DiagnosisVerdict::Unexplained,
            (None, false) => DiagnosisVerdict::Explained,
            (None, true) => DiagnosisVerdict::Match,
        },
        robot_toml: format!("robots/{name}.toml"),
        kind: scene.kind.clone(),
        notes: notes(scene),
        without: scene.without.clone(),
        nuisances: Vec::new(),
        allowed: Vec::new(),
        effects,
        unknown,
    })
}

/// The label of an effect of robot `i`.
fn concealed(
    effect: &EffectSpec,
    i: usize,
    truth: &Truth,
    gain: f64,
    deviations: Vec<(String, f64)>,
) -> ConcealedEffect {
    let link = effect.effect == "link_delay";
    ConcealedEffect {
        effect: effect.effect.clone(),
        robot: Scene::name(i),
        parameters: effect.parameters.iter().map(value).collect(),
        channels: words(channels(&effect.effect)),
        confusions: Vec::new(),
        intervals_s: intervals(effect, truth),
        expected_gain: (!link).then_some(gain),
        deviations: finite(deviations),
        runs: Vec::new(),
        tolerances: BTreeMap::new(),
    }
}

/// The label of an effect outside the vocabulary, of robot `i`.
fn outside(effect: &OutsideEffect, i: usize, truth: &Truth, gain: f64) -> UnknownPhysics {
    let (kind, driver, channels) = effect.describe();
    let parameters = effect.parameters().into_iter();
    UnknownPhysics {
        robot: Scene::name(i),
        kind: kind.to_owned(),
        parameters: parameters
            .map(|(name, number)| (name.to_owned(), ParameterValue::Number(number)))
            .collect(),
        channels: words(channels),
        driver: words(driver),
        intervals_s: rounded(&truth.outside),
        expected_gain: Some(gain),
    }
}

/// How the case was made, for human readers.
fn notes(scene: &Scene) -> BTreeMap<String, String> {
    let blind = scene
        .robots
        .iter()
        .enumerate()
        .filter(|(_, robot)| robot.camera == Camera::Absent);
    let blind: Vec<String> = blind.map(|(i, _)| Scene::name(i)).collect();
    let word = |what: &dyn std::fmt::Debug| format!("{what:?}").to_lowercase();
    let mut notes: BTreeMap<String, String> = [
        ("control", word(&scene.control)),
        ("command", word(&scene.command_kind)),
        ("style", word(&scene.style)),
        ("duration_s", scene.duration_s.to_string()),
        ("without_pose", blind.join(" ")),
        ("wandering_n", scene.disturbance_n.to_string()),
    ]
    .into_iter()
    .map(|(key, text)| (key.to_owned(), text))
    .collect();
    // Only where they say something: the text of a label is part of its commitment.
    let mut note = |key: &str, text: String| notes.insert(key.to_owned(), text);
    if let Some(noise) = scene.noise {
        let [surge, yaw] = if noise.of_speeds {
            ["m/s", "rad/s"]
        } else {
            ["N", "N m"]
        };
        note("noise", noise.kind.name().to_owned());
        note("noise_surge", format!("{} {surge}", noise.surge));
        note("noise_yaw", format!("{} {yaw}", noise.yaw));
        note(
            "noise_correlation_time_s",
            noise.correlation_time_s.to_string(),
        );
        note("noise_pulses_per_min", noise.pulses_per_minute.to_string());
    }
    if scene.start != Start::Rest {
        note("start", format!("{:?}", scene.start).to_lowercase());
    }
    if scene.recorded != Recorded::default() {
        note("recorded", recorded(scene));
    }
    notes
}

/// The streams beside the command, and whether masses are known.
fn recorded(scene: &Scene) -> String {
    let camera = match scene.robots.first().map(|robot| robot.camera) {
        Some(Camera::Pose) => "camera",
        Some(Camera::Position) => "camera without heading",
        _ => "",
    };
    let words = [
        if scene.recorded.wheels { "wheels" } else { "" },
        camera,
        match (scene.imu, scene.recorded.accelerometer) {
            (false, _) => "",
            (true, false) => "gyro",
            (true, true) => "imu",
        },
        if scene.recorded.masses { "masses" } else { "" },
    ];
    let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
    words.join(", ")
}

/// The label of an effect that the diagnosis does not have in its catalogue.
fn withheld(concealed: ConcealedEffect) -> UnknownPhysics {
    let driver = match concealed.effect.as_str() {
        "floor_slope" => &["heading"][..],
        "supply_sag" | "push" => &["t"],
        "command_dead_band" | "command_saturation" => &["torque"],
        "yaw_scrub" => &["w"],
        "friction_patch" => &["position", "x", "y"],
        _ => &["v", "w"],
    };
    let mut channels = concealed.channels;
    // Without the name of the effect, the channel in which it moves the robot is as correct.
    for wheel in ["wheel_right", "wheel_left"] {
        if !channels.iter().any(|channel| channel == wheel) {
            channels.push(wheel.to_owned());
        }
    }
    UnknownPhysics {
        robot: concealed.robot,
        kind: concealed.effect,
        parameters: concealed.parameters,
        channels,
        driver: words(driver),
        intervals_s: concealed.intervals_s,
        expected_gain: concealed.expected_gain,
    }
}

pub(super) fn value((name, value): &(String, Parameter)) -> (String, ParameterValue) {
    let value = match value {
        Parameter::Number(number) => ParameterValue::Number(*number),
        Parameter::Text(text) => ParameterValue::Text(text.clone()),
        Parameter::List(list) => ParameterValue::List(list.clone()),
    };
    (name.clone(), value)
}

fn finite(deviations: Vec<(String, f64)>) -> BTreeMap<String, f64> {
    deviations
        .into_iter()
        .filter(|(_, deviation)| deviation.is_finite() && *deviation > 1e-12)
        .collect()
}

pub(super) fn words(list: &[&str]) -> Vec<String> {
    list.iter().map(|word| (*word).to_owned()).collect()
}

fn rounded(intervals: &[[f64; 2]]) -> Vec<[f64; 2]> {
    intervals
        .iter()
        .map(|ends| ends.map(|t_s| (t_s * 1e3).round() / 1e3))
        .collect()
}

/// When an effect acts; empty if always.
fn intervals(effect: &EffectSpec, truth: &Truth) -> Vec<[f64; 2]> {
    match effect.effect.as_str() {
        "wheel_slip" => rounded(&truth.slips),
        "friction_patch" => rounded(&truth.patches),
        "push" => {
            let begin = effect
                .parameters
                .iter()
                .find_map(|(name, value)| match value {
                    Parameter::Number(number) if name == "t_s" => Some(*number),
                    _ => None,
                });
            begin
                .map(|t_s| rounded(&[[t_s, t_s + Push::DURATION_S]]))
                .unwrap_or_default()
        }
        _ => Vec::new(),
    }
}

/// The channels that are correct answers for an effect of the vocabulary.
pub(super) fn channels(effect: &str) -> &'static [&'static str] {
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
