//! Spacing errors of a follower, as the plant of a run measures them, from poses.

use slipstream_sim::run::{SPACING_FROM_S, Spacing};

use super::answer::{Both, SpacingError, SpacingPair};
use super::path::{is_in, largest, rms};
use super::places::{GAP_S, Place, pose_at};

/// Time (s) and spacing error (m) at each of the follower's places: distance to the robot ahead along the path that it drove,
/// minus `spacing_m`; positive where the follower is too far behind.
///
/// As in a simulated run it counts from 3 s on. Where one of both is out of sight, the path begins anew, and it counts from
/// 3 s later. Places without a heading have none.
pub(super) fn errors(
    ahead: &[Place],
    own: &[Place],
    spacing_m: f64,
    span_s: [f64; 2],
) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    // The path of the robot ahead, and the time from which errors count.
    let mut path: Option<(Spacing, f64)> = None;
    let mut last_s = f64::NEG_INFINITY;
    for place in own {
        let seen = pose_at(ahead, place.t_s).filter(|pose| pose[2].is_finite());
        let was_lost = place.t_s - last_s > GAP_S;
        let Some(pose) = seen else { continue };
        if was_lost {
            // A run begins at time 0, or little later where its first pose is.
            let begun_s = if place.t_s < GAP_S { 0.0 } else { place.t_s };
            path = Some((Spacing::new(pose), begun_s + SPACING_FROM_S));
        }
        last_s = place.t_s;
        let Some((spacing, from_s)) = &mut path else {
            continue;
        };
        spacing.extend(pose);
        if place.t_s >= *from_s && is_in(place.t_s, span_s) {
            points.push((place.t_s, spacing.distance(place.pose) - spacing_m));
        }
    }
    points
}

/// The errors of both recordings over the time that both have; `None` if neither has any.
pub(super) fn pair(
    ahead: &str,
    spacing_m: [Option<f64>; 2],
    points: &[Vec<(f64, f64)>; 2],
) -> Option<SpacingPair> {
    let ends = |own: &Vec<(f64, f64)>| Some([own.first()?.0, own.last()?.0]);
    let known = points.iter().filter_map(ends);
    let span_s = known.reduce(|all, own| [all[0].max(own[0]), all[1].min(own[1])])?;
    let of = |side: usize| {
        let within = points[side].iter().filter(|own| is_in(own.0, span_s));
        let within: Vec<(f64, f64)> = within.copied().collect();
        let (at_s, largest_m) = largest(&within)?;
        Some(SpacingError {
            spacing_m: spacing_m[side]?,
            rms_m: rms(&within)?,
            largest_m,
            at_s,
        })
    };
    let errors = Both {
        real: of(0),
        simulated: of(1),
    };
    let difference = |value: fn(&SpacingError) -> f64| {
        let [real, simulated] = errors.pair()?;
        Some(value(real) - value(simulated))
    };
    (!errors.is_empty()).then(|| SpacingPair {
        ahead: ahead.to_owned(),
        rms_difference_m: difference(|own| own.rms_m),
        largest_difference_m: difference(|own| own.largest_m),
        errors,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place on a circle of radius 1 m that is driven with 0.3 m/s, so far behind the start (m).
    fn on_circle(t_s: f64, behind_m: f64) -> Place {
        let angle = 0.3 * t_s - behind_m;
        Place {
            t_s,
            pose: [angle.sin(), 1.0 - angle.cos(), angle],
        }
    }

    fn drive(behind_m: f64) -> Vec<Place> {
        let times = (0..1000).map(|k| 0.01 * f64::from(k));
        times.map(|t_s| on_circle(t_s, behind_m)).collect()
    }

    #[test]
    fn the_error_is_an_arc_length_from_3_s_on() {
        let points = errors(&drive(0.0), &drive(0.52), 0.5, [0.0, 10.0]);
        assert_eq!(points.first().map(|own| own.0), Some(3.0));
        for (t_s, error_m) in &points {
            assert!((error_m - 0.02).abs() < 1e-3, "{t_s} {error_m}");
        }
        let pair = pair("r1", [Some(0.5); 2], &[points.clone(), points]).unwrap();
        assert!((pair.errors.real.unwrap().largest_m - 0.02).abs() < 1e-3);
        assert_eq!(pair.largest_difference_m, Some(0.0));
    }

    #[test]
    fn a_robot_that_was_out_of_sight_counts_3_s_later() {
        let mut ahead = drive(0.0);
        ahead.retain(|own| own.t_s < 4.0 || own.t_s > 5.0);
        let points = errors(&ahead, &drive(0.5), 0.5, [0.0, 10.0]);
        assert!(points.iter().all(|own| own.0 < 4.0 || own.0 > 8.0));
        assert!(points.iter().all(|own| own.1.abs() < 1e-3));
        assert!(points.last().unwrap().0 > 9.0);
    }

    #[test]
    fn without_errors_there_is_no_pair() {
        assert_eq!(pair("r1", [None; 2], &[Vec::new(), Vec::new()]), None);
        let one = pair("r1", [Some(0.5); 2], &[vec![(3.0, -0.1)], Vec::new()]).unwrap();
        assert_eq!(one.errors.real.unwrap().largest_m, 0.1);
        assert_eq!((one.errors.simulated, one.rms_difference_m), (None, None));
    }
}
