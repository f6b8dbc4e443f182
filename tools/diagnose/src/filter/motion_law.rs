//! What is added to what the wheels say: a speed over the turn rate, a speed over the speed, and a turn rate over
//! the turn rate.

use nalgebra::{DMatrix, DVector};
use slipstream_sim::Scalar;

/// Knots of one table beside the one at 0, where it is 0.
const BESIDE: usize = 4;

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Table {
    /// Its name among the terms.
    pub(crate) name: &'static str,
    /// The same in words.
    pub(crate) meaning: &'static str,
    /// What it adds and over what, as `motion_law` names them.
    pub(crate) acts_on: &'static str,
    pub(crate) driver: &'static str,
    /// Number of its driver: turn rate, speed.
    pub(crate) over: usize,
    /// Its first parameter, and how many it has.
    pub(crate) first: usize,
    pub(crate) count: usize,
}

/// All tables. Those over the turn rate are without the part in proportion to it: that of the speed would be the
/// place of the reference beside the axle, and that of the turn rate the track.
pub(crate) const TABLES: [Table; 3] = [
    Table {
        name: "law of w",
        meaning: "speed over w",
        acts_on: "speed",
        driver: "w",
        over: 0,
        first: 0,
        count: BESIDE - 1,
    },
    Table {
        name: "law of v",
        meaning: "speed over v",
        acts_on: "speed",
        driver: "v",
        over: 1,
        first: BESIDE - 1,
        count: BESIDE,
    },
    Table {
        name: "law of turns",
        meaning: "turn rate over w",
        acts_on: "turn_rate",
        driver: "w",
        over: 0,
        first: OF_TURNS,
        count: BESIDE - 1,
    },
];
/// The table to which a parameter of all tables belongs.
pub(crate) fn table_of(parameter: usize) -> Option<&'static Table> {
    TABLES.iter().rfind(|table| table.first <= parameter)
}

/// The first parameter of the table that adds a turn rate.
pub(crate) const OF_TURNS: usize = 2 * BESIDE - 1;
/// Parameters of all tables.
pub(crate) const LAW: usize = OF_TURNS + BESIDE - 1;

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
            BESIDE
        } else {
            BESIDE / 2
        };
        let reach = zero.max(BESIDE - zero) as f64;
        Self {
            step: most / reach,
            zero,
        }
    }

    /// The last knot, counted from 0.
    pub(crate) fn reach(&self) -> f64 {
        self.step * self.zero.max(BESIDE - self.zero) as f64
    }

    /// Whether they lie on both sides of 0.
    pub(crate) fn has_both_sides(&self) -> bool {
        self.zero == BESIDE / 2
    }

    /// The knots.
    pub(crate) fn places(&self) -> Vec<f64> {
        (0..=BESIDE)
            .map(|k| self.step * (k as f64 - self.zero as f64))
            .collect()
    }

    /// The values at all knots.
    pub(crate) fn values<S: Scalar>(&self, law: &[S]) -> [S; BESIDE + 1] {
        let beside: [S; BESIDE] = match self.zero {
            _ if law.len() == BESIDE => std::array::from_fn(|i| law[i]),
            2 => [
                law[0] + law[2] * 0.5,
                law[1] - law[2],
                law[1] + law[2],
                law[0] - law[2] * 0.5,
            ],
            // at 1, 2, 3, 4 steps from 0, counted from it
            _ => {
                let first = law[0] * 2.0 + law[1] * 3.0 + law[2] * 4.0;
                let outward = [first, -law[0], -law[1], -law[2]];
                if self.zero == 0 {
                    outward
                } else {
                    [outward[3], outward[2], outward[1], outward[0]]
                }
            }
        };
        std::array::from_fn(|k| match k.cmp(&self.zero) {
            std::cmp::Ordering::Less => beside[k],
            std::cmp::Ordering::Equal => S::constant(0.0),
            std::cmp::Ordering::Greater => beside[k - 1],
        })
    }

    /// The `count` parameters whose values come closest to a table: pairs of knot and value, rising, linear
    /// between them and constant beyond.
    pub(crate) fn parameters(&self, count: usize, table: &[[f64; 2]]) -> Vec<f64> {
        let (Some(first), Some(last)) = (table.first(), table.last()) else {
            return vec![0.0; count];
        };
        let wanted = self.places().into_iter().map(|x| {
            let after = table.partition_point(|[knot, _]| *knot <= x);
            match (after.checked_sub(1).map(|i| table[i]), table.get(after)) {
                (Some([a, from]), Some([b, to])) => from + (to - from) * (x - a) / (b - a),
                (None, _) => first[1],
                (_, None) => last[1],
            }
        });
        let wanted = DVector::from_iterator(BESIDE + 1, wanted);
        // the values are linear in the parameters
        let columns = DMatrix::from_fn(BESIDE + 1, count, |knot, parameter| {
            let mut one = vec![0.0; count];
            one[parameter] = 1.0;
            self.values(&one)[knot]
        });
        let solved = columns.svd(true, true).solve(&wanted, 1e-12);
        solved.map_or_else(|_| vec![0.0; count], |own| own.iter().copied().collect())
    }

    /// The table at `driver`, linear between the knots and constant beyond them.
    fn at<S: Scalar>(&self, law: &[S], driver: S) -> S {
        let values = self.values(law);
        let z = driver * (1.0 / self.step.max(f64::MIN_POSITIVE)) + self.zero as f64;
        if z.value() <= 0.0 {
            return values[0];
        }
        if z.value() >= BESIDE as f64 {
            return values[BESIDE];
        }
        let place = (z.value() as usize).min(BESIDE - 1);
        let share = z - S::constant(place as f64);
        values[place] + (values[place + 1] - values[place]) * share
    }
}

/// A driver reaches less far on one side than this share of the other: its table has one side.
const ONE_SIDED: f64 = 0.1;

/// The speed (m/s) and the turn rate (rad/s) that all tables add at a turn rate (rad/s) and a speed (m/s).
pub(crate) fn added<S: Scalar>(law: &[S], drivers: [S; 2], knots: &[Knots; 2]) -> [S; 2] {
    let of = |table: Table| {
        let own = &law[table.first..table.first + table.count];
        knots[table.over].at(own, drivers[table.over])
    };
    [of(TABLES[0]) + of(TABLES[1]), of(TABLES[2])]
}

/// Parameters of a table over the turn rate, with their weights, for one in proportion to the size of the turn rate
/// whose values at the outermost knots are 1; there is one where the knots lie on both sides.
pub(crate) const OF_SIZE: [(usize, f64); 2] = [(0, 1.0), (1, 0.5)];

/// The turn rate (rad/s) that the table of turns adds at a turn rate (rad/s).
pub(crate) fn turning<S: Scalar>(of_turns: &[S], w: S, knots: &Knots) -> S {
    knots.at(of_turns, w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_knots_and_constant_beyond() {
        let law = [-1.0, -0.25, 0.5, 0.0, 0.0, 0.0, 0.0, 2.0, 0.5, -1.0];
        let knots = [Knots::over([-2.0, 1.9]), Knots::over([0.0, 1.0])];
        for (w, wanted) in [
            (-9.0, -0.75),
            (-2.0, -0.75),
            (-1.5, -0.75),
            (0.0, 0.0),
            (0.5, 0.125),
            (1.0, 0.25),
            (2.0, -1.25),
            (7.0, -1.25),
        ] {
            let [speed, turn]: [f64; 2] = added(&law, [w, 3.0], &knots);
            assert!((speed - wanted).abs() < 1e-12, "{w} {speed}");
            assert!((turn + 2.0 * wanted).abs() < 1e-12, "{w} {turn}");
        }
        assert_eq!(knots[1].places(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        let of_speed = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0];
        let [found, none]: [f64; 2] = added(&of_speed, [0.0, 0.125], &knots);
        assert!((found - 0.5).abs() < 1e-12 && none == 0.0, "{found} {none}");
    }

    #[test]
    fn a_table_can_be_in_proportion_to_the_size_of_the_turn_rate() {
        let knots = Knots::over([-2.0, 1.9]);
        let mut law = [0.0; 3];
        OF_SIZE.iter().for_each(|(own, weight)| law[*own] = *weight);
        assert!(knots.has_both_sides());
        assert_eq!(knots.values(&law), [1.0, 0.5, 0.0, 0.5, 1.0]);
    }

    #[test]
    fn a_table_over_the_turn_rate_has_no_part_in_proportion_to_it() {
        for range in [[-2.0, 2.0], [0.0, 1.0], [-3.0, 0.1]] {
            let knots = Knots::over(range);
            for law in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.2, 0.7]] {
                let values: [f64; BESIDE + 1] = knots.values(&law);
                let product: f64 = knots.places().iter().zip(values).map(|(z, v)| z * v).sum();
                assert!(product.abs() < 1e-12, "{range:?} {product}");
            }
        }
    }
}
