//! Intervals of clocks. Streams are read between their rows, which makes the likelihood of a latency rise and fall
//! with every row that it passes: the curvature at one maximum tells nothing of the next one.

use super::claim::Value;

/// The interval spans what fits as well between nothing and this multiple of what was found.
const MULTIPLE: f64 = 2.0;
/// Sizes that are tried for each size of what was found.
const SIZES: i32 = 24;

/// Widens the interval of a clock by every size whose log-likelihood, as `objective` of a change of it beside the
/// estimate, is within `nats` of the highest one.
pub(super) fn widen(value: &mut Value, nats: f64, objective: impl Fn(f64) -> f64) {
    let last = (MULTIPLE * f64::from(SIZES)) as i32;
    let tried: Vec<(f64, f64)> = (0..=last)
        .map(|k| value.change * (f64::from(k) / f64::from(SIZES) - 1.0))
        .map(|beside| (beside, objective(beside)))
        .collect();
    let best = tried.iter().map(|(_, own)| *own).fold(f64::MIN, f64::max);
    for (beside, _) in tried.iter().filter(|(_, own)| *own > best - nats) {
        let side = usize::from(*beside > 0.0);
        value.half[side] = value.half[side].max(beside.abs());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::term::Link;

    fn widened(objective: impl Fn(f64) -> f64) -> [f64; 2] {
        let mut value = Value::new("latency_s", Link::Identity, 0.08, 0.01);
        widen(&mut value, 2.0, objective);
        value.half
    }

    #[test]
    fn one_maximum_keeps_its_interval() {
        let deviation = 0.005_f64;
        assert_eq!(
            widened(|beside| -0.5 * (beside / deviation).powi(2)),
            [0.01; 2]
        );
    }

    #[test]
    fn a_higher_maximum_beside_it_is_inside() {
        // maxima every 0.02 s, of which the one 0.04 s below is higher by 1 and the next one lower by 3
        let height = |beside: f64| match (beside / 0.02).round() as i64 {
            0 => 0.0,
            -2 => 1.0,
            _ => -3.0,
        };
        let objective =
            |beside: f64| height(beside) - 50.0 * (beside / 0.02 - (beside / 0.02).round()).powi(2);
        let [below, above] = widened(objective);
        assert!((0.04..0.05).contains(&below), "{below}");
        assert!((above - 0.01).abs() < 1e-12, "{above}");
    }
}
