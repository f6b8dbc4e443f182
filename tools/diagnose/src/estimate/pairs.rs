//! Innovations of two recordings of one course: what pushes in both, in a catalogue or not, is no evidence
//! about what differs between them.
//!
//! Given the whitened innovation u of the one, that of the other, u', is normal about ρ u with variance
//! s² = 1 − ρ², or, with a small probability, as if nothing were common: it is then an outlier of one
//! recording alone. The logarithm of this density over that of independent innovations is added to the
//! log-likelihood of the other (a Gaussian copula; Joe 2014, section 4.3). s² is estimated: it is near 1
//! for recordings that share nothing but the course, and near 0 for a recording and its changed copy.

use nalgebra::DMatrix;

use super::BlockScore;
use super::information::Rows;
use super::whitened::{Whitened, dot};

/// Probability that a row errs by itself.
const OUTLIER_PROBABILITY: f64 = 0.06;
/// Least share of the variance that is not common: stamps are rounded, filters begin differently.
const LEAST_SHARE: f64 = 1e-3;
/// Deviation of the logit of the share before the data.
pub(crate) const DEVIATION: f64 = 3.0;
/// Longest step of it in one iteration of a fit.
pub(crate) const LONGEST: f64 = 1.5;

/// The share of the variance that is not common, with its derivative by its parameter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Share {
    pub(crate) value: f64,
    slope: f64,
}

impl Share {
    /// Of the logit of the share.
    pub(crate) fn new(logit: f64) -> Self {
        let sigmoid = 1.0 / (1.0 + (-logit).exp());
        Self {
            value: LEAST_SHARE + (1.0 - LEAST_SHARE) * sigmoid,
            slope: (1.0 - LEAST_SHARE) * sigmoid * (1.0 - sigmoid),
        }
    }
}

/// One row of both recordings.
struct RowPair {
    weight: f64,
    /// Log-density over that of independent innovations (nats).
    gain: f64,
    /// Probability that it does not err by itself.
    common: f64,
    /// Derivatives of the gain by both innovations and by the share.
    by_first: [f64; 3],
    by_second: [f64; 3],
    by_share: f64,
    /// Information about the share.
    of_share: f64,
}

impl RowPair {
    fn new(a: &Whitened, b: &Whitened, share: f64) -> Self {
        let rho = (1.0 - share).max(0.0).sqrt();
        // a component that was not measured has no error in either
        let count = (0..3).filter(|i| a.u[*i] != 0.0 || b.u[*i] != 0.0).count() as f64;
        let d: [f64; 3] = std::array::from_fn(|i| b.u[i] - rho * a.u[i]);
        let (dd, da, bb) = (dot(&d, &d), dot(&d, &a.u), dot(&b.u, &b.u));
        let own = (1.0 - OUTLIER_PROBABILITY).ln() - 0.5 * (dd / share + count * share.ln() - bb);
        let alone = OUTLIER_PROBABILITY.ln();
        let top = own.max(alone);
        let gain = top + ((own - top).exp() + (alone - top).exp()).ln();
        let common = (own - gain).exp();
        let slope =
            0.5 * (dd / (share * share) - count / share) - da / (2.0 * rho.max(1e-6) * share);
        Self {
            weight: a.weight.min(b.weight),
            gain,
            common,
            by_first: d.map(|d| common * rho * d / share),
            by_second: std::array::from_fn(|i| common * (b.u[i] - d[i] / share)),
            by_share: common * slope,
            of_share: common * count * 0.5 / (share * share),
        }
    }
}

/// Log-likelihood that the second recording gains by the first: block and nats of each row.
pub(crate) fn gains<'a>(
    first: &'a [Whitened],
    second: &'a [Whitened],
    share: Share,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let rows = first.iter().zip(second);
    rows.map(move |(a, b)| {
        let pair = RowPair::new(a, b, share.value);
        (b.block, pair.weight * pair.gain)
    })
}

/// The rows of one recording with the places of their parameters.
pub(crate) struct Side<'a> {
    pub(crate) rows: &'a Rows,
    pub(crate) to: &'a [(usize, usize)],
}

/// Adds score and information of the gains to the blocks of the second recording. `place` is that of the
/// parameter of the share, where it is free.
pub(crate) fn add_to(
    blocks: &mut [BlockScore],
    [first, second]: [Side<'_>; 2],
    share: Share,
    place: Option<usize>,
) {
    let (mut from_a, mut from_b) = (0, 0);
    let mut block: Option<WhitenedColumns> = None;
    for (a, b) in first.rows.kept.iter().zip(&second.rows.kept) {
        let pair = RowPair::new(a, b, share.value);
        let own = match block.take() {
            Some(own) if own.number == b.block => block.insert(own),
            done => {
                if let Some(done) = done {
                    done.add_to(blocks);
                }
                block.insert(WhitenedColumns::new(b.block))
            }
        };
        let n = blocks.first().map_or(0, |own| own.gradient.len());
        let at = own.row(n);
        let rho = (1.0 - share.value).max(0.0).sqrt();
        let root = (pair.weight * pair.common).sqrt();
        let apart = root / share.value.sqrt();
        let alone = root * b.ordinary.sqrt();
        let gradient = &mut blocks[b.block].gradient;
        for (lane, place) in first.to {
            let whitened = &first.rows.whitened[*lane][from_a..from_a + a.width()];
            let [full, _] = a.derivatives(whitened);
            gradient[*place] += pair.weight * dot(&pair.by_first, &full);
            add(&mut own.apart, at, n, *place, full, -apart * rho);
        }
        for (lane, place) in second.to {
            let whitened = &second.rows.whitened[*lane][from_b..from_b + b.width()];
            let [full, mean] = b.derivatives(whitened);
            gradient[*place] += pair.weight * dot(&pair.by_second, &full);
            add(&mut own.apart, at, n, *place, full, apart);
            add(&mut own.alone, at, n, *place, mean, alone);
        }
        if let Some(place) = place {
            gradient[place] += pair.weight * pair.by_share * share.slope;
            let information = &mut blocks[b.block].information;
            information[(place, place)] += pair.weight * pair.of_share * share.slope * share.slope;
        }
        from_a += a.width();
        from_b += b.width();
    }
    if let Some(done) = block {
        done.add_to(blocks);
    }
}

/// Adds the derivatives of a row by one parameter, which begins at `at` in columns of `n` numbers.
fn add(columns: &mut [f64], at: usize, n: usize, place: usize, row: [f64; 3], by: f64) {
    for (i, value) in row.into_iter().enumerate() {
        columns[at + i * n + place] += by * value;
    }
}

/// Whitened derivatives of the rows of one block, column by column: of what differs, and of the second
/// recording by itself.
struct WhitenedColumns {
    number: usize,
    count: usize,
    apart: Vec<f64>,
    alone: Vec<f64>,
}

impl WhitenedColumns {
    fn new(number: usize) -> Self {
        Self {
            number,
            count: 0,
            apart: Vec::new(),
            alone: Vec::new(),
        }
    }

    /// Makes room for a row of three columns of `n` numbers, and says where they begin.
    fn row(&mut self, n: usize) -> usize {
        self.count += 3;
        let at = self.apart.len();
        self.apart.resize(at + 3 * n, 0.0);
        self.alone.resize(at + 3 * n, 0.0);
        at
    }

    fn add_to(&self, blocks: &mut [BlockScore]) {
        let own = &mut blocks[self.number].information;
        let n = own.nrows();
        let matrix = |all: &[f64]| DMatrix::from_column_slice(n, self.count, all);
        let [apart, alone] = [matrix(&self.apart), matrix(&self.alone)];
        *own += &apart * apart.transpose() - &alone * alone.transpose();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whitened(u: [f64; 3]) -> Whitened {
        Whitened {
            block: 0,
            weight: 1.0,
            ordinary: 1.0,
            root: 1.0,
            scalar: false,
            raw: u,
            u,
        }
    }

    #[test]
    fn innovations_with_nothing_in_common_gain_nothing() {
        let (a, b) = (whitened([0.3, -1.0, 2.0]), whitened([1.0, 0.2, -0.4]));
        assert!(RowPair::new(&a, &b, 1.0).gain.abs() < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let (u, v) = ([0.3, -1.0, 2.0], [0.5, -0.9, 1.2]);
        let share = 0.3;
        let gain = |u, v, share| RowPair::new(&whitened(u), &whitened(v), share).gain;
        let pair = RowPair::new(&whitened(u), &whitened(v), share);
        let h = 1e-6;
        for i in 0..3 {
            let moved = |mut x: [f64; 3], by: f64| {
                x[i] += by;
                x
            };
            let first = (gain(moved(u, h), v, share) - gain(moved(u, -h), v, share)) / (2.0 * h);
            let second = (gain(u, moved(v, h), share) - gain(u, moved(v, -h), share)) / (2.0 * h);
            assert!((first - pair.by_first[i]).abs() < 1e-6);
            assert!((second - pair.by_second[i]).abs() < 1e-6);
        }
        let slope = (gain(u, v, share + h) - gain(u, v, share - h)) / (2.0 * h);
        assert!((slope - pair.by_share).abs() < 1e-6);
    }

    #[test]
    fn a_row_that_errs_by_itself_costs_a_bounded_amount() {
        let (a, b) = (whitened([0.1; 3]), whitened([40.0; 3]));
        assert!((RowPair::new(&a, &b, 0.01).gain - OUTLIER_PROBABILITY.ln()).abs() < 1e-9);
    }
}
