//! The parameters of one controller.

use std::path::Path;

use slipstream_bag::yaml::{Node, Value};
use slipstream_bus::InputError;

use crate::robot_file::drive::{Drive, Multipliers, Sort};
use crate::robot_file::parameter_names::{Quantity, names_joints, quantity_of};
use crate::robot_file::words::one_line;
use crate::sides::side_of;

/// Parameters of diff_drive_controller: in these, what is no number is a mistake. Others are left alone then, since
/// another program may mean something else by them.
const STRICT: [&str; 2] = ["wheel_separation", "wheel_radius"];
/// Tables in a table that have parameters of the same controller.
const INNER: [&str; 5] = ["wheels", "wheel", "kinematics", "drive", "robot"];
/// The parameter that multiplies the separation.
const TRACK_MULTIPLIER: &str = "wheel_separation_multiplier";
/// The parameter that multiplies both radii, of ROS 1.
const RADIUS_MULTIPLIER: &str = "wheel_radius_multiplier";

/// A table of parameters.
pub(super) struct Table<'a> {
    pub(super) path: &'a Path,
    /// Its name, with those of its namespaces.
    pub(super) name: String,
    /// Its name.
    pub(super) short_name: &'a str,
    pub(super) line: u64,
    pub(super) entries: &'a [(String, Node)],
}

impl Table<'_> {
    /// Whether it may be that of a controller of wheels.
    pub(super) fn says_something(&self) -> bool {
        let mut entries = self.parameters();
        entries.any(|(key, node)| {
            let is_length = || {
                let quantity = quantity_of(&key).map(|(quantity, _)| quantity);
                quantity.is_some_and(|own| own != Quantity::CountsPerTurn)
                    && (is_strict(&key) || plain_number(node).is_some())
            };
            let is_wheels = || names_joints(&key) && joints(node).is_some();
            is_length() || is_wheels() || key == TRACK_MULTIPLIER || key == RADIUS_MULTIPLIER
        })
    }

    /// The parameters, with those of tables inside under names such as `wheels.radius`.
    fn parameters(&self) -> impl Iterator<Item = (String, &Node)> {
        self.entries.iter().flat_map(|(key, node)| {
            let inner = match &node.value {
                Value::Map(entries) if INNER.contains(&key.as_str()) => entries.as_slice(),
                _ => &[],
            };
            let inner = inner
                .iter()
                .map(move |(own, node)| (format!("{key}.{own}"), node));
            std::iter::once((key.clone(), node)).chain(inner)
        })
    }

    /// What it says about the drive.
    ///
    /// # Errors
    /// If a parameter of a diff_drive_controller is no number, or a length is in no known unit.
    pub(super) fn drive(&self, type_elsewhere: Option<&str>) -> Result<Drive, InputError> {
        let own = self.get("type").or_else(|| self.get("plugin"));
        let own = own.and_then(|node| match &node.value {
            Value::Scalar { text, .. } => Some(text.as_str()),
            _ => None,
        });
        let type_name = own.or(type_elsewhere).map(one_line);
        let mut drive = Drive {
            sort: type_name
                .as_deref()
                .and_then(Sort::of_words)
                .unwrap_or_default(),
            type_name,
            multipliers: self.multipliers()?,
            ..Drive::named(&self.name)
        };
        for (key, node) in self.parameters() {
            let Some(quantity) = quantity_of(&key) else {
                self.take_joints(&key, node, &mut drive)?;
                continue;
            };
            if let Some(value) = self.number(&key, node)? {
                let taken = drive.take(&key, quantity, value);
                taken.map_err(|problem| self.error(&key, node, problem, "give it in metres"))?;
            }
        }
        self.count_wheels(&mut drive);
        Ok(drive.complete())
    }

    fn multipliers(&self) -> Result<Multipliers, InputError> {
        // ROS 1 had one multiplier for both wheels.
        let both = self.multiplier(RADIUS_MULTIPLIER)?;
        let right = both * self.multiplier("right_wheel_radius_multiplier")?;
        let left = both * self.multiplier("left_wheel_radius_multiplier")?;
        Ok(Multipliers {
            track: self.multiplier(TRACK_MULTIPLIER)?,
            radii: [right, left],
        })
    }

    /// A multiplier; 1 if it is not given.
    fn multiplier(&self, key: &str) -> Result<f64, InputError> {
        let Some(node) = self.get(key) else {
            return Ok(1.0);
        };
        match self.number(key, node)? {
            Some(number) if number > 0.0 => Ok(number),
            number => {
                let problem = format!("is {}", number.unwrap_or_default());
                Err(self.error(key, node, problem, "give a number above 0"))
            }
        }
    }

    fn get(&self, key: &str) -> Option<&Node> {
        let found = self.entries.iter().find(|(own, _)| own == key);
        found.map(|(_, node)| node)
    }

    fn error(&self, key: &str, node: &Node, problem: impl AsRef<str>, remedy: &str) -> InputError {
        let problem = format!("{key} {}", problem.as_ref());
        InputError::file(self.path, problem, remedy).at(node.line)
    }

    /// A number; `None` of what is none, where that is no mistake.
    fn number(&self, key: &str, node: &Node) -> Result<Option<f64>, InputError> {
        if let Some(number) = plain_number(node) {
            return Ok(Some(number));
        }
        if !is_strict(key) {
            return Ok(None);
        }
        let remedy = "give a number, such as 0.5";
        Err(match &node.value {
            Value::Scalar { text, plain } if !plain && text.parse::<f64>().is_ok() => {
                self.error(key, node, "is in quotes", "remove the quotes")
            }
            Value::Scalar { text, .. } => self.error(key, node, format!("is {text:?}"), remedy),
            other => self.error(key, node, format!("is {}", other.kind()), remedy),
        })
    }

    /// Adds the wheel joints that a parameter names.
    fn take_joints(&self, key: &str, node: &Node, drive: &mut Drive) -> Result<(), InputError> {
        if !names_joints(key) {
            return Ok(());
        }
        let Some(side) = side_of(key) else {
            return Ok(());
        };
        match joints(node) {
            Some(names) => {
                let own = &mut drive.joints[side as usize];
                own.extend(names.into_iter().map(one_line));
                own.dedup();
                Ok(())
            }
            None if key.ends_with("_wheel_names") => {
                let kind = match &node.value {
                    Value::List(list) => {
                        let inner = list.iter().map(|node| &node.value);
                        let mut inner = inner.filter(|own| !matches!(own, Value::Scalar { .. }));
                        inner.next().map_or("a name that is none", Value::kind)
                    }
                    other => other.kind(),
                };
                let remedy = "give the name of a joint or a list of names";
                Err(self.error(key, node, format!("has {kind}"), remedy))
            }
            None => Ok(()),
        }
    }

    /// Counts the wheels of the sides.
    fn count_wheels(&self, drive: &mut Drive) {
        let named = drive.joints.iter().map(Vec::len).max().unwrap_or(0);
        let told = self.get("wheels_per_side").and_then(plain_number);
        drive.has_several = named > 1 || told.is_some_and(|count| count > 1.0);
    }
}

fn is_strict(key: &str) -> bool {
    STRICT.contains(&key) || key.ends_with("_multiplier")
}

/// A finite number that stands without quotes.
fn plain_number(node: &Node) -> Option<f64> {
    let Value::Scalar { text, plain: true } = &node.value else {
        return None;
    };
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// Names of joints: a text or a list of texts. Paths, such as those of topics, and numbers are none.
fn joints<'a>(node: &'a Node) -> Option<Vec<&'a str>> {
    let nodes = match &node.value {
        Value::List(list) => list.iter().collect(),
        _ => vec![node],
    };
    let name = |node: &'a Node| match &node.value {
        Value::Scalar { text, .. } if text.parse::<f64>().is_err() => Some(text.as_str()),
        _ => None,
    };
    let names: Option<Vec<&str>> = nodes.into_iter().map(name).collect();
    names.filter(|names| {
        let is_name = |name: &&str| !name.is_empty() && !name.starts_with('/');
        !names.is_empty() && names.iter().all(is_name)
    })
}
