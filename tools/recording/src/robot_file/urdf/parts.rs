//! Links and joints as the file has them.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix3, Vector3};
use slipstream_bus::InputError;

use super::transform::{Transform, of_quaternion, of_roll_pitch_yaw};
use crate::robot_file::xml::Element;

/// Most links that are read: of robots with legs and arms some hundred are known.
const MAX_LINKS: usize = 5000;

/// A rigid part.
#[derive(Debug)]
pub(super) struct Link<'a> {
    pub(super) name: &'a str,
    pub(super) element: Element<'a>,
}

/// What connects two links.
#[derive(Debug)]
pub(super) struct Joint<'a> {
    pub(super) name: &'a str,
    /// Whether its child turns about `axis`.
    pub(super) turns: bool,
    /// Whether it turns without end.
    pub(super) is_endless: bool,
    /// Whether its child cannot move in the parent.
    pub(super) is_fixed: bool,
    /// Places of the two links in the list of links.
    pub(super) parent: usize,
    pub(super) child: usize,
    /// The frame of the child in that of the parent.
    pub(super) origin: Transform,
    /// The axis in the frame of the child, of length 1.
    pub(super) axis: Vector3<f64>,
}

/// Links and joints of a file.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    pub(super) links: Vec<Link<'a>>,
    pub(super) joints: Vec<Joint<'a>>,
    /// Names of the joints that have a motor, as far as the file says.
    pub(super) driven: BTreeSet<&'a str>,
    /// For each link, the places of the joints below it.
    below: Vec<Vec<usize>>,
    /// For each link, the place of the joint above it.
    above: Vec<Option<usize>>,
}

impl<'a> Parts<'a> {
    /// # Errors
    /// A name that is missing or given twice, a link that is not there, a link with two parents, a number that
    /// is none.
    pub(super) fn read(root: Element<'a>) -> Result<Self, InputError> {
        let mut links = Vec::new();
        let mut places = BTreeMap::new();
        for element in root.all("link") {
            let name = element.require("name")?;
            if places.insert(name, links.len()).is_some() {
                return Err(element.error(format!("link {name} is there twice"), "rename one"));
            }
            links.push(Link { name, element });
        }
        if links.len() > MAX_LINKS {
            let problem = format!("has more than {MAX_LINKS} links");
            return Err(root.error(problem, "give the URDF of one robot"));
        }
        let mut joints: Vec<Joint<'_>> = Vec::new();
        let mut names = BTreeSet::new();
        let mut children = BTreeMap::new();
        for element in root.all("joint") {
            let joint = joint(element, &places)?;
            let name = joint.name;
            if !names.insert(name) {
                return Err(element.error(format!("joint {name} is there twice"), "rename one"));
            }
            if let Some(other) = children.insert(joint.child, name) {
                let child = links.get(joint.child).map_or("", |link| link.name);
                let problem = format!("link {child} is the child of {other} and of {name}");
                return Err(element.error(problem, "leave it one parent"));
            }
            joints.push(joint);
        }
        let mut below = vec![Vec::new(); links.len()];
        let mut above = vec![None; links.len()];
        for (place, joint) in joints.iter().enumerate() {
            below[joint.parent].push(place);
            above[joint.child] = Some(place);
        }
        Ok(Self {
            links,
            joints,
            driven: driven(root),
            below,
            above,
        })
    }

    /// A link and all that move with it: its descendants.
    pub(super) fn descendants(&self, link: usize) -> Vec<usize> {
        self.reached(link, |_| true)
    }

    /// A link and what is fixed to it below.
    pub(super) fn fixed_below(&self, link: usize) -> Vec<usize> {
        self.reached(link, |joint| joint.is_fixed)
    }

    /// The uppermost link that a link is fixed to; itself if it is fixed to none. Links with the same one are one body.
    pub(super) fn top(&self, link: usize) -> usize {
        let fixed_above = self.above(link).take_while(|joint| joint.is_fixed);
        fixed_above.last().map_or(link, |joint| joint.parent)
    }

    /// The joints above a link, from the nearest up.
    pub(super) fn above(&self, link: usize) -> impl Iterator<Item = &Joint<'a>> {
        let up = move |link: usize| {
            let joint = self.above.get(link).copied().flatten();
            joint.and_then(|joint| self.joints.get(joint))
        };
        // A circle of joints has no top.
        let first = up(link);
        std::iter::successors(first, move |joint| up(joint.parent)).take(self.joints.len())
    }

    /// The joints directly below a link.
    pub(super) fn joints_below(&self, link: usize) -> impl Iterator<Item = &Joint<'a>> {
        let places = self.below.get(link).into_iter().flatten();
        places.filter_map(|place| self.joints.get(*place))
    }

    /// A link and those below it, over joints of a kind.
    fn reached(&self, link: usize, over: impl Fn(&Joint<'_>) -> bool) -> Vec<usize> {
        let mut found = vec![link];
        let mut seen = BTreeSet::from([link]);
        let mut next = 0;
        while let Some(&parent) = found.get(next) {
            next += 1;
            let joints = self.joints_below(parent).filter(|joint| over(joint));
            found.extend(
                joints
                    .map(|joint| joint.child)
                    .filter(|child| seen.insert(*child)),
            );
        }
        found
    }

    /// The name of a link.
    pub(super) fn name(&self, link: usize) -> &'a str {
        self.links.get(link).map_or("", |link| link.name)
    }
}

fn joint<'a>(
    element: Element<'a>,
    places: &BTreeMap<&str, usize>,
) -> Result<Joint<'a>, InputError> {
    let name = element.require("name")?;
    let kind = element.require("type")?;
    let link = |end: &'static str| {
        let inside = element.first(end);
        let inside = inside.ok_or_else(|| {
            element.error(
                format!("joint {name} has no <{end}>"),
                format!("add <{end} link=\"…\"/>"),
            )
        })?;
        let link = inside.require("link")?;
        places.get(link).copied().ok_or_else(|| {
            let problem =
                format!("joint {name} has the {end} {link}, which is no link of the file");
            inside.error(problem, "write the name of a <link>")
        })
    };
    let (parent, child) = (link("parent")?, link("child")?);
    let turns = matches!(kind, "continuous" | "revolute");
    let axis = match element.first("axis") {
        Some(axis) if turns => {
            let along = axis.numbers("xyz")?.map(Vector3::from);
            let along = along.unwrap_or_else(Vector3::x).try_normalize(1e-9);
            along.ok_or_else(|| {
                axis.error(format!("the axis of {name} is 0 0 0"), "give a direction")
            })?
        }
        _ => Vector3::x(),
    };
    Ok(Joint {
        name,
        turns,
        is_endless: kind == "continuous" || (kind == "revolute" && is_without_end(element)?),
        is_fixed: kind == "fixed",
        parent,
        child,
        origin: origin(element)?,
        axis,
    })
}

/// Whether a joint with limits has none in truth: several turns, or a range that is none.
fn is_without_end(joint: Element<'_>) -> Result<bool, InputError> {
    let Some(limit) = joint.first("limit") else {
        return Ok(true);
    };
    let [lower, upper] = [limit.number("lower")?, limit.number("upper")?];
    let range_rad = upper.unwrap_or(0.0) - lower.unwrap_or(0.0);
    Ok(range_rad <= 0.0 || range_rad >= 2.0 * std::f64::consts::TAU)
}

/// The frame that `<origin>` of an element gives.
///
/// # Errors
/// A number that is none.
pub(super) fn origin(of: Element<'_>) -> Result<Transform, InputError> {
    let Some(origin) = of.first("origin") else {
        return Ok(Transform::identity());
    };
    let offset = origin
        .numbers("xyz")?
        .map_or_else(Vector3::zeros, Vector3::from);
    let rotation = match (origin.numbers("rpy")?, origin.numbers("quat_xyzw")?) {
        (Some(angles), _) => of_roll_pitch_yaw(angles),
        (None, Some(quaternion)) => of_quaternion(quaternion)
            .ok_or_else(|| origin.error("quat_xyzw is 0 0 0 0", "give a rotation"))?,
        (None, None) => Matrix3::identity(),
    };
    Ok(Transform { rotation, offset })
}

/// The joints that a transmission or ros2_control drives.
fn driven<'a>(root: Element<'a>) -> BTreeSet<&'a str> {
    let transmitted = root.all("transmission").flat_map(|own| own.all("joint"));
    let controlled = root.all("ros2_control").flat_map(|own| own.all("joint"));
    let commanded = controlled.filter(|joint| joint.first("command_interface").is_some());
    transmitted
        .chain(commanded)
        .filter_map(|joint| joint.attribute("name"))
        .collect()
}
