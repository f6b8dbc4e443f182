//! Distance between the poses of both recordings at the same time.

use super::answer::{Lines, PathApart};
use super::places::{Place, pose_at};
use super::seen::Seen;

/// How far apart the paths are; `None` if they have no pose at the same time. The poses are as measured.
pub(super) fn apart([real, simulated]: [&Seen; 2], span_s: [f64; 2]) -> Option<PathApart> {
    let points = distances(&real.places, &simulated.places, span_s);
    let (at_s, largest_m) = largest(&points)?;
    // Two coordinates, each with the noise of both sensors.
    let noise = real.noise_m.zip(simulated.noise_m);
    Some(PathApart {
        rms_m: rms(&points)?,
        largest_m,
        at_s,
        start_m: points.first()?.1,
        noise_m: noise.map(|(a, b)| (2.0 * (a * a + b * b)).sqrt()),
        poses: points.len(),
    })
}

/// What is drawn of a robot with these spacing errors.
pub(super) fn lines(seen: [&Seen; 2], spacing: [Vec<(f64, f64)>; 2], span_s: [f64; 2]) -> Lines {
    let way = |seen: &Seen| {
        let within = seen.places.iter().filter(|own| is_in(own.t_s, span_s));
        let row = |own: &Place| (own.t_s, own.pose[0], own.pose[1]);
        within.map(row).collect()
    };
    Lines {
        ways: seen.map(way),
        apart: distances(&seen[0].places, &seen[1].places, span_s),
        spacing,
    }
}

/// Time (s) and distance (m) at each pose of the real run for which the simulated one has poses around it.
fn distances(real: &[Place], simulated: &[Place], span_s: [f64; 2]) -> Vec<(f64, f64)> {
    let within = real.iter().filter(|own| is_in(own.t_s, span_s));
    let point = |own: &Place| {
        let other = pose_at(simulated, own.t_s)?;
        let distance_m = (own.pose[0] - other[0]).hypot(own.pose[1] - other[1]);
        Some((own.t_s, distance_m))
    };
    within.filter_map(point).collect()
}

/// Whether a time is in a span (s).
pub(super) fn is_in(t_s: f64, [from_s, to_s]: [f64; 2]) -> bool {
    (from_s..=to_s).contains(&t_s)
}

/// Root mean square; `None` of no points.
pub(super) fn rms(points: &[(f64, f64)]) -> Option<f64> {
    let sum: f64 = points.iter().map(|(_, value)| value * value).sum();
    (!points.is_empty()).then(|| (sum / points.len() as f64).sqrt())
}

/// Time and size of the largest value.
pub(super) fn largest(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let sizes = points.iter().map(|(t_s, value)| (*t_s, value.abs()));
    sizes.reduce(|most, own| if own.1 > most.1 { own } else { most })
}
