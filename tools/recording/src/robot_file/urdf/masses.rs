//! Masses and inertias. They make a model only all together: a part of them would change what is declared of
//! poses without making the model dynamic.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use slipstream_bus::InputError;

use super::candidates::Wheel;
use super::frames::Frames;
use super::inertia::{self, Inertial, Mass, together};
use super::parts::{Parts, origin};
use super::transform::Transform;
use super::wheels::Wheels;
use crate::robot_file::described::{Described, Taken};
use crate::robot_file::words::{in_words, list};

/// A part below this share of the mass never spoils the others (1).
const SMALL: f64 = 0.01;
/// How far the centre of mass may lie beside the middle before it is said (m).
const BESIDE_M: f64 = 1e-3;

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
    let (Some([right, left]), true) = (wheels.rear(), wheels.are_two()) else {
        described.note("Masses and inertias are left out: the model's are those of two driven wheels and a caster");
        return Ok(());
    };
    let of_wheels = [right, left].map(|wheel| parts.descendants(wheel.link));
    let wheel_links: BTreeSet<usize> = of_wheels.iter().flatten().copied().collect();
    let inertials = match inertials(parts, frames, &wheel_links, lengths[1], described)? {
        Ok(inertials) => inertials,
        Err(problem) => {
            described.note(format!("Masses and inertias are left out: {problem}"));
            return Ok(());
        }
    };
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
    let pair = WheelMasses {
        wheels: [right, left],
        masses: [right_mass, left_mass],
    };
    let (values, problem) = values(&body, &pair, lengths[0], caster_x);
    let problem = problem.or_else(|| {
        let refused = described.take_masses(&values).err()?;
        Some(format!("{} {}", refused.place, refused.problem))
    });
    if let Some(problem) = problem {
        described.note(format!("Masses and inertias are left out: {problem}"));
        let finite = values.into_iter().filter(|own| own.value.is_finite());
        described.left_out.extend(finite);
    }
    note_asymmetry(&body, &pair, described);
    Ok(())
}

/// The masses of the links that have one; or why they make no model. What is less than a hundredth of all, or of no body,
/// never spoils the others.
fn inertials(
    parts: &Parts<'_>,
    frames: &Frames,
    wheel_links: &BTreeSet<usize>,
    half_track_m: f64,
    described: &mut Described,
) -> Result<Result<Vec<(usize, Inertial)>, String>, InputError> {
    let mut known = Vec::new();
    let mut points = Vec::new();
    let mut without = Vec::new();
    for (place, link) in parts.links.iter().enumerate() {
        let Some(frame) = frames.get(place) else {
            continue;
        };
        match inertia::of_link(link, frame, half_track_m)? {
            Mass::Known(own) => known.push((place, own)),
            Mass::Point(own, problem) => points.push((place, own, problem)),
            Mass::None(Some(problem)) => without.push((place, problem)),
            Mass::None(None) => {}
        }
    }
    let all = known.iter().map(|(_, own)| own.mass_kg);
    let total_kg = all
        .chain(points.iter().map(|(_, own, _)| own.mass_kg))
        .sum::<f64>();
    for (place, own, problem) in points {
        if own.mass_kg > SMALL * total_kg || wheel_links.contains(&place) {
            return Ok(Err(format!("link {} {problem}", parts.name(place))));
        }
        let (name, mass_kg) = (parts.name(place), own.mass_kg);
        described.note(format!(
            "Link {name} ({mass_kg} kg) counts as a point: it {problem}"
        ));
        known.push((place, own));
    }
    // Links that are fixed to each other are one body: its mass may stand in any of them.
    let massive: BTreeSet<usize> = known.iter().map(|(place, _)| parts.top(*place)).collect();
    let of_base = parts.top(frames.base);
    let mut massless = Vec::new();
    for (place, problem) in without {
        let top = parts.top(place);
        if massive.contains(&top) {
            continue;
        }
        if top == of_base || wheel_links.contains(&place) {
            return Ok(Err(format!("link {} {problem}", parts.name(place))));
        }
        massless.push(parts.name(place));
    }
    if !massless.is_empty() {
        described.note(format!(
            "Without a mass, so counted as none: {}",
            list(massless.iter().copied())
        ));
    }
    Ok(Ok(known))
}

/// The driven wheels with their masses, right and left.
struct WheelMasses<'a> {
    wheels: [&'a Wheel<'a>; 2],
    masses: [Inertial; 2],
}

impl WheelMasses<'_> {
    /// The mean of a quantity.
    fn mean(&self, of: impl Fn(&Wheel<'_>, &Inertial) -> f64) -> f64 {
        let [right, left] = [0, 1].map(|i| of(self.wheels[i], &self.masses[i]));
        right / 2.0 + left / 2.0
    }
}

/// The values of `[robot]`, and what is missing for a dynamic model.
fn values(
    body: &Inertial,
    pair: &WheelMasses<'_>,
    radius_m: f64,
    caster_x: Result<f64, &'static str>,
) -> (Vec<Taken>, Option<String>) {
    let axle = |of: fn(&Vector3<f64>) -> f64| pair.mean(|wheel, _| of(&wheel.joint_at));
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
    let arm = own.centre - wheel.joint_at;
    let across = arm - wheel.axle * arm.dot(&wheel.axle);
    wheel.axle.dot(&(own.tensor * wheel.axle)) + own.mass_kg * across.norm_squared()
}

/// What the model cannot say of masses.
fn note_asymmetry(body: &Inertial, pair: &WheelMasses<'_>, described: &mut Described) {
    let beside_m = body.centre.y - pair.mean(|wheel, _| wheel.joint_at.y);
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
