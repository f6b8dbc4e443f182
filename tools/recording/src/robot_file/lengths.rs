//! The lengths of a model, of all that files say about them.
//!
//! A controller reckons with its own lengths, times its multipliers. Without one, the shapes of the wheels count, then
//! the plugins of a simulator, then where the joints of the wheels are.

use super::described::{Described, Missing};
use super::drive::{Drive, Length, Multipliers, first_of};

/// What to do where no track is known.
pub(super) const MEASURE_TRACK: &str =
    "measure the distance between the middles of the wheels and write half of it";
/// What to do where no radius is known.
pub(super) const MEASURE_RADIUS: &str = "measure the radius of the wheels under load and write it";
/// What to know where a robot has more wheels than the model.
pub(super) const ONE_PAIR: &str = "the model has one pair. Skid steering turns as if the track were wider, which \
                                   `slipstream diagnose` finds as track_width";

/// What the links and joints of a robot say.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    /// Radius of the wheels' shapes.
    pub(super) radius: Option<Length>,
    /// Half of the distance between the middles of the wheels' shapes.
    pub(super) half_track: Option<Length>,
    /// Half of the distance between the wheels' joints.
    pub(super) half_track_of_joints: Option<Length>,
    /// What to do where nothing says the radius, or the track.
    pub(super) missing: Vec<Missing>,
}

/// Takes the lengths. `controllers` are of files of their own, `plugins` of the description of the robot.
pub(super) fn take(
    controllers: &[Drive],
    plugins: &[Drive],
    geometry: Geometry,
    described: &mut Described,
) {
    let each = |drives: &[Drive], of: fn(&Drive) -> Option<Length>| -> Vec<Option<Length>> {
        drives.iter().map(of).collect()
    };
    let radius = |own: &Drive| own.radius.clone();
    let mut radii = each(controllers, radius);
    radii.push(geometry.radius);
    radii.extend(each(plugins, radius));
    let (radius, contradictions) = first_of("the wheel radius", radii);
    let mut tracks = each(controllers, Drive::half_track);
    tracks.push(geometry.half_track);
    tracks.extend(each(plugins, Drive::half_track));
    // Where a shape or a plugin tells the track, joints beside it contradict nothing.
    let is_known = tracks.iter().any(Option::is_some);
    tracks.extend((!is_known).then_some(geometry.half_track_of_joints));
    let (half_track, others) = first_of("half of the track", tracks);
    let multiplied = controllers
        .iter()
        .find(|own| own.multipliers != Multipliers::default());
    let (multipliers, by) = multiplied.map_or((Multipliers::default(), ""), |own| {
        (own.multipliers, own.name.as_str())
    });
    let has_radius = radius.is_some();
    match radius {
        Some(radius) => take_radius(&radius, multipliers, by, described),
        None => missing("wheel_radius_m", controllers, &geometry.missing, described),
    }
    match half_track {
        Some(length) if multipliers.track == 1.0 => {
            described.take_half_track(length.value_m, length.from);
        }
        Some(length) => described.take_half_track(
            length.value_m * multipliers.track,
            multiplied_by(&length, "its multiplier", by),
        ),
        None => missing("half_track_m", controllers, &geometry.missing, described),
    }
    if has_radius {
        take_difference(multipliers, by, described);
    }
    for note in contradictions.into_iter().chain(others) {
        described.note(note);
    }
}

/// Where a length is from that a controller multiplies.
fn multiplied_by(length: &Length, multiplier: &str, by: &str) -> String {
    let own = length.from.strip_suffix(&format!(" of {by}"));
    let from = own.unwrap_or(&length.from);
    format!("{from} times {multiplier} of {by}")
}

fn take_radius(radius: &Length, multipliers: Multipliers, by: &str, described: &mut Described) {
    let mean = multipliers.mean_radius();
    let [right, left] = multipliers.radii;
    let from = match mean == 1.0 {
        true => radius.from.clone(),
        false if right == left => multiplied_by(radius, "its multiplier", by),
        false => multiplied_by(radius, "the mean multiplier", by),
    };
    described.take_radius(radius.value_m * mean, from);
}

/// Takes the difference of the wheels' multipliers as an effect.
fn take_difference(multipliers: Multipliers, by: &str, described: &mut Described) {
    let mean = multipliers.mean_radius();
    let [right, left] = multipliers.radii;
    if right == left {
        return;
    }
    let from =
        |side: &str| format!("{side}_wheel_radius_multiplier over the mean multiplier of {by}");
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

/// What is to be done about a length that nothing says.
fn missing(key: &str, controllers: &[Drive], of_geometry: &[Missing], described: &mut Described) {
    if let Some(own) = of_geometry.iter().find(|own| own.key == key) {
        described.missing.push(own.clone());
        return;
    }
    let name = controllers
        .first()
        .map_or("the file", |own| own.name.as_str());
    let (parameter, measure) = match key {
        "half_track_m" => ("wheel_separation", MEASURE_TRACK),
        _ => ("wheel_radius", MEASURE_RADIUS),
    };
    let remedy =
        format!("give the robot's URDF, too, from which the controller has it, or {measure}");
    let problem = format!("{name} has no {parameter}");
    described.missing.push(Missing::new(key, problem, remedy));
}
