//! The 24 final positions that the paper prints, as a list of numbers.

use crate::reproduce::printed::FINALS;

/// How many there are.
pub(super) const COUNT: usize = 24;

/// Which number it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// 0: without the limit, 1: with it.
    pub(super) experiment: usize,
    /// From the front, 0 to 2.
    pub(super) robot: usize,
    /// By the tape; else by the encoders.
    pub(super) is_taped: bool,
    /// 0: x, 1: y.
    pub(super) axis: usize,
}

/// One number for each [`Place`], in the order of [`places`] (m).
pub(super) type Numbers = [f64; COUNT];

/// The numbers in order.
pub(super) fn places() -> [Place; COUNT] {
    std::array::from_fn(|i| Place {
        experiment: i / 12,
        robot: i / 4 % 3,
        is_taped: i / 2 % 2 == 1,
        axis: i % 2,
    })
}

/// What the paper prints (m).
pub(super) fn printed() -> Numbers {
    places().map(|own| {
        let finals = &FINALS[own.experiment];
        let ends = if own.is_taped {
            &finals.measured
        } else {
            &finals.encoder
        };
        ends[own.robot][own.axis]
    })
}

/// Root mean square of what is left of some numbers (m).
pub(super) fn root_mean_square(
    numbers: &Numbers,
    printed: &Numbers,
    is_meant: impl Fn(&Place) -> bool,
) -> f64 {
    let pairs = numbers.iter().zip(printed).zip(places());
    let own = pairs
        .filter(|(_, place)| is_meant(place))
        .map(|((a, b), _)| (a - b).powi(2));
    let (sum, count) = own.fold((0.0, 0.0), |(sum, count), square| {
        (sum + square, count + 1.0)
    });
    f64::sqrt(sum / f64::max(count, 1.0))
}
