//! The frames of all links in that of the base, with x forward and y to the left.

use nalgebra::{Matrix3, Vector3};

use super::parts::Parts;
use super::transform::Transform;

/// Where every link is.
#[derive(Debug)]
pub(super) struct Frames {
    /// The link in whose frame the others are given.
    pub(super) base: usize,
    /// The frame of each link; `None` if nothing connects it with the base.
    frames: Vec<Option<Transform>>,
}

impl Frames {
    /// The frames; `None` without any link.
    pub(super) fn of(parts: &Parts<'_>) -> Option<Self> {
        let base = base(parts)?;
        let mut frames = vec![None; parts.links.len()];
        frames[base] = Some(Transform::identity());
        // Up and down from the base.
        let mut found = vec![base];
        let mut next = 0;
        let neighbours = neighbours(parts);
        while let Some(&link) = found.get(next) {
            next += 1;
            let Some(frame) = frames[link] else {
                continue;
            };
            for (other, step) in &neighbours[link] {
                if frames[*other].is_none() {
                    frames[*other] = Some(frame.then(step));
                    found.push(*other);
                }
            }
        }
        Some(Self { base, frames })
    }

    /// The same frames in a base whose x points along y of this one.
    pub(super) fn along_y(&self) -> Self {
        let turn = Transform {
            rotation: Matrix3::new(0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
            offset: Vector3::zeros(),
        };
        let turned = self
            .frames
            .iter()
            .map(|frame| frame.map(|own| turn.then(&own)));
        Self {
            base: self.base,
            frames: turned.collect(),
        }
    }

    /// The frame of a link.
    pub(super) fn get(&self, link: usize) -> Option<Transform> {
        self.frames.get(link).copied().flatten()
    }
}

/// For each link, the links at its joints and where they are in its frame.
fn neighbours(parts: &Parts<'_>) -> Vec<Vec<(usize, Transform)>> {
    let mut neighbours = vec![Vec::new(); parts.links.len()];
    for joint in &parts.joints {
        neighbours[joint.parent].push((joint.child, joint.origin));
        neighbours[joint.child].push((joint.parent, joint.origin.inverse()));
    }
    neighbours
}

/// The link `base_link`, one whose name ends so, or the one that is nobody's child.
fn base(parts: &Parts<'_>) -> Option<usize> {
    let named = |is: &dyn Fn(&str) -> bool| parts.links.iter().position(|link| is(link.name));
    let is_child = |link: &usize| parts.joints.iter().any(|joint| joint.child == *link);
    named(&|name| name == "base_link")
        .or_else(|| named(&|name| name.ends_with("base_link")))
        .or_else(|| (0..parts.links.len()).find(|link| !is_child(link)))
        .or_else(|| (!parts.links.is_empty()).then_some(0))
}
