//! A missing force against the variable that it depends on.

use slipstream_sim::CommandKind;
use slipstream_sim::effects::{Info, Variable, When};

use crate::answer::Against;
use crate::answer::Point;
use crate::windows::bench::Bench;
use crate::windows::drivers::Driver;
use crate::windows::force::Part;
use crate::windows::moment::{Moment, acting_on, quantity};
use crate::windows::sampled::{Sampled, is_still, rate};
use crate::windows::track::Sensor;
use crate::windows::unknown::Unknown;

/// Half of the time over which the camera's speed is taken (s).
const CAMERA_S: f64 = 0.12;

/// The parts and the names of the variables that tell most of an effect.
fn telling(info: &Info) -> impl Iterator<Item = (Part, &'static str)> {
    info.follows.iter().filter_map(|(channel, variable)| {
        let part = Part::ALL
            .into_iter()
            .find(|part| part.name() == channel.name())?;
        let name = match variable {
            Variable::Speed => "v",
            Variable::TurnRate => "w",
            Variable::Heading => "heading",
            Variable::Command => "torque",
        };
        Some((part, name))
    })
}

/// The variables over which the slip of wheels is shown.
fn slip_over(info: &Info) -> &'static [&'static str] {
    match info.acts {
        When::Sliding => &["torque"],
        When::Inside => &["x", "y"],
        _ => &[],
    }
}

/// The force that an effect adds, before and after, against what tells most of it.
pub(crate) fn of_effect(
    bench: &Bench,
    info: &Info,
    before: &[Moment],
    after: &[Moment],
) -> Vec<Against> {
    let slip = of_slip(bench, info, before);
    if !slip.is_empty() {
        return slip;
    }
    let samples: Vec<Vec<Sampled>> = vec![before.iter().map(|m| m.sampled).collect()];
    let drivers = Driver::all(&samples);
    let parts = telling(info).filter_map(|(part, name)| {
        let driver = drivers.iter().find(|driver| driver.name == name)?;
        let points = |moments: &[Moment]| -> Vec<Point> {
            let all = moments.iter().map(|moment| {
                let z = driver.shown(driver.variable(&moment.sampled, part));
                (z, acting_on(bench, part, moment))
            });
            all.collect()
        };
        Some(Against {
            effect: info.id.to_owned(),
            quantity: quantity(bench, part),
            variable: variable(bench, driver, part),
            before: points(before),
            after: points(after),
            curve: Vec::new(),
            is_function: true,
        })
    });
    parts.collect()
}

/// How much faster the wheels turn than the body moves, as encoders and camera saw it: no force can
/// stand for slip. Nothing without both.
fn of_slip(bench: &Bench, info: &Info, moments: &[Moment]) -> Vec<Against> {
    let slip = |moment: &Moment| -> Option<f64> {
        let track = &bench.tracks[moment.run];
        track.of(Sensor::WheelAngle)?;
        let s = &moment.sampled;
        let [dx, dy, _] = rate(track.of(Sensor::Pose)?, s.t_s, CAMERA_S);
        Some(s.v - dx * s.pose[2].cos() - dy * s.pose[2].sin())
    };
    let samples: Vec<Vec<Sampled>> = vec![moments.iter().map(|m| m.sampled).collect()];
    let drivers = Driver::all(&samples);
    let over = slip_over(info).iter().filter_map(|name| {
        let driver = drivers.iter().find(|driver| driver.name == *name)?;
        let part = Part::Longitudinal;
        let points = moments
            .iter()
            .filter_map(|m| Some((driver.variable(&m.sampled, part), slip(m)?)));
        Some(Against {
            effect: info.id.to_owned(),
            quantity: "wheels faster than the body (m/s)".to_owned(),
            variable: variable(bench, driver, part),
            before: points.collect(),
            after: Vec::new(),
            curve: Vec::new(),
            is_function: true,
        })
    });
    over.filter(|against| against.before.iter().any(|(_, slip)| slip.is_finite()))
        .collect()
}

/// A variable in words, with its unit.
fn variable(bench: &Bench, driver: &Driver, part: Part) -> String {
    let commanded = match bench.tracks[0].kind() {
        CommandKind::Voltage => "voltage (V)",
        CommandKind::Torque => "torque (N m)",
        CommandKind::Speed => "wheel speed (rad/s)",
    };
    match (driver.name, part) {
        ("t", _) => "t (s)".to_owned(),
        ("v", _) => "forward speed (m/s)".to_owned(),
        ("w", _) => "yaw rate (rad/s)".to_owned(),
        ("torque", Part::WheelRight | Part::WheelLeft | Part::Wheels) => {
            format!("commanded {commanded}")
        }
        ("torque", Part::Yaw) => format!("commanded right minus left {commanded}"),
        ("torque", Part::Longitudinal) => format!("commanded right plus left {commanded}"),
        ("wheel_angle", Part::WheelLeft) => "angle of the left wheel in its turn (rad)".to_owned(),
        ("wheel_angle", _) => "angle of the right wheel in its turn (rad)".to_owned(),
        ("heading", _) => "heading (rad)".to_owned(),
        ("time_at_rest", _) => "time at rest (s)".to_owned(),
        (name, _) => format!("{name} ({})", driver.unit),
    }
}

/// The force outside of the catalogue. What follows the position is shown over both of its axes.
pub(crate) fn of_unknown(bench: &Bench, unknown: &Unknown, left: &[Moment]) -> Vec<Against> {
    let missing = &unknown.missing;
    let (part, driver) = (missing.part, &missing.driver);
    let opposes = |s: &Sampled| match (missing.against, part) {
        (false, _) => 1.0,
        (true, Part::Yaw) => opposing(s.w),
        (true, _) => opposing(s.v),
    };
    let is_function = driver.is_function();
    let way = if missing.against {
        ", against the motion"
    } else {
        ""
    };
    let axes: &[&str] = if driver.name != "position" {
        &[""]
    } else {
        driven_over(left)
    };
    let across = |axis: &str, s: &Sampled| match axis {
        "x (m)" => s.pose[0],
        "y (m)" => s.pose[1],
        _ => driver.shown(driver.variable(s, part)),
    };
    let of_axis = |axis: &&str| {
        let points = left.iter().map(|moment| {
            let force = acting_on(bench, part, moment) * opposes(&moment.sampled);
            (across(axis, &moment.sampled), force)
        });
        let curve = left.iter().map(|moment| {
            let force = driver.force(&missing.weights, &moment.sampled, part);
            (across(axis, &moment.sampled), force)
        });
        let mut curve: Vec<Point> = curve.filter(|(z, _)| z.is_finite()).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        Against {
            effect: "unknown".to_owned(),
            quantity: quantity(bench, part).replace(" (", &format!("{way} (")),
            variable: if axis.is_empty() {
                variable(bench, driver, part)
            } else {
                (*axis).to_owned()
            },
            before: points.collect(),
            after: Vec::new(),
            curve,
            is_function,
        }
    };
    axes.iter().map(of_axis).collect()
}

/// The axes of the floor along which the robot went at least a tenth as far as along the other.
fn driven_over(moments: &[Moment]) -> &'static [&'static str] {
    let length = |i: usize| {
        let places = moments
            .iter()
            .map(|moment| moment.sampled.pose[i])
            .filter(|v| v.is_finite());
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = places.fold(empty, |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    match (length(0), length(1)) {
        (x, y) if y < 0.1 * x => &["x (m)"],
        (x, y) if x < 0.1 * y => &["y (m)"],
        _ => &["x (m)", "y (m)"],
    }
}

/// The sign that makes a force count against the motion; none where it stands still.
fn opposing(speed: f64) -> f64 {
    if is_still(speed) {
        f64::NAN
    } else {
        -speed.signum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_sim::effects::{CATALOGUE, ModelSite};

    /// What misses a force is shown against something, what only a sensor or a link shows is not, nor
    /// is a push, which the force over time shows.
    #[test]
    fn every_force_has_a_telling_variable() {
        for info in CATALOGUE {
            let elsewhere = matches!(info.site, ModelSite::Sensor | ModelSite::Link);
            let nothing = telling(info).next().is_none() && slip_over(info).is_empty();
            let expected = elsewhere || info.acts == When::Once;
            assert_eq!(nothing, expected, "{}", info.id);
        }
    }

    #[test]
    fn a_robot_at_rest_has_no_motion_to_oppose() {
        assert!(opposing(1e-4).is_nan());
        assert_eq!([opposing(0.3), opposing(-0.3)], [-1.0, 1.0]);
    }
}
