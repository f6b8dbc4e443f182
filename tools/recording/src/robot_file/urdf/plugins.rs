//! Drive plugins inside of a URDF: of Gazebo, classic and new, and the hardware of ros2_control.

use slipstream_bus::InputError;

use super::parts::Parts;
use crate::robot_file::drive::{Drive, Sort};
use crate::robot_file::parameter_names::{names_joints, quantity_of};
use crate::robot_file::words::one_line;
use crate::robot_file::xml::Element;
use crate::sides::side_of;

/// The drives that plugins of the file are told, in the order of the file.
///
/// # Errors
/// A length that is in no known unit.
pub(super) fn drives(root: Element<'_>, parts: &Parts<'_>) -> Result<Vec<Drive>, InputError> {
    let mut drives = Vec::new();
    for plugin in root.below("plugin") {
        // Simulators name the library by the attribute, ros2_control by the text.
        let attributes = ["filename", "name"].map(|own| plugin.attribute(own).unwrap_or_default());
        let title = attributes
            .into_iter()
            .find(|own| !own.is_empty())
            .unwrap_or_default();
        let sort = attributes.iter().find_map(|own| Sort::of_words(own));
        let drive = Drive {
            sort: sort.unwrap_or_default(),
            type_name: Some(one_line(title)),
            ..Drive::named(format!("plugin {}", one_line(title)))
        };
        let drive = with_parameters(drive, plugin.elements().map(parameter), parts)?;
        if drive.says_something() || sort.is_some_and(|own| own != Sort::Differential) {
            drives.push(drive);
        }
    }
    for hardware in root.below("hardware") {
        let parameters = hardware.all("param").map(|own| {
            let name = own.attribute("name").unwrap_or_default();
            PluginParameter {
                name,
                value: own.text(),
                element: own,
            }
        });
        let drive = with_parameters(Drive::named("hardware of ros2_control"), parameters, parts)?;
        if drive.says_something() || drive.counts_per_rev.is_some() {
            drives.push(drive);
        }
    }
    Ok(drives)
}

/// The files of parameters that plugins name, such as that of a controller.
pub(super) fn parameter_files(root: Element<'_>) -> Vec<&str> {
    let files = root.below("parameters").map(|own| own.text().trim());
    files
        .filter(|name| {
            [".yaml", ".yml"]
                .iter()
                .any(|ending| name.ends_with(ending))
        })
        .collect()
}

/// A parameter of a plugin.
struct PluginParameter<'a> {
    name: &'a str,
    value: &'a str,
    element: Element<'a>,
}

/// In plugins, every parameter is an element.
fn parameter(element: Element<'_>) -> PluginParameter<'_> {
    PluginParameter {
        name: element.name(),
        value: element.text(),
        element,
    }
}

/// A drive with what its parameters say. The first of several values of one parameter counts, as of several wheel pairs.
fn with_parameters<'a>(
    mut drive: Drive,
    parameters: impl Iterator<Item = PluginParameter<'a>>,
    parts: &Parts<'_>,
) -> Result<Drive, InputError> {
    for PluginParameter {
        name,
        value,
        element,
    } in parameters
    {
        let value = value.trim();
        if names_joints(name)
            && let Some(side) = side_of(name)
        {
            let names = value
                .split([' ', ',', '\n', '\t'])
                .filter(|own| !own.is_empty());
            let is_joint = |own: &&str| parts.joints.iter().any(|joint| joint.name == *own);
            drive.joints[side as usize].extend(names.filter(is_joint).map(one_line));
            continue;
        }
        let number = value
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite());
        if let (Some(quantity), Some(number)) = (quantity_of(name), number) {
            let taken = drive.take(&one_line(name), quantity, number);
            taken.map_err(|problem| {
                element.error(format!("{name} {problem}"), "give it in metres")
            })?;
        }
    }
    Ok(drive.complete())
}
