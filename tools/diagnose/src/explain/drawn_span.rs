//! Which part of a run a picture of its path shows.

/// Longest run whose whole path is drawn (s), and of a longer one the piece that is.
const WHOLE_S: f64 = 120.0;
const PIECE_S: f64 = 60.0;

/// The whole span (s) of a short run; of a long one the piece in which what was found takes most square error
/// away. `errors` are times (s) with the square error of a prediction, negative where it is that after.
pub(super) fn drawn_span(
    [from_s, to_s]: [f64; 2],
    errors: impl Iterator<Item = (f64, f64)>,
) -> [f64; 2] {
    if to_s - from_s <= WHOLE_S {
        return [from_s, to_s];
    }
    let count = ((to_s - from_s) / PIECE_S).floor().max(1.0) as usize;
    let mut sums = vec![0.0; count];
    for (t_s, square) in errors.filter(|(_, square)| square.is_finite()) {
        if let Some(sum) = sums.get_mut(((t_s - from_s) / PIECE_S) as usize) {
            *sum += square;
        }
    }
    let best = (0..count).max_by(|a, b| f64::total_cmp(&sums[*a], &sums[*b]));
    let begin_s = from_s + PIECE_S * best.unwrap_or(0) as f64;
    [begin_s, (begin_s + PIECE_S).min(to_s)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_is_drawn_where_most_error_goes() {
        let errors = [
            (10.0, 3.0),
            (70.0, 5.0),
            (70.0, -4.5),
            (130.0, f64::NAN),
            (190.0, 1.0),
        ];
        assert_eq!(drawn_span([0.0, 200.0], errors.into_iter()), [0.0, 60.0]);
        assert_eq!(drawn_span([0.0, 100.0], errors.into_iter()), [0.0, 100.0]);
        let later = [(10.0, 3.0), (70.0, 5.0)];
        assert_eq!(drawn_span([0.0, 200.0], later.into_iter()), [60.0, 120.0]);
    }
}
