//! Sets of times as unions of intervals.

/// The same set of times as disjoint intervals in order.
pub(crate) fn union(intervals: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = intervals.iter().copied().filter(|[a, b]| b > a).collect();
    sorted.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let mut joined: Vec<[f64; 2]> = Vec::new();
    for [from, to] in sorted {
        match joined.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => joined.push([from, to]),
        }
    }
    joined
}

fn length(set: &[[f64; 2]]) -> f64 {
    set.iter().map(|[from, to]| to - from).sum()
}

/// Intersection over union; 0 where both sets are empty.
pub(crate) fn overlap(one: &[[f64; 2]], other: &[[f64; 2]]) -> f64 {
    let (one, other) = (union(one), union(other));
    let both = union(&[one.clone(), other.clone()].concat());
    let common = length(&one) + length(&other) - length(&both);
    common / length(&both).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlap_is_intersection_over_union() {
        assert!((overlap(&[[0.0, 1.0], [0.5, 2.0]], &[[1.0, 3.0]]) - 1.0 / 3.0).abs() < 1e-12);
        assert!(overlap(&[[0.0, 1.0]], &[[2.0, 3.0]]).abs() < 1e-12);
        assert!(
            (overlap(&[[2.0, 3.0], [0.0, 1.0]], &[[0.0, 1.0], [2.0, 3.0]]) - 1.0).abs() < 1e-12
        );
        assert!(overlap(&[], &[]).abs() < 1e-12);
    }
}
