//! Distance that the wheels roll beside the distance that the robot moves.
//!
//! Both are sums over windows of 0.5 s, so that the noise of poses adds no length. What the wheels roll in a window is the mean
//! of both sides. What the robot moves is the displacement of its smoothed poses, taken as an arc where they have a heading.
//! A window in which neither reaches 5 mm is a standstill and adds nothing. One that has a gap is left out of both sums.

use super::answer::{Both, Slip, SlipPair};
use super::places::{Place, pose_at};
use super::rolled::rolled_at;
use super::seen::Seen;

/// Length of a window (s).
const WINDOW_S: f64 = 0.5;
/// Distance up to which a window is a standstill (m).
const STANDSTILL_M: f64 = 0.005;

/// The slip in both recordings over the time that both have; `None` if neither has wheels and poses.
pub(super) fn pair(seen: [&Seen; 2], span_s: [f64; 2]) -> Option<SlipPair> {
    let [real, simulated] = seen.map(|own| slip(&own.rolled, &own.smooth, span_s));
    let slips = Both { real, simulated };
    let difference = slips
        .pair()
        .and_then(|[real, simulated]| Some(real.slip_percent? - simulated.slip_percent?));
    (!slips.is_empty()).then_some(SlipPair {
        slips,
        difference_percent: difference,
    })
}

fn slip(rolled: &[(f64, f64)], places: &[Place], [from_s, to_s]: [f64; 2]) -> Option<Slip> {
    let mut sums_m: Option<[f64; 2]> = None;
    let windows = ((to_s - from_s) / WINDOW_S).floor().max(0.0) as usize;
    for window in 0..windows {
        let ends_s = [0, 1].map(|end| from_s + WINDOW_S * (window + end) as f64);
        let Some([wheels_m, poses_m]) = moved(rolled, places, ends_s) else {
            continue;
        };
        let sums_m = sums_m.get_or_insert([0.0; 2]);
        if wheels_m.max(poses_m) >= STANDSTILL_M {
            sums_m[0] += wheels_m;
            sums_m[1] += poses_m;
        }
    }
    let [wheels_m, poses_m] = sums_m?;
    let slip_m = wheels_m - poses_m;
    Some(Slip {
        wheels_m,
        poses_m,
        slip_m,
        slip_percent: (wheels_m > 0.0).then(|| 100.0 * slip_m / wheels_m),
    })
}

/// Distance by the wheels and by the poses in a window (m).
fn moved(rolled: &[(f64, f64)], places: &[Place], ends_s: [f64; 2]) -> Option<[f64; 2]> {
    let [a_m, b_m] = ends_s.map(|t_s| rolled_at(rolled, t_s));
    let [a, b] = ends_s.map(|t_s| pose_at(places, t_s));
    let (a, b) = (a?, b?);
    let chord_m = (b[0] - a[0]).hypot(b[1] - a[1]);
    let half_turn = (b[2] - a[2]) / 2.0;
    // An arc of this turn over its chord; 1 without a heading or a turn.
    let arc = match half_turn.is_finite() && half_turn.abs() > 1e-6 {
        true => half_turn / half_turn.sin(),
        false => 1.0,
    };
    Some([(b_m? - a_m?).abs(), chord_m * arc])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of radius 0.5 m at 0.5 m/s, whose wheels roll 2 % more; 10 s.
    #[test]
    fn slip_on_a_circle_is_what_was_put_in() {
        let times = (0..=1000).map(|k| 0.01 * f64::from(k));
        let rolled: Vec<_> = times.clone().map(|t_s| (t_s, 0.5 * 1.02 * t_s)).collect();
        let place = |t_s: f64| Place {
            t_s,
            pose: [0.5 * t_s.sin(), 0.5 * (1.0 - t_s.cos()), t_s],
        };
        let places: Vec<_> = times.map(place).collect();
        let found = slip(&rolled, &places, [0.0, 10.0]).unwrap();
        assert!((found.wheels_m - 5.1).abs() < 1e-9);
        assert!((found.poses_m - 5.0).abs() < 1e-9);
        assert!((found.slip_percent.unwrap() - 100.0 * 0.02 / 1.02).abs() < 1e-9);
    }

    /// Poses that tremble by 1 mm at a standstill add no length, and what turns back is not taken back.
    #[test]
    fn noise_adds_no_length_and_ways_back_count() {
        let rolled = [(0.0, 0.0), (0.5, 0.1), (1.0, 0.0), (1.5, 0.0), (2.0, 0.0)];
        let place = |(t_s, m): &(f64, f64)| Place {
            t_s: *t_s,
            pose: [m + 0.001 * (7.0 * t_s).sin(), 0.0, 0.0],
        };
        let places: Vec<_> = rolled.iter().map(place).collect();
        let found = slip(&rolled, &places, [0.0, 2.0]).unwrap();
        assert!((found.wheels_m - 0.2).abs() < 1e-12);
        assert!((found.poses_m - 0.2).abs() < 0.002);
    }

    #[test]
    fn a_robot_that_stands_slips_no_share() {
        let rolled = [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)];
        let places = rolled.map(|(t_s, _)| Place {
            t_s,
            pose: [0.0; 3],
        });
        let found = slip(&rolled, &places, [0.0, 1.0]).unwrap();
        assert_eq!((found.slip_m, found.slip_percent), (0.0, None));
        assert_eq!(slip(&[], &places, [0.0, 1.0]), None);
    }
}
