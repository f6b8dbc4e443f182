//! The specification of a case: what it conceals, and which choices are fixed.

use crate::maker::manoeuvre::{CommandKind, Style};
use crate::maker::process_noise::NoiseKind;
use crate::maker::scene::{Camera, Control};

/// The specification of a case. Choices that are `None` are drawn at random.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CaseSpec {
    /// Kind of case, for the label.
    pub(super) kind: String,
    /// Concealed effects.
    pub(super) effects: Vec<&'static str>,
    /// Size of the effects, from 0 to 1.
    pub(super) size: Option<f64>,
    /// Scales the effect down to this many of its smallest possible standard deviations.
    pub(super) deviations: Option<f64>,
    /// Index of the effect outside the vocabulary; `None`: none.
    pub(super) outside: Option<usize>,
    /// Size from 0 to 1 of an effect that `sim` simulates; `None`: the second simulator.
    pub(super) by_sim: Option<f64>,
    /// The effect is removed from the catalogue of the diagnosis.
    pub(super) withheld: bool,
    /// Driving style.
    pub(super) style: Option<Style>,
    /// Who decides on the commands.
    pub(super) control: Option<Control>,
    /// Kind of command.
    pub(super) command_kind: Option<CommandKind>,
    /// Whether random disturbance forces act on the robots.
    pub(super) disturbed: bool,
    /// Process noise: its kind, and its size from 0 to 1.
    pub(super) noise: Option<(NoiseKind, f64)>,
    /// What is recorded; `None`: drawn, with encoders.
    pub(super) streams: Option<Streams>,
    /// How the recording starts.
    pub(super) start: Begin,
    /// Longest step of the simulation (s).
    pub(super) step_s: f64,
}

/// The streams recorded beside the command of a robot without known masses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Streams {
    /// Whether there are encoders.
    pub(super) wheels: bool,
    /// What the camera measures.
    pub(super) camera: Camera,
    /// Whether there is a gyroscope.
    pub(super) gyro: bool,
}

/// How a recording starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Begin {
    /// At rest.
    Rest,
    /// In the middle of a manoeuvre.
    Moving,
    /// With sliding wheels.
    Sliding,
    /// At rest in a friction patch.
    InPatch,
    /// Under a command within the dead band.
    Pressing,
}

impl CaseSpec {
    /// A case of this kind with these effects; all other choices are drawn at random.
    pub(super) fn new(kind: &str, effects: &[&'static str]) -> Self {
        Self {
            kind: kind.to_owned(),
            effects: effects.to_vec(),
            size: None,
            deviations: None,
            outside: None,
            by_sim: None,
            withheld: false,
            style: None,
            control: None,
            command_kind: None,
            disturbed: false,
            noise: None,
            streams: None,
            start: Begin::Rest,
            step_s: 1e-4,
        }
    }

    /// Whether it conceals any of these effects.
    pub(super) fn needs(&self, any: &[&str]) -> bool {
        self.effects.iter().any(|id| any.contains(id))
    }
}

/// Effects of which any two or three can be combined on any robot.
pub(super) const PAIRED: [&str; 22] = [
    "wheel_slip",
    "rolling_resistance",
    "viscous_drag",
    "caster_drag",
    "yaw_scrub",
    "axle_friction",
    "torque_speed_droop",
    "actuator_lag",
    "actuator_delay",
    "motor_gain",
    "supply_sag",
    "command_dead_band",
    "backlash",
    "wheel_radius",
    "track_width",
    "payload",
    "floor_slope",
    "pose_offset",
    "pose_latency",
    "wheels_latency",
    "encoder_scale",
    "push",
];
/// Effects without a look-alike in the vocabulary.
pub(super) const WITHHELD: [&str; 4] = [
    "floor_slope",
    "supply_sag",
    "command_dead_band",
    "yaw_scrub",
];
