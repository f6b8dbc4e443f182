//! The round shape of a wheel: its radius, and where its middle is.

use nalgebra::Vector3;
use slipstream_bus::InputError;

use super::frames::Frames;
use super::parts::{Parts, origin};
use super::transform::Transform;
use crate::robot_file::xml::Element;

/// Radii that differ by less are the same (m).
const SAME_M: f64 = 1e-6;
/// Least share of a cylinder's axis that lies along its axle (1).
const ALONG: f64 = 0.9;

/// The shape of a wheel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Round {
    pub(super) radius_m: f64,
    /// Its middle in the frame of the base (m).
    pub(super) middle: Vector3<f64>,
    /// Whether it lies along the axle.
    pub(super) is_along: bool,
    /// What it is, such as `cylinder of link left_wheel, collision`.
    pub(super) from: String,
}

/// The largest round shape of a link and of what is fixed to it: what it collides with, else what is seen. The middle is
/// that of all shapes of this radius, such as those of twin tyres.
///
/// # Errors
/// A number of a shape that is none.
pub(super) fn of_link(
    parts: &Parts<'_>,
    frames: &Frames,
    link: usize,
    axle: Vector3<f64>,
) -> Result<Option<Round>, InputError> {
    for kind in ["collision", "visual"] {
        let mut shapes: Vec<Round> = Vec::new();
        for link in parts.fixed_below(link) {
            let Some(own) = parts.links.get(link) else {
                continue;
            };
            let frame = frames.get(link).unwrap_or_else(Transform::identity);
            for shape in own.element.all(kind) {
                if let Some((name, radius_m)) = radius_of(shape)? {
                    let frame = frame.then(&origin(shape)?);
                    // A cylinder stands along z.
                    let along = frame.rotation.column(2).dot(&axle).abs();
                    shapes.push(Round {
                        radius_m,
                        middle: frame.offset,
                        is_along: name == "sphere" || along >= ALONG,
                        from: format!("{name} of link {}, {kind}", own.name),
                    });
                }
            }
        }
        let largest_m = shapes
            .iter()
            .map(|own| own.radius_m)
            .fold(f64::NEG_INFINITY, f64::max);
        shapes.retain(|own| own.radius_m >= largest_m - SAME_M);
        let count = shapes.len();
        if let Some(first) = shapes.first() {
            let middle: Vector3<f64> = shapes.iter().map(|own| own.middle / count as f64).sum();
            return Ok(Some(Round {
                middle,
                ..first.clone()
            }));
        }
    }
    Ok(None)
}

/// Name and radius of a shape, if it is round.
fn radius_of(shape: Element<'_>) -> Result<Option<(&'static str, f64)>, InputError> {
    let Some(geometry) = shape.first("geometry") else {
        return Ok(None);
    };
    for name in ["cylinder", "sphere", "capsule"] {
        if let Some(round) = geometry.first(name) {
            return Ok(round.number("radius")?.map(|radius_m| (name, radius_m)));
        }
    }
    Ok(None)
}
