//! Masses and inertias. They make a model only all together: a part of them would change what is declared of
//! poses without making the model dynamic.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};
use slipstream_bus::InputError;

use super::frames::Frames;
use super::parts::{Link, Parts, origin};
use super::transform::Transform;
use super::wheels::{Wheel, Wheels};
use crate::robot_file::described::{Described, Taken, in_words};
use crate::robot_file::xml::Element;

/// Least mass of a part that is seen (kg): less stands for none.
const LEAST_MASS_KG: f64 = 1e-3;
/// Least radius of gyration of a part (m): less stands for none, such as 1e-6 kg m² at 1 kg.
const LEAST_GYRATION_M: f64 = 2e-3;
/// Largest radius of gyration in half tracks (1): more stands for none, such as 1 kg m² at 1 kg.
const LARGEST_GYRATION: f64 = 5.0;
/// How far the centre of mass may lie beside the middle before it is said (m).
const BESIDE_M: f64 = 1e-3;

/// The mass of one part or of several.
#[derive(Debug, Clone, Copy)]
struct Inertial {
    mass_kg: f64,
    /// Centre of mass, frame of the base (m).
    centre: Vector3<f64>,
    /// Inertia about that, axes of the base (kg m²).
    tensor: Matrix3<f64>,
}

/// Takes the masses, if all parts have them and they make a model; else says why not.
///
/// # Errors
/// A number that is none.
pub(super) fn take(
    parts: &Parts<'_>,
    frames: &Frames,
    wheels: &Wheels<'_>,
    lengths: [f64; 2],
    described: &mut Described,
) -> Result<(), InputError> {
    let mut inertials = Vec::new();
    for (place, link) in parts.links.iter().enumerate() {
        let Some(frame) = frames.get(place) else {
            continue;
        };
        match inertial(link, frame, lengths[1])? {
            Ok(Some(own)) => inertials.push((place, own)),
            Ok(None) => {}
            Err(problem) => {
                described.note(format!(
                    "Masses and inertias are left out: link {} {problem}",
                    link.name
                ));
                return Ok(());
            }
        }
    }
    let (Some([right, left]), true) = (wheels.rear(), wheels.are_two()) else {
        described.note("Masses and inertias are left out: the model's are those of two driven wheels and a caster");
        return Ok(());
    };
    let of_wheels = [right, left].map(|wheel| parts.descendants(wheel.link));
    let wheel_links: BTreeSet<usize> = of_wheels.iter().flatten().copied().collect();
    let of = |is_in: &dyn Fn(usize) -> bool| {
        let own = inertials.iter().filter(|(link, _)| is_in(*link));
        together(&own.map(|(_, inertial)| *inertial).collect::<Vec<_>>())
    };
    let body = of(&|link| !wheel_links.contains(&link));
    let [right_mass, left_mass] = of_wheels.map(|links| of(&|link| links.contains(&link)));
    let (Some(body), Some(right_mass), Some(left_mass)) = (body, right_mass, left_mass) else {
        described.note("Masses and inertias are left out: the file gives none of body or wheels");
        return Ok(());
    };
    let caster_x = caster(parts, frames, &wheel_links, described)?;
    let pair = Pair {
        wheels: [right, left],
        masses: [right_mass, left_mass],
    };
    let (values, problem) = values(&body, &pair, lengths[0], caster_x);
    let problem = problem.or_else(|| {
        let refused = described.take_masses(&values).err()?;
        Some(format!("{} {}", refused.place, refused.problem))
    });
    match problem {
        Some(problem) => {
            described.note(format!("Masses and inertias are left out: {problem}"));
            let finite = values.into_iter().filter(|own| own.value.is_finite());
            described.left_out.extend(finite);
        }
        None => described.note(
            "com_to_axle_m is known: poses count as those of the centre of mass, unless recording.toml says pose_point = \
             \"axle\"",
        ),
    }
    note_asymmetry(&body, &pair, described);
    Ok(())
}

/// The driven wheels with their masses, right and left.
struct Pair<'a> {
    wheels: [Wheel<'a>; 2],
    masses: [Inertial; 2],
}

impl Pair<'_> {
    /// The mean of a quantity.
    fn mean(&self, of: impl Fn(&Wheel<'_>, &Inertial) -> f64) -> f64 {
        let [right, left] = [0, 1].map(|i| of(&self.wheels[i], &self.masses[i]));
        right / 2.0 + left / 2.0
    }
}

/// The values of `[robot]`, and what is missing for a dynamic model.
fn values(
    body: &Inertial,
    pair: &Pair<'_>,
    radius_m: f64,
    caster_x: Result<f64, &'static str>,
) -> (Vec<Taken>, Option<String>) {
    let axle = |of: fn(&Vector3<f64>) -> f64| pair.mean(|wheel, _| of(&wheel.centre));
    let ahead_m = body.centre.x - axle(|centre| centre.x);
    let height_m = body.centre.z - axle(|centre| centre.z) + radius_m;
    let all = "all links but the wheels";
    let wheel = "mean of the wheel links";
    let mut values = vec![
        Taken::new("body_mass_kg", body.mass_kg, format!("mass of {all}")),
        Taken::new(
            "body_yaw_inertia_kg_m2",
            body.tensor[(2, 2)],
            format!("{all}, about their centre of mass"),
        ),
        Taken::new("wheel_mass_kg", pair.mean(|_, own| own.mass_kg), wheel),
        Taken::new(
            "wheel_spin_inertia_kg_m2",
            pair.mean(spin),
            format!("{wheel}, about the axle"),
        ),
        Taken::new(
            "wheel_yaw_inertia_kg_m2",
            pair.mean(|_, own| own.tensor[(2, 2)]),
            format!("{wheel}, about its vertical"),
        ),
        Taken::new(
            "com_to_axle_m",
            ahead_m,
            format!("x of the centre of mass of {all}, less that of the wheel joints"),
        ),
    ];
    let problem = match caster_x {
        Ok(x_m) => {
            let from = "x of the caster, less that of the centre of mass";
            values.push(Taken::new("com_to_caster_m", x_m - body.centre.x, from));
            None
        }
        Err(problem) => Some(problem.to_owned()),
    };
    let from = "z of the centre of mass over that of the wheel joints, and the radius";
    values.push(Taken::new("com_height_m", height_m, from));
    (values, problem)
}

/// Inertia of a wheel about its axle (kg m²).
fn spin(wheel: &Wheel<'_>, own: &Inertial) -> f64 {
    let arm = own.centre - wheel.centre;
    let across = arm - wheel.axle * arm.dot(&wheel.axle);
    wheel.axle.dot(&(own.tensor * wheel.axle)) + own.mass_kg * across.norm_squared()
}

/// What the model cannot say of masses.
fn note_asymmetry(body: &Inertial, pair: &Pair<'_>, described: &mut Described) {
    let beside_m = body.centre.y - pair.mean(|wheel, _| wheel.centre.y);
    if beside_m.abs() > BESIDE_M {
        let beside = in_words(beside_m);
        described.note(format!(
            "The centre of mass lies at y = {beside}, which the model leaves out"
        ));
    }
    let [right, left] = pair.masses.map(|own| own.mass_kg);
    if (right - left).abs() > 0.01 * (right + left) {
        described.note("The masses of the wheels differ; their mean counts");
    }
}

/// The mass of a link: `None` for a frame without shape and mass; or what is wrong with it.
fn inertial(
    link: &Link<'_>,
    frame: Transform,
    half_track_m: f64,
) -> Result<Result<Option<Inertial>, String>, InputError> {
    let is_seen = ["visual", "collision"]
        .iter()
        .any(|shape| link.element.first(shape).is_some());
    let mass = link
        .element
        .first("inertial")
        .map(|own| Ok::<_, InputError>((own, mass(own)?)));
    let Some((element, mass_kg)) = mass.transpose()? else {
        return Ok(if is_seen {
            Err("has a shape and no mass".to_owned())
        } else {
            Ok(None)
        });
    };
    if mass_kg < LEAST_MASS_KG {
        let problem = format!("has a mass of {mass_kg} kg, which stands for none");
        return Ok(if is_seen { Err(problem) } else { Ok(None) });
    }
    let own = frame.then(&origin(element)?);
    let local = tensor(element)?;
    let gyration = |inertia: f64| (inertia / mass_kg).sqrt();
    let moments = local.diagonal();
    let positive = moments.min() > 0.0;
    let triangle = moments.sum() - 2.0 * moments.max() >= -1e-3 * moments.sum();
    let sizes = gyration(moments.max()) >= LEAST_GYRATION_M
        && gyration(moments.max()) <= LARGEST_GYRATION * half_track_m;
    if !(positive && triangle && sizes) {
        let moments = format!("{} {} {}", moments.x, moments.y, moments.z);
        return Ok(Err(format!(
            "has inertias of {moments} kg m² at {mass_kg} kg, which no body has"
        )));
    }
    let tensor = own.rotation * local * own.rotation.transpose();
    Ok(Ok(Some(Inertial {
        mass_kg,
        centre: own.offset,
        tensor,
    })))
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
fn together(parts: &[Inertial]) -> Option<Inertial> {
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

/// x of the only caster (m), or why there is none.
fn caster(
    parts: &Parts<'_>,
    frames: &Frames,
    wheels: &BTreeSet<usize>,
    described: &mut Described,
) -> Result<Result<f64, &'static str>, InputError> {
    let is_caster = |link: usize| {
        let name = parts.name(link).to_lowercase();
        (name.contains("caster") || name.contains("castor")) && !wheels.contains(&link)
    };
    let all: Vec<usize> = (0..parts.links.len())
        .filter(|link| is_caster(*link))
        .collect();
    // Of a fork and its wheel, the wheel.
    let last = all.iter().filter(|link| {
        let below = parts.descendants(**link);
        below.iter().skip(1).all(|other| !is_caster(*other))
    });
    let last: Vec<usize> = last.copied().collect();
    match last.as_slice() {
        [] => Ok(Err(
            "no link is called a caster, and com_to_caster_m is not known",
        )),
        [one] => {
            let link = parts.links.get(*one).map(|link| link.element);
            let shape = link.and_then(|own| own.first("collision").or_else(|| own.first("visual")));
            let shape = shape.map_or(Ok(Transform::identity()), origin)?;
            let frame = frames.get(*one).map(|frame| frame.then(&shape));
            Ok(frame
                .map(|frame| frame.offset.x)
                .ok_or("nothing connects the caster with the base"))
        }
        several => {
            described.note(format!(
                "{} casters: the model has one, ahead of the centre of mass",
                several.len()
            ));
            Ok(Err("com_to_caster_m is not known of several casters"))
        }
    }
}
