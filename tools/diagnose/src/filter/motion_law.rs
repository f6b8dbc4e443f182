//! A speed that is added to what the wheels say: a table over the turn rate, and one over the speed.

use slipstream_sim::Scalar;

/// Values of one table beside the one at 0, which is 0.
pub(crate) const VALUES: usize = 4;
/// Values of both tables.
pub(crate) const LAW: usize = 2 * VALUES;
/// Drivers of the tables, as `motion_law` names them.
pub(crate) const DRIVERS: [&str; 2] = ["w", "v"];

/// Knots of a table, at equal distances; one of them is 0.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Knots {
    /// Distance between neighbours (rad/s, or m/s).
    pub(crate) step: f64,
    /// Which of them is 0.
    pub(crate) zero: usize,
}

impl Knots {
    /// Knots over the range of a driver.
    pub(crate) fn over([low, high]: [f64; 2]) -> Self {
        let most = high.max(-low);
        let zero = if -low < ONE_SIDED * most {
            0
        } else if high < ONE_SIDED * most {
            VALUES
        } else {
            VALUES / 2
        };
        let reach = zero.max(VALUES - zero) as f64;
        Self {
            step: most / reach,
            zero,
        }
    }

    /// The knots.
    pub(crate) fn places(&self) -> Vec<f64> {
        (0..=VALUES)
            .map(|k| self.step * (k as f64 - self.zero as f64))
            .collect()
    }

    /// The values at all knots.
    pub(crate) fn values<S: Scalar>(&self, law: &[S]) -> [S; VALUES + 1] {
        std::array::from_fn(|k| match k.cmp(&self.zero) {
            std::cmp::Ordering::Less => law[k],
            std::cmp::Ordering::Equal => S::constant(0.0),
            std::cmp::Ordering::Greater => law[k - 1],
        })
    }

    /// The table at `driver`, linear between the knots and constant beyond them.
    fn at<S: Scalar>(&self, law: &[S], driver: S) -> S {
        let values = self.values(law);
        let z = driver * (1.0 / self.step.max(f64::MIN_POSITIVE)) + self.zero as f64;
        if z.value() <= 0.0 {
            return values[0];
        }
        if z.value() >= VALUES as f64 {
            return values[VALUES];
        }
        let place = (z.value() as usize).min(VALUES - 1);
        let share = z - S::constant(place as f64);
        values[place] + (values[place + 1] - values[place]) * share
    }
}

/// A driver reaches less far on one side than this share of the other: its table has one side.
const ONE_SIDED: f64 = 0.1;

/// The speed (m/s) that both tables add at a turn rate (rad/s) and a speed (m/s).
pub(crate) fn added<S: Scalar>(law: &[S], [w, v]: [S; 2], knots: &[Knots; 2]) -> S {
    knots[0].at(&law[..VALUES], w) + knots[1].at(&law[VALUES..LAW], v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_knots_and_constant_beyond() {
        let law = [-1.0, -0.25, 0.5, 2.0, 0.0, 0.0, 0.0, 0.0];
        let knots = [Knots::over([-2.0, 1.9]), Knots::over([0.0, 1.0])];
        for (w, wanted) in [
            (-9.0, -1.0),
            (-2.0, -1.0),
            (-1.5, -0.625),
            (0.0, 0.0),
            (0.5, 0.25),
            (2.0, 2.0),
            (7.0, 2.0),
        ] {
            let found: f64 = added(&law, [w, 3.0], &knots);
            assert!((found - wanted).abs() < 1e-12, "{w} {found}");
        }
        assert_eq!(knots[1].places(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let of_speed = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0];
        let found: f64 = added(&of_speed, [0.0, 0.125], &knots);
        assert!((found - 0.5).abs() < 1e-12, "{found}");
    }
}
