//! Points of figures, summed up.

type Point = (f64, f64);

/// Stretches of the axis across that have a mean of their own, and points that a mean takes.
const STRETCHES: usize = 24;
const ENOUGH: usize = 4;

/// Root mean square of what is measured.
pub(super) fn level(points: &[Point]) -> f64 {
    let finite = points.iter().map(|(_, y)| *y).filter(|y| y.is_finite());
    let (count, sum) = finite.fold((0.0, 0.0), |(count, sum), y| (count + 1.0, sum + y * y));
    if count > 0.0 {
        f64::sqrt(sum / count)
    } else {
        f64::NAN
    }
}

/// What can be drawn.
pub(super) fn kept(points: &[Point]) -> Vec<Point> {
    let finite = |(x, y): &&Point| x.is_finite() && y.is_finite();
    points.iter().filter(finite).copied().collect()
}

/// The mean in every stretch of the axis across, at the mean place of its points.
pub(super) fn means(points: &[Point]) -> Vec<Point> {
    let points = kept(points);
    let across = || points.iter().map(|(x, _)| *x);
    let low = across().fold(f64::INFINITY, f64::min);
    let high = across().fold(f64::NEG_INFINITY, f64::max);
    let width = ((high - low) / STRETCHES as f64).max(f64::MIN_POSITIVE);
    let mut sums = vec![(0_usize, 0.0, 0.0); STRETCHES];
    for (x, y) in &points {
        let (count, across, up) = &mut sums[(((x - low) / width) as usize).min(STRETCHES - 1)];
        *count += 1;
        *across += x;
        *up += y;
    }
    let enough = sums.into_iter().filter(|(count, _, _)| *count >= ENOUGH);
    enough
        .map(|(count, x, y)| (x / count as f64, y / count as f64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_line_is_the_line() {
        let line: Vec<Point> = (0..960)
            .map(|i| f64::from(i) / 960.0)
            .map(|x| (x, 3.0 * x))
            .collect();
        let means = means(&line);
        assert_eq!(means.len(), STRETCHES);
        assert!(means.iter().all(|(x, y)| (y - 3.0 * x).abs() < 1e-12));
    }

    #[test]
    fn gaps_count_for_nothing() {
        let points = [(0.0, 3.0), (f64::NAN, f64::NAN), (1.0, -3.0)];
        assert_eq!(level(&points), 3.0);
        assert_eq!(kept(&points).len(), 2);
        assert!(level(&[]).is_nan() && means(&[]).is_empty());
    }
}
