//! Statistics of points of a figure: root mean square, means of bins.

type Point = (f64, f64);

/// Number of bins of the horizontal axis.
const BINS: usize = 24;
/// Bins with fewer points than this are left out.
const MIN_POINTS: usize = 4;

/// Root mean square of the finite values.
pub(super) fn rms(points: &[Point]) -> f64 {
    let finite = points.iter().map(|(_, y)| *y).filter(|y| y.is_finite());
    let (count, sum) = finite.fold((0.0, 0.0), |(count, sum), y| (count + 1.0, sum + y * y));
    if count > 0.0 {
        f64::sqrt(sum / count)
    } else {
        f64::NAN
    }
}

/// The points with finite coordinates.
pub(super) fn finite_points(points: &[Point]) -> Vec<Point> {
    let finite = |(x, y): &&Point| x.is_finite() && y.is_finite();
    points.iter().filter(finite).copied().collect()
}

/// Mean of every bin of the horizontal axis, at the mean position of its points.
pub(super) fn binned_means(points: &[Point]) -> Vec<Point> {
    let points = finite_points(points);
    let xs = || points.iter().map(|(x, _)| *x);
    let low = xs().fold(f64::INFINITY, f64::min);
    let high = xs().fold(f64::NEG_INFINITY, f64::max);
    let width = ((high - low) / BINS as f64).max(f64::MIN_POSITIVE);
    let mut sums = vec![(0_usize, 0.0, 0.0); BINS];
    for (x, y) in &points {
        let (count, x_sum, y_sum) = &mut sums[(((x - low) / width) as usize).min(BINS - 1)];
        *count += 1;
        *x_sum += x;
        *y_sum += y;
    }
    let enough = sums
        .into_iter()
        .filter(|(count, _, _)| *count >= MIN_POINTS);
    enough
        .map(|(count, x, y)| (x / count as f64, y / count as f64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binned_means_of_a_line_lie_on_it() {
        let line: Vec<Point> = (0..960)
            .map(|i| f64::from(i) / 960.0)
            .map(|x| (x, 3.0 * x))
            .collect();
        let means = binned_means(&line);
        assert_eq!(means.len(), BINS);
        assert!(means.iter().all(|(x, y)| (y - 3.0 * x).abs() < 1e-12));
    }

    #[test]
    fn non_finite_points_are_ignored() {
        let points = [(0.0, 3.0), (f64::NAN, f64::NAN), (1.0, -3.0)];
        assert_eq!(rms(&points), 3.0);
        assert_eq!(finite_points(&points).len(), 2);
        assert!(rms(&[]).is_nan() && binned_means(&[]).is_empty());
    }
}
