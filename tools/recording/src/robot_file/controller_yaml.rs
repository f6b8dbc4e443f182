//! Parameters of ros2_control's diff_drive_controller, and of the one of ROS 1.
//!
//! The lengths of the model are those with which the controller reckons: its parameters times their
//! multipliers. Where the wheels' multipliers differ, the radius is that of their mean, and the effect
//! `wheel_radius` has the difference.

use std::path::Path;

use slipstream_bus::InputError;

use super::described::{Described, Kind, Missing};
use crate::yaml::{self, Node, Value};

/// Between the names of a namespace and a controller in it.
const SEPARATOR: &str = "/";
/// What to give in place of a file without a controller.
const REMEDY: &str =
    "give a robot.toml, a URDF, or the YAML with the parameters of a diff_drive_controller";

/// Describes the robot of a controller.
///
/// # Errors
/// If the text is not YAML, if it has no diff_drive_controller or several, or if a parameter is no number or
/// physically impossible.
pub(super) fn describe(text: &str, path: &Path) -> Result<Described, InputError> {
    let documents = yaml::parse(text, path)?;
    let mut found = Vec::new();
    for document in &documents {
        find(document, &mut Vec::new(), path, &mut found);
    }
    let controller = one(found, path)?;
    let mut described = Described::new(Kind::ControllerYaml, path);
    let radii = controller.radius(&mut described)?;
    controller.half_track(&mut described)?;
    controller.take_difference(radii, &mut described);
    described.wheel_joints = [controller.names("right")?, controller.names("left")?];
    controller.wheels_per_side(&mut described)?;
    described.checked()
}

/// The parameters of a controller.
struct Controller<'a> {
    path: &'a Path,
    /// Its name, with that of its namespace.
    name: String,
    line: u64,
    parameters: &'a [(String, Node)],
}

/// Adds every table that has the parameters of a diff_drive_controller.
fn find<'a>(
    node: &'a Node,
    name: &mut Vec<&'a str>,
    path: &'a Path,
    found: &mut Vec<Controller<'a>>,
) {
    let Value::Map(entries) = &node.value else {
        return;
    };
    let has = |key: &str| entries.iter().any(|(own, _)| own == key);
    let wheels = [
        "left_wheel_names",
        "right_wheel_names",
        "left_wheel",
        "right_wheel",
    ];
    if has("wheel_separation") || (has("wheel_radius") && wheels.iter().any(|key| has(key))) {
        let keys = name.iter().filter(|key| **key != "ros__parameters");
        let keys: Vec<&str> = keys.map(|key| key.trim_matches('/')).collect();
        let name = match keys.join(SEPARATOR) {
            none if none.is_empty() => "the file".to_owned(),
            name => name,
        };
        found.push(Controller {
            path,
            name,
            line: node.line,
            parameters: entries,
        });
        return;
    }
    for (key, value) in entries {
        name.push(key);
        find(value, name, path, found);
        name.pop();
    }
}

/// The only controller.
fn one<'a>(mut found: Vec<Controller<'a>>, path: &Path) -> Result<Controller<'a>, InputError> {
    if let [first, second, ..] = found.as_slice() {
        let names: Vec<&str> = found.iter().map(|own| &*own.name).collect();
        let problem = format!("has several controllers with wheels: {}", names.join(", "));
        let line = if first.line < second.line {
            second.line
        } else {
            first.line
        };
        return Err(InputError::file(path, problem, "leave one of them in the file").at(line));
    }
    let none = || InputError::file(path, "has no controller with wheel_separation", REMEDY);
    found.pop().ok_or_else(none)
}

impl Controller<'_> {
    fn get(&self, key: &str) -> Option<&Node> {
        let found = self.parameters.iter().find(|(own, _)| own == key);
        found.map(|(_, node)| node)
    }

    fn error(&self, key: &str, node: &Node, problem: impl AsRef<str>, remedy: &str) -> InputError {
        let problem = format!("{key} {}", problem.as_ref());
        InputError::file(self.path, problem, remedy).at(node.line)
    }

    /// A number, if it is given.
    fn number(&self, key: &str) -> Result<Option<f64>, InputError> {
        let Some(node) = self.get(key) else {
            return Ok(None);
        };
        let remedy = "give a number, such as 0.5";
        let Value::Scalar { text, plain } = &node.value else {
            return Err(self.error(key, node, format!("is {}", node.value.kind()), remedy));
        };
        match text.parse::<f64>() {
            Ok(number) if *plain && number.is_finite() => Ok(Some(number)),
            Ok(_) if !plain => Err(self.error(key, node, "is in quotes", "remove the quotes")),
            _ => Err(self.error(key, node, format!("is {text:?}"), remedy)),
        }
    }

    /// A multiplier; 1 if it is not given.
    fn multiplier(&self, key: &str) -> Result<f64, InputError> {
        match self.number(key)? {
            None => Ok(1.0),
            Some(number) if number > 0.0 => Ok(number),
            Some(number) => {
                let problem = format!("{key} is {number}");
                let line = self.get(key).map_or(self.line, |node| node.line);
                let remedy = "give a number above 0";
                Err(InputError::file(self.path, problem, remedy).at(line))
            }
        }
    }

    /// A sentence's words for a parameter, with its multiplier if that is not 1.
    fn from(&self, key: &str, multiplier: f64, multiplied_by: &str) -> String {
        if multiplier == 1.0 {
            format!("{key} of {}", self.name)
        } else {
            format!("{key} times {multiplied_by} of {}", self.name)
        }
    }

    fn half_track(&self, described: &mut Described) -> Result<(), InputError> {
        let multiplier = self.multiplier("wheel_separation_multiplier")?;
        match self.number("wheel_separation")? {
            Some(separation) => {
                let from = self.from("wheel_separation", multiplier, "its multiplier");
                described.take_half_track(separation * multiplier / 2.0, format!("half of {from}"));
            }
            None => described.missing.push(Missing::new(
                "half_track_m",
                format!("{} has no wheel_separation", self.name),
                "measure the distance between the middles of the wheels and write half of it",
            )),
        }
        Ok(())
    }

    /// Takes the radius; gives the multipliers of the wheels, right and left.
    fn radius(&self, described: &mut Described) -> Result<[f64; 2], InputError> {
        // ROS 1 had one multiplier for both wheels.
        let both = self.multiplier("wheel_radius_multiplier")?;
        let right = both * self.multiplier("right_wheel_radius_multiplier")?;
        let left = both * self.multiplier("left_wheel_radius_multiplier")?;
        let mean = mean(right, left);
        match self.number("wheel_radius")? {
            Some(radius) => {
                let multiplied_by = if right == left {
                    "its multiplier"
                } else {
                    "the mean multiplier"
                };
                let from = self.from("wheel_radius", mean, multiplied_by);
                described.take_radius(radius * mean, from);
            }
            None => described.missing.push(Missing::new(
                "wheel_radius_m",
                format!("{} has no wheel_radius", self.name),
                "measure the radius of the wheels under load and write it",
            )),
        }
        Ok([right, left])
    }

    /// Takes the difference of the wheels' multipliers as an effect.
    fn take_difference(&self, [right, left]: [f64; 2], described: &mut Described) {
        if right == left {
            return;
        }
        let mean = mean(right, left);
        let from = |side: &str| {
            format!(
                "{side}_wheel_radius_multiplier over the mean multiplier of {}",
                self.name
            )
        };
        let scales = [
            ("right_scale", right / mean, from("right")),
            ("left_scale", left / mean, from("left")),
        ];
        described.take_effect("wheel_radius", &scales);
        described.note(
                "The multipliers of the wheels differ: wheel_radius_m has their mean, and the effect wheel_radius the \
                 difference. A commanded twist counts as turned into wheel speeds by wheel_radius_m",
            );
    }

    /// The names of the wheel joints of a side.
    fn names(&self, side: &str) -> Result<Vec<String>, InputError> {
        // The second is that of ROS 1.
        let keys = [format!("{side}_wheel_names"), format!("{side}_wheel")];
        let Some((key, node)) = keys.iter().find_map(|key| Some((key, self.get(key)?))) else {
            return Ok(Vec::new());
        };
        let nodes = match &node.value {
            Value::List(list) => list.iter().collect(),
            _ => vec![node],
        };
        let name = |node: &Node| match &node.value {
            Value::Scalar { text, .. } => Ok(super::described::one_line(text)),
            other => {
                let problem = format!("has {}", other.kind());
                Err(self.error(
                    key,
                    node,
                    problem,
                    "give the name of a joint or a list of names",
                ))
            }
        };
        nodes.into_iter().map(name).collect()
    }

    fn wheels_per_side(&self, described: &mut Described) -> Result<(), InputError> {
        let named = described
            .wheel_joints
            .iter()
            .map(Vec::len)
            .max()
            .unwrap_or(0);
        let told = self.number("wheels_per_side")?.unwrap_or(0.0);
        if named > 1 || told > 1.0 {
            described.note(
                "Several wheels on each side: the model has one pair. Skid steering turns as if the track were wider, \
                 which `slipstream diagnose` finds as track_width",
            );
        }
        Ok(())
    }
}

/// The mean of two multipliers, exact if they are the same.
fn mean(right: f64, left: f64) -> f64 {
    if right == left {
        right
    } else {
        (right + left) / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(text: &str) -> Described {
        describe(text, Path::new("c.yaml")).unwrap()
    }

    fn error(text: &str) -> String {
        describe(text, Path::new("c.yaml")).unwrap_err().to_string()
    }

    /// A controller with these lines of parameters.
    fn controller(lines: &[&str]) -> String {
        format!("diff:\n  ros__parameters:\n    {}\n", lines.join("\n    "))
    }

    #[test]
    fn multipliers_of_track_and_both_wheels_change_the_lengths() {
        let text = controller(&[
            "wheel_separation: 0.4",
            "wheel_radius: 0.1",
            "wheel_separation_multiplier: 1.25",
            "left_wheel_radius_multiplier: 0.5",
            "right_wheel_radius_multiplier: 0.5",
        ]);
        let model = described(&text).model().unwrap();
        assert_eq!(model.robot.half_track_m, 0.25);
        assert_eq!(model.robot.wheel_radius_m, 0.05);
        assert_eq!(model.effects, []);
    }

    #[test]
    fn wheels_that_differ_are_an_effect() {
        let text = controller(&[
            "wheel_separation: 0.4",
            "wheel_radius: 0.1",
            "left_wheel_radius_multiplier: 0.75",
            "right_wheel_radius_multiplier: 1.25",
        ]);
        let own = described(&text);
        let model = own.model().unwrap();
        assert_eq!(model.robot.wheel_radius_m, 0.1);
        let scales = slipstream_bus::EffectSpec::new(
            "wheel_radius",
            &[("right_scale", 1.25), ("left_scale", 0.75)],
        );
        assert_eq!(model.effects, [scales]);
        assert!(own.notes[0].contains("differ"));
        assert_eq!(own.taken[3].key, "effects.wheel_radius.left_scale");
    }

    #[test]
    fn the_controller_of_ros_1_has_other_names() {
        let text = "base_controller:\n  type: \"diff_drive_controller/DiffDriveController\"\n  left_wheel: 'l'\n  \
                    right_wheel: ['r1', 'r2']\n  wheel_radius: 0.11\n  wheel_radius_multiplier: 2\n  \
                    wheel_separation: 0.54\n";
        let own = described(text);
        assert_eq!(
            own.wheel_joints,
            [vec!["r1".to_owned(), "r2".to_owned()], vec!["l".to_owned()]]
        );
        assert_eq!(own.model().unwrap().robot.wheel_radius_m, 0.22);
        assert_eq!(own.notes.len(), 1);
        let text = text.replace("  wheel_separation: 0.54\n", "");
        let problem = described(&text).model().unwrap_err().problem;
        assert_eq!(
            problem,
            "gives no half_track_m: base_controller has no wheel_separation"
        );
    }

    #[test]
    fn errors_name_line_key_and_remedy() {
        let ok = "wheel_separation: 0.4";
        let cases = [
            (
                controller(&["x: 1"]),
                "c.yaml: has no controller with wheel_separation; give a robot.toml",
            ),
            (
                controller(&["wheel_separation: wide"]),
                "c.yaml:3: wheel_separation is \"wide\"; give a number",
            ),
            (
                controller(&["wheel_separation: '0.4'"]),
                "c.yaml:3: wheel_separation is in quotes; remove",
            ),
            (
                controller(&["wheel_separation: [0.4]"]),
                "c.yaml:3: wheel_separation is a list; give a number",
            ),
            (
                controller(&["wheel_separation: .inf"]),
                "c.yaml:3: wheel_separation is \".inf\"; give",
            ),
            (
                controller(&[ok, "wheel_radius: -1"]),
                "c.yaml: wheel_radius_m is -1 (wheel_radius of diff); give a",
            ),
            (
                controller(&[ok, "wheel_radius: &r 1", "wheel_separation_multiplier: *r"]),
                "c.yaml:5: wheel_separation_multiplier is an alias; give a number",
            ),
            (
                controller(&[ok, "wheel_radius: 1", "left_wheel_radius_multiplier: 0"]),
                "c.yaml:5: left_wheel_radius_multiplier is 0; give a number above 0",
            ),
            (
                controller(&[ok, "left_wheel_names: [[a]]"]),
                "c.yaml:4: left_wheel_names has a list; give the name",
            ),
            (
                format!("{}other:\n  {ok}\n", controller(&[ok])),
                "c.yaml:5: has several controllers with wheels: diff, other; leave one",
            ),
            (format!("a: [1\n{ok}\n"), "c.yaml:"),
        ];
        for (text, message) in cases {
            let error = error(&text);
            assert!(error.starts_with(message), "{error}\n wanted {message}");
        }
    }
}
