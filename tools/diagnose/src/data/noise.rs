//! How noisy a stream is, from the stream alone.

/// Standard deviation of what is not smooth in `rows` of (time (s), value): each value against the
/// cubic through its four neighbours, by the median, so that jumps do not count. `None` for fewer
/// than 20 rows.
pub(crate) fn deviation(rows: &[(f64, f64)]) -> Option<f64> {
    let mut misses: Vec<f64> = rows.windows(5).filter_map(miss).map(f64::abs).collect();
    if misses.len() < 16 {
        return None;
    }
    misses.sort_by(f64::total_cmp);
    // of a normal distribution, the median of the size is 0.6745 deviations
    Some(misses[misses.len() / 2] / 0.6745)
}

/// The middle of five rows minus the cubic through the others, in the middle one's deviations.
fn miss(five: &[(f64, f64)]) -> Option<f64> {
    let at = five[2].0;
    let others = [five[0], five[1], five[3], five[4]];
    let (mut value, mut square) = (0.0, 1.0);
    for (i, (t, v)) in others.iter().enumerate() {
        let mut weight = 1.0;
        for (j, (other, _)) in others.iter().enumerate() {
            if i != j {
                weight *= (at - other) / (t - other);
            }
        }
        value += weight * v;
        square += weight * weight;
    }
    let miss = (five[2].1 - value) / square.sqrt();
    miss.is_finite().then_some(miss)
}

#[cfg(test)]
mod tests {
    use super::deviation;

    #[test]
    fn a_smooth_motion_hides_nothing_of_the_noise() {
        // a pattern of unit deviation without memory, on a fast sine
        let mut state = 1_u32;
        let mut noise = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(state >> 8) / f64::from(1 << 24);
            }
            sum
        };
        let rows: Vec<_> = (0..2000)
            .map(|k| {
                let t = f64::from(k) * 0.03;
                (t, (2.0 * t).sin() + 0.01 * noise())
            })
            .collect();
        let found = deviation(&rows).unwrap();
        assert!((found / 0.01 - 1.0).abs() < 0.1, "{found}");
    }
}
