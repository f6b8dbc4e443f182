//! Parameters of controllers as YAML or JSON: ros2_control's diff_drive_controller, that of ROS 1, and the nodes of
//! robots that reckon themselves, such as turtlebot3_node.

mod table;

use std::path::Path;

use slipstream_bag::yaml::{self, Node, Value};
use slipstream_bus::InputError;

use self::table::Table;
use super::drive::Drive;

/// Between the names of a namespace and a controller in it.
const SEPARATOR: &str = "/";
/// What to give in place of a file without a controller.
const REMEDY: &str =
    "give a robot.toml, a URDF, or the YAML with the parameters of a diff_drive_controller";

/// What a file of parameters says about the drive of a robot.
///
/// # Errors
/// If the text is not YAML, if it has no controller of wheels or several that differ, or if a parameter is no number.
pub(super) fn drive(text: &str, path: &Path) -> Result<Drive, InputError> {
    let documents = yaml::parse(text, path)?;
    let mut found = Found {
        path,
        tables: Vec::new(),
        types: Vec::new(),
    };
    for document in &documents {
        found.search(document, &mut Vec::new());
    }
    found.one()
}

/// The tables of a file that may be those of a controller.
struct Found<'a> {
    path: &'a Path,
    tables: Vec<Table<'a>>,
    /// Types by the names of what has them: a controller's type stands elsewhere than its parameters.
    types: Vec<(&'a str, &'a str)>,
}

impl<'a> Found<'a> {
    /// Adds a node and what is in it.
    fn search(&mut self, node: &'a Node, name: &mut Vec<&'a str>) {
        let Value::Map(entries) = &node.value else {
            return;
        };
        for key in ["type", "plugin"] {
            if let (Some(Value::Scalar { text, .. }), Some(own)) =
                (node.get(key).map(|node| &node.value), owner(name))
            {
                self.types.push((own, text));
            }
        }
        let table = Table {
            path: self.path,
            name: title(name),
            short_name: owner(name).unwrap_or_default(),
            line: node.line,
            entries,
        };
        if table.says_something() {
            self.tables.push(table);
            return;
        }
        for (key, value) in entries {
            name.push(key);
            self.search(value, name);
            name.pop();
        }
    }

    /// The drive of the only controller.
    fn one(self) -> Result<Drive, InputError> {
        let type_of = |table: &Table<'_>| {
            let own = self.types.iter();
            let mut own = own.filter(|(name, _)| *name == table.short_name);
            own.next().map(|(_, name)| *name)
        };
        let mut drives = Vec::new();
        for table in &self.tables {
            drives.push((table, table.drive(type_of(table))?));
        }
        // A controller names its wheels; of others, such as a node of odometry, the lengths alone are known.
        let has_wheels = |drive: &Drive| drive.joints.iter().any(|side| !side.is_empty());
        if drives.iter().any(|(_, drive)| has_wheels(drive)) {
            drives.retain(|(_, drive)| has_wheels(drive));
        }
        let same = |a: &Drive, b: &Drive| {
            let lengths = |own: &Drive| {
                [&own.separation, &own.radius].map(|own| own.as_ref().map(|own| own.value_m))
            };
            lengths(a) == lengths(b) && a.multipliers == b.multipliers && a.joints == b.joints
        };
        drives.dedup_by(|(_, later), (_, first)| same(later, first));
        if drives.len() > 1 {
            let names: Vec<&str> = drives.iter().map(|(table, _)| &*table.name).collect();
            let problem = format!("has several controllers with wheels: {}", names.join(", "));
            let line = drives.iter().skip(1).map(|(table, _)| table.line).min();
            let error = InputError::file(self.path, problem, "leave one of them in the file");
            return Err(error.at(line.unwrap_or(1)));
        }
        let drive = drives.pop().map(|(_, drive)| drive);
        drive.ok_or_else(|| self.none())
    }

    /// Why there is none.
    fn none(&self) -> InputError {
        let drives = |text: &str| super::drive::Sort::of_words(text).is_some();
        let mut others = self.types.iter().filter(|(_, name)| drives(name));
        let problem = match others.next() {
            Some((name, own)) => format!("has {name}, a {own}, without lengths or wheels"),
            None => "has no controller with wheel_separation".to_owned(),
        };
        InputError::file(self.path, problem, REMEDY)
    }
}

/// The name of the thing whose parameters these are.
fn owner<'a>(name: &[&'a str]) -> Option<&'a str> {
    let mut names = name.iter().rev().filter(|key| **key != "ros__parameters");
    names.next().map(|key| key.trim_matches('/'))
}

/// The name with those of its namespaces.
fn title(name: &[&str]) -> String {
    let keys = name.iter().filter(|key| **key != "ros__parameters");
    let keys: Vec<&str> = keys.map(|key| key.trim_matches('/')).collect();
    match keys.join(SEPARATOR) {
        none if none.is_empty() => "the file".to_owned(),
        name => name,
    }
}

#[cfg(test)]
mod tests;
