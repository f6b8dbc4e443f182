//! What is known about a run before it begins, and what a wheel does on the floor.

use std::collections::BTreeMap;

use crate::recording::Recording;

/// A file that goes along with a run.
#[derive(Debug, Clone)]
pub struct Attachment {
    /// Its name, such as `experiment.toml`.
    pub name: String,
    /// What it is, such as `application/toml`.
    pub media_type: String,
    /// Its content.
    pub data: Vec<u8>,
}

/// What is known about a run before it begins.
#[derive(Debug, Clone, Default)]
pub struct About {
    /// Robots in order, with their encoders and noise, and the nominal model. Streams are not read.
    pub description: Recording,
    /// Experiment, models of single robots, and whatever else should be found in the file.
    pub attachments: Vec<Attachment>,
    /// Versions, seed and the like, by name.
    pub metadata: BTreeMap<String, String>,
}

/// What a driven wheel does on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelContact {
    /// The contact slides; else it sticks.
    pub slips: bool,
    /// Speed of the contact over the floor along the wheel (m/s).
    pub slip_longitudinal_m_s: f64,
    /// Speed of the contact over the floor across the wheel (m/s).
    pub slip_lateral_m_s: f64,
    /// Force of the floor on the wheel (N).
    pub normal_force_n: f64,
    /// Torque applied at the wheel (N m).
    pub applied_torque_nm: f64,
}
