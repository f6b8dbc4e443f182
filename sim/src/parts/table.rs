//! Table over one variable: linear between its knots, constant beyond the outer ones.

use super::scalar::Scalar;

/// A table with at least one entry. Its knots increase strictly.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table<S> {
    /// Each knot and the value there.
    entries: Vec<(S, S)>,
}

impl<S: Scalar> Table<S> {
    pub(crate) fn new(knots: &[S], values: &[S]) -> Self {
        let entries = knots.iter().copied().zip(values.iter().copied());
        Self {
            entries: entries.collect(),
        }
    }

    /// The value at `x`; 0 of a table without entries.
    pub(crate) fn at(&self, x: S) -> S {
        let above = self
            .entries
            .partition_point(|(knot, _)| knot.value() <= x.value());
        let before = above.checked_sub(1).and_then(|at| self.entries.get(at));
        match (before, self.entries.get(above)) {
            (Some(&(from, low)), Some(&(to, high))) => {
                low + (high - low) * ((x - from) / (to - from))
            }
            (Some(&(_, value)), None) | (None, Some(&(_, value))) => value,
            (None, None) => S::constant(0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Table;
    use num_dual::Dual64;

    #[test]
    fn it_is_linear_between_knots_and_constant_beyond_them() {
        let table = Table::new(&[-1.0, 0.0, 2.0], &[3.0, 1.0, 5.0]);
        let expected = [
            (-9.0, 3.0),
            (-1.0, 3.0),
            (-0.5, 2.0),
            (0.0, 1.0),
            (0.5, 2.0),
            (2.0, 5.0),
            (9.0, 5.0),
        ];
        for (x, value) in expected {
            assert_eq!(table.at(x), value);
        }
        assert_eq!(Table::new(&[0.3], &[7.0]).at(-1.0), 7.0);
    }

    #[test]
    fn variable_knots_and_values_carry_derivatives() {
        let constant = |v: f64| Dual64::from(v);
        let derivative = |knot: bool, value: bool, x: bool| {
            let seed = |v: f64, on: bool| {
                if on {
                    constant(v).derivative()
                } else {
                    constant(v)
                }
            };
            let knots = [constant(0.0), seed(2.0, knot)];
            let values = [constant(1.0), seed(5.0, value)];
            Table::new(&knots, &values).at(seed(0.5, x)).eps
        };
        // y = 1 + (5 - 1) x / 2
        assert_eq!(derivative(false, false, true), 2.0);
        assert_eq!(derivative(false, true, false), 0.25);
        assert_eq!(derivative(true, false, false), -0.5);
    }
}
