//! What a file says about a robot.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use slipstream_bus::{Body, EffectSpec, Encoder, InputError, Parameter, RobotModel};
use slipstream_sim::Robot;

use super::drive::Drive;
use super::words::one_line;
use crate::toml_files::robot_toml;

/// The kind of a file that describes a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A `robot.toml`.
    RobotToml,
    /// A URDF: links and joints as XML.
    Urdf,
    /// Parameters of a controller, such as diff_drive_controller, as YAML or JSON.
    ControllerYaml,
    /// Constants in the source of a program.
    Constants,
}

impl Kind {
    /// Its name in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::RobotToml => "robot.toml",
            Self::Urdf => "URDF",
            Self::ControllerYaml => "controller YAML",
            Self::Constants => "constants of a program",
        }
    }
}

/// A file that says something about a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// The file.
    pub file: PathBuf,
    /// Its kind.
    pub kind: Kind,
    /// What it is, in words: the kind, of a controller with its type.
    pub title: String,
}

/// A value that a file gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Taken {
    /// Its key: of `[robot]`, or with the name of its table.
    pub key: String,
    /// The value, in `unit`.
    pub value: f64,
    /// Its unit; 1 for a plain number.
    pub unit: String,
    /// From where in the file.
    pub from: String,
}

impl Taken {
    /// A value; the unit is that of the key's name.
    pub(super) fn new(key: &str, value: f64, from: impl Into<String>) -> Self {
        let unit = unit(key).to_owned();
        let (key, from) = (one_line(key), one_line(&from.into()));
        Self {
            key,
            value,
            unit,
            from,
        }
    }
}

/// A value that every model needs and that a file does not give.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    /// Its key in `[robot]`.
    pub key: String,
    /// Why the file does not give it.
    pub problem: String,
    /// What a human must do.
    pub remedy: String,
}

impl Missing {
    pub(super) fn new(key: &str, problem: impl AsRef<str>, remedy: impl AsRef<str>) -> Self {
        Self {
            key: key.to_owned(),
            problem: one_line(problem.as_ref()),
            remedy: one_line(remedy.as_ref()),
        }
    }
}

/// What files say about a robot: a model, or what it lacks. All texts are single lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// The kind of the first file.
    pub kind: Kind,
    /// The files.
    pub sources: Vec<Source>,
    /// The values of the model.
    pub taken: Vec<Taken>,
    /// Values that the file gives and the model leaves out; `notes` say why.
    pub left_out: Vec<Taken>,
    /// What a human must fill in.
    pub missing: Vec<Missing>,
    /// What was assumed.
    pub notes: Vec<String>,
    /// Names of the joints of the driven wheels, right and left, each from the front.
    pub wheel_joints: [Vec<String>; 2],
    /// The model; a length that is missing is NaN.
    pub(super) draft: RobotModel,
}

impl Described {
    /// A description without values yet.
    pub(super) fn new(kind: Kind, path: &Path) -> Self {
        Self {
            kind,
            sources: vec![Source {
                file: path.to_owned(),
                kind,
                title: kind.name().to_owned(),
            }],
            taken: Vec::new(),
            left_out: Vec::new(),
            missing: Vec::new(),
            notes: Vec::new(),
            wheel_joints: [Vec::new(), Vec::new()],
            draft: RobotModel {
                robot: Body::kinematic(f64::NAN, f64::NAN),
                motor: None,
                encoder: None,
                effects: Vec::new(),
            },
        }
    }

    /// The description of a model that a robot.toml gives.
    pub(super) fn of_model(model: RobotModel, path: &Path) -> Self {
        let taken = robot_toml::numbers(&model).into_iter();
        Self {
            taken: taken
                .map(|(key, value)| Taken::new(&key, value, "the key itself"))
                .collect(),
            draft: model,
            ..Self::new(Kind::RobotToml, path)
        }
    }

    /// The radius of the driven wheels (m).
    pub(super) fn take_radius(&mut self, radius_m: f64, from: impl Into<String>) {
        self.draft.robot.wheel_radius_m = radius_m;
        self.taken
            .push(Taken::new("wheel_radius_m", radius_m, from));
    }

    /// Half of the track (m).
    pub(super) fn take_half_track(&mut self, half_track_m: f64, from: impl Into<String>) {
        self.draft.robot.half_track_m = half_track_m;
        self.taken
            .push(Taken::new("half_track_m", half_track_m, from));
    }

    /// What drives say beside their lengths: encoder counts, and what was assumed.
    pub(super) fn take_drives<'a>(&mut self, drives: impl IntoIterator<Item = &'a Drive>) {
        for drive in drives {
            drive.notes.iter().for_each(|note| self.note(note));
            if let (Some((counts, from)), None) = (&drive.counts_per_rev, &self.draft.encoder) {
                self.take_counts(*counts, from);
            }
        }
    }

    /// Encoder counts per turn of a wheel.
    fn take_counts(&mut self, counts_per_rev: f64, from: &str) {
        if Encoder::COUNTS.contains(&counts_per_rev) {
            self.draft.encoder = Some(Encoder { counts_per_rev });
            self.taken
                .push(Taken::new("encoder.counts_per_rev", counts_per_rev, from));
        }
    }

    /// An effect of numbers, each with where it is from.
    pub(super) fn take_effect(&mut self, effect: &str, parameters: &[(&str, f64, String)]) {
        let numbers = parameters.iter();
        self.draft.effects.push(EffectSpec {
            effect: effect.to_owned(),
            parameters: numbers
                .map(|(name, value, _)| ((*name).to_owned(), Parameter::Number(*value)))
                .collect(),
        });
        for (name, value, from) in parameters {
            self.taken.push(Taken::new(
                &format!("effects.{effect}.{name}"),
                *value,
                from,
            ));
        }
    }

    /// All masses, inertias and lengths of a dynamic model, if they make a valid one.
    ///
    /// # Errors
    /// The first value that no robot can have; nothing is taken then.
    pub(super) fn take_masses(&mut self, masses: &[Taken]) -> Result<(), InputError> {
        let mut draft = self.draft.clone();
        for Taken { key, value, .. } in masses {
            if let Some(place) = robot_toml::body_value_mut(&mut draft.robot, key) {
                *place = Some(*value);
            }
        }
        validate(&draft)?;
        self.draft = draft;
        self.taken.extend(masses.iter().cloned());
        Ok(())
    }

    /// Takes what another description says and this one does not: masses, encoder counts, wheel joints.
    ///
    /// # Errors
    /// If masses that fit the other's lengths do not fit these.
    pub(super) fn fill_from(&mut self, other: &Self) -> Result<(), InputError> {
        if self.draft.robot.body_mass_kg.is_none() {
            let mut body = self.draft.robot.clone();
            let is_mass = |own: &&Taken| robot_toml::body_value_mut(&mut body, &own.key).is_some();
            let masses: Vec<Taken> = other.taken.iter().filter(is_mass).cloned().collect();
            if other.draft.robot.body_mass_kg.is_some() {
                self.take_masses(&masses)?;
            }
        }
        if let (None, Some(encoder)) = (&self.draft.encoder, &other.draft.encoder) {
            self.draft.encoder = Some(encoder.clone());
            let own = other.taken.iter();
            self.taken.extend(
                own.filter(|own| own.key == "encoder.counts_per_rev")
                    .cloned(),
            );
        }
        self.wheel_joints.clone_from(&other.wheel_joints);
        self.notes.extend(other.notes.iter().cloned());
        Ok(())
    }

    /// A note.
    pub(super) fn note(&mut self, note: impl AsRef<str>) {
        self.notes.push(one_line(note.as_ref()));
    }

    /// Checks the values that were taken, as a run does.
    ///
    /// # Errors
    /// The first value that no robot can have.
    pub(super) fn checked(self) -> Result<Self, InputError> {
        validate(&self.draft).map_err(|error| {
            let key = error.place.strip_prefix("robot.").unwrap_or(&error.place);
            let taken = self.taken.iter().find(|taken| taken.key == key);
            let from = taken.map(|taken| format!(" ({})", taken.from));
            let problem = format!("{key} {}{}", error.problem, from.unwrap_or_default());
            InputError::file(self.first_file(), problem, error.remedy)
        })?;
        Ok(self)
    }

    /// The model.
    ///
    /// # Errors
    /// If the file leaves out a length without which there is no model: says which, why, and what to do.
    pub fn model(&self) -> Result<RobotModel, InputError> {
        if self.missing.is_empty() {
            return Ok(self.draft.clone());
        }
        let keys: Vec<&str> = self.missing.iter().map(|missing| &*missing.key).collect();
        let mut why: Vec<&str> = self
            .missing
            .iter()
            .map(|missing| &*missing.problem)
            .collect();
        why.dedup();
        let problem = format!("gives no {}: {}", keys.join(" and no "), why.join(", and "));
        let files: Vec<String> = self
            .sources
            .iter()
            .map(|own| own.file.display().to_string())
            .collect();
        let write = format!(
            "write a robot.toml with `slipstream robot {} --out robot.toml`, fill in what is missing, and give that",
            files.join(" ")
        );
        let remedy = match self.sources.as_slice() {
            [only] if only.kind == Kind::ControllerYaml => {
                let file = one_line(&only.file.display().to_string());
                format!(
                    "give the robot's URDF, too (--robot robot.urdf --robot {file}), or {write}"
                )
            }
            _ => write,
        };
        Err(InputError::file(self.first_file(), problem, remedy))
    }

    /// The first of the files.
    pub(super) fn first_file(&self) -> &Path {
        self.sources.first().map_or(Path::new(""), |own| &own.file)
    }
}

/// Checks a draft; a length that is missing counts as 1 m.
fn validate(draft: &RobotModel) -> Result<(), InputError> {
    let mut model = draft.clone();
    for length in [
        &mut model.robot.wheel_radius_m,
        &mut model.robot.half_track_m,
    ] {
        if length.is_nan() {
            *length = 1.0;
        }
    }
    Robot::new(&model).map(|_| ())
}

/// The unit in which a key's name ends.
fn unit(key: &str) -> &'static str {
    let units = [
        ("_kg_m2", "kg m²"),
        ("_rad_s", "rad/s"),
        ("_m_s", "m/s"),
        ("_n_s", "N s"),
        ("_nm", "N m"),
        ("_per_s", "1/s"),
        ("_kg", "kg"),
        ("_rad", "rad"),
        ("_m", "m"),
        ("_s", "s"),
        ("_v", "V"),
    ];
    let own = units.iter().find(|(ending, _)| key.ends_with(ending));
    own.map_or("1", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot_file::words::in_words;

    #[test]
    fn a_value_has_the_unit_of_its_key() {
        let unit = |key| Taken::new(key, 1.0, "").unit;
        assert_eq!(unit("body_yaw_inertia_kg_m2"), "kg m²");
        assert_eq!(unit("motor.no_load_speed_rad_s"), "rad/s");
        assert_eq!(unit("effects.wheel_radius.left_scale"), "1");
    }

    #[test]
    fn texts_are_single_lines() {
        assert_eq!(Taken::new("a", 1.0, "b\n\u{1b}[2Jc").from, "b  [2Jc");
        assert_eq!(in_words(0.123_456), "0.1235 m");
        assert_eq!(in_words(-1e-9), "0 m");
    }
}
