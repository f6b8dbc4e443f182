//! The mass of a link, and of several together.

use nalgebra::{Matrix3, Vector3};
use slipstream_bus::InputError;

use super::parts::{Link, origin};
use super::transform::Transform;
use crate::robot_file::xml::Element;

/// Least mass of a part that is seen (kg): less stands for none.
const LEAST_MASS_KG: f64 = 1e-3;
/// Least radius of gyration of a part (m): less stands for none, such as 1e-6 kg m² at 1 kg.
const LEAST_GYRATION_M: f64 = 2e-3;
/// Largest radius of gyration in half tracks (1): more stands for none, such as 1 kg m² at 1 kg.
const LARGEST_GYRATION: f64 = 5.0;

/// The mass of one part or of several.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inertial {
    pub(super) mass_kg: f64,
    /// Centre of mass, frame of the base (m).
    pub(super) centre: Vector3<f64>,
    /// Inertia about that, axes of the base (kg m²).
    pub(super) tensor: Matrix3<f64>,
}

/// What a link says of its mass.
#[derive(Debug, Clone)]
pub(super) enum Mass {
    /// It has one.
    Known(Inertial),
    /// It has one as a point, since no body has its inertias; with what is wrong.
    Point(Inertial, String),
    /// It has none; with what is wrong where it is more than a frame.
    None(Option<String>),
}

/// The mass of a link. Larger radii of gyration than a robot with this half track has stand for none.
///
/// # Errors
/// A number that is none.
pub(super) fn of_link(
    link: &Link<'_>,
    frame: Transform,
    half_track_m: f64,
) -> Result<Mass, InputError> {
    let is_seen = ["visual", "collision"]
        .iter()
        .any(|shape| link.element.first(shape).is_some());
    let Some(element) = link.element.first("inertial") else {
        return Ok(Mass::None(
            is_seen.then(|| "has a shape and no mass".to_owned()),
        ));
    };
    let mass_kg = mass(element)?;
    if mass_kg < LEAST_MASS_KG {
        let problem = format!("has a mass of {mass_kg} kg, which stands for none");
        return Ok(Mass::None(is_seen.then_some(problem)));
    }
    let own = frame.then(&origin(element)?);
    let local = tensor(element)?;
    let point = Inertial {
        mass_kg,
        centre: own.offset,
        tensor: Matrix3::zeros(),
    };
    let gyration = |inertia: f64| (inertia / mass_kg).sqrt();
    let moments = local.diagonal();
    let positive = moments.min() > 0.0;
    let triangle = moments.sum() - 2.0 * moments.max() >= -1e-3 * moments.sum();
    let sizes = gyration(moments.max()) >= LEAST_GYRATION_M
        && gyration(moments.max()) <= LARGEST_GYRATION * half_track_m;
    if !(positive && triangle && sizes) {
        let moments = format!("{} {} {}", moments.x, moments.y, moments.z);
        let problem = format!("has inertias of {moments} kg m² at {mass_kg} kg, which no body has");
        return Ok(Mass::Point(point, problem));
    }
    let tensor = own.rotation * local * own.rotation.transpose();
    Ok(Mass::Known(Inertial { tensor, ..point }))
}

fn mass(inertial: Element<'_>) -> Result<f64, InputError> {
    let mass = inertial
        .first("mass")
        .map(|mass| mass.number("value"))
        .transpose()?;
    Ok(mass.flatten().unwrap_or(0.0))
}

/// The inertia that the file gives (kg m²).
fn tensor(inertial: Element<'_>) -> Result<Matrix3<f64>, InputError> {
    let Some(element) = inertial.first("inertia") else {
        return Ok(Matrix3::zeros());
    };
    let number = |name: &str| Ok::<f64, InputError>(element.number(name)?.unwrap_or(0.0));
    let [xx, yy, zz] = [number("ixx")?, number("iyy")?, number("izz")?];
    let [xy, xz, yz] = [number("ixy")?, number("ixz")?, number("iyz")?];
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// Several masses as one, about their common centre; `None` of none.
pub(super) fn together(parts: &[Inertial]) -> Option<Inertial> {
    if let [one] = parts {
        return Some(*one);
    }
    let mass_kg: f64 = parts.iter().map(|own| own.mass_kg).sum();
    let moment: Vector3<f64> = parts.iter().map(|own| own.centre * own.mass_kg).sum();
    let centre = moment / mass_kg;
    // The parallel-axis theorem.
    let moved = parts.iter().map(|own| {
        let arm = own.centre - centre;
        let of_point = Matrix3::from_diagonal_element(arm.norm_squared()) - arm * arm.transpose();
        own.tensor + of_point * own.mass_kg
    });
    let tensor = moved.fold(Matrix3::zeros(), |sum, own| sum + own);
    (mass_kg > 0.0).then_some(Inertial {
        mass_kg,
        centre,
        tensor,
    })
}
