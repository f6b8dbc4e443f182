//! How clear a change is: the score since an onset beside what is expected of it without a change.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::hypotheses::Hypothesis;

/// Score and information of some rows.
#[derive(Debug, Clone)]
pub(crate) struct Sum {
    pub(crate) score: DVector<f64>,
    pub(crate) information: DMatrix<f64>,
}

/// Where the parameters were before: beside those of the filters, with their covariance.
#[derive(Debug, Clone)]
pub(crate) struct Known {
    pub(crate) mean: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
}

/// What a hypothesis is worth.
#[derive(Debug, Clone)]
pub(crate) struct Tested {
    /// Its numbers and their covariance.
    pub(crate) change: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
    /// Wald statistic.
    pub(crate) wald: f64,
    /// Log of the likelihood with a change of a plausible size over that without one (nats). Without a change it is seldom
    /// high: above x with a probability of at most exp(-x), however often one looks (Ville 1939).
    pub(crate) factor: f64,
}

impl Tested {
    /// Gain of the best size (nats).
    pub(crate) fn gain(&self) -> f64 {
        self.wald / 2.0
    }

    /// How large each number has to be, alone, for the factor to be expected to reach `least` (nats).
    pub(crate) fn smallest(&self, plausible: &[f64], least: f64) -> Option<Vec<f64>> {
        let wide =
            &self.covariance + DMatrix::from_diagonal(&DVector::from_column_slice(plausible));
        let [known, wide] = [factored(&self.covariance)?, factored(&wide)?];
        let needed = 2.0 * least + wide.ln_determinant() - known.ln_determinant();
        let gained = known.inverse() - wide.inverse();
        Some(
            (0..plausible.len())
                .map(|i| (needed / gained[(i, i)]).sqrt())
                .collect(),
        )
    }

    /// A sum of its numbers with its deviation.
    pub(crate) fn value(&self, weights: &[f64]) -> (f64, f64) {
        let w = DVector::from_column_slice(weights);
        let variance = w.dot(&(&self.covariance * &w));
        (w.dot(&self.change), variance.max(0.0).sqrt())
    }
}

impl Sum {
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            score: &self.score + &other.score,
            information: &self.information + &other.information,
        }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self {
            score: &self.score - &other.score,
            information: &self.information - &other.information,
        }
    }
}

impl Known {
    /// Combined with rows whose log-likelihoods count for `share` of themselves.
    pub(crate) fn with(&self, sum: &Sum, share: f64) -> Option<Self> {
        let precision = Cholesky::new(self.covariance.clone())?.inverse();
        let total = &precision + &sum.information * share;
        let inverse = Cholesky::new(symmetric(total))?.inverse();
        let mean = &inverse * (&precision * &self.mean + &sum.score * share);
        Some(Self {
            mean,
            covariance: inverse,
        })
    }
}

fn symmetric(own: DMatrix<f64>) -> DMatrix<f64> {
    (&own + own.transpose()) * 0.5
}

/// The change of a hypothesis since an onset, where the parameters were `known` before; `dispersion` is the variance of
/// scores over that of independent rows, `nuisance` a parameter that may have moved with a precision of its own.
pub(crate) fn test(
    own: &Hypothesis,
    sum: &Sum,
    known: &Known,
    dispersion: f64,
    nuisance: Option<(usize, f64)>,
) -> Option<Tested> {
    let (p, k) = (own.directions.nrows(), own.len());
    let wide = k + usize::from(nuisance.is_some());
    let mut w = DMatrix::zeros(p, wide);
    w.columns_mut(0, k).copy_from(&own.directions);
    if let Some((place, _)) = nuisance {
        w[(place, k)] = 1.0;
    }
    let rest = &sum.score - &sum.information * &known.mean;
    let jw = &sum.information * &w;
    let mut g = w.transpose() * &jw;
    let least = (0..k).map(|i| g[(i, i)]).fold(f64::INFINITY, f64::min);
    if least <= 0.0 || !least.is_finite() {
        return None;
    }
    g /= dispersion;
    if let Some((_, precision)) = nuisance {
        g[(k, k)] += precision;
    }
    let inverse = factored(&g)?.inverse();
    let change = &inverse * (w.transpose() * rest) / dispersion;
    let by_known = (&inverse / dispersion) * jw.transpose();
    let covariance = &inverse + &by_known * &known.covariance * by_known.transpose();
    let change = change.rows(0, k).into_owned();
    if own.positive && change[0] < 0.0 {
        return None;
    }
    let covariance = symmetric(covariance.view((0, 0), (k, k)).into_owned());
    let covariance = covariance * own.inflation * own.inflation;
    let plausible =
        &covariance + DMatrix::from_diagonal(&DVector::from_column_slice(&own.plausible));
    let [known, plausible] = [factored(&covariance)?, factored(&plausible)?];
    let wald = change.dot(&known.solve(&change));
    let rest = change.dot(&plausible.solve(&change));
    let factor = (wald - rest - plausible.ln_determinant() + known.ln_determinant()) / 2.0;
    factor.is_finite().then_some(Tested {
        change,
        covariance,
        wald,
        factor,
    })
}

fn factored(own: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    Cholesky::new(own.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(weights: &[f64]) -> Hypothesis {
        Hypothesis {
            effect: "wheel_radius",
            directions: DMatrix::from_column_slice(weights.len(), 1, weights),
            values: Vec::new(),
            confused: Vec::new(),
            mirror: None,
            plausible: vec![0.01; 1],
            inflation: 1.0,
            cost: 0.0,
            positive: false,
        }
    }

    /// With one parameter all is closed form: a is score over information less the mean, and its variance is
    /// c / J + v.
    #[test]
    fn one_parameter_is_tested_as_by_hand() {
        let sum = Sum {
            score: DVector::from_element(1, 50.0),
            information: DMatrix::from_element(1, 1, 100.0),
        };
        let known = Known {
            mean: DVector::from_element(1, 0.1),
            covariance: DMatrix::from_element(1, 1, 0.02),
        };
        let own = test(&one(&[1.0]), &sum, &known, 3.0, None).unwrap();
        assert!((own.change[0] - 0.4).abs() < 1e-12);
        assert!((own.covariance[(0, 0)] - 0.05).abs() < 1e-12);
        assert!((own.wald - 0.16 / 0.05).abs() < 1e-9);
        let after = known.with(&sum, 1.0).unwrap();
        // precisions 50 and 100 of means 0.1 and 0.5
        assert!((after.mean[0] - (50.0 * 0.1 + 50.0) / 150.0).abs() < 1e-12);
    }

    /// A nuisance with no prior takes what it explains as well.
    #[test]
    fn what_a_nuisance_explains_is_no_change() {
        let known = Known {
            mean: DVector::zeros(2),
            covariance: DMatrix::identity(2, 2) * 1e-12,
        };
        // two parameters whose scores are nearly the same
        let information = DMatrix::from_row_slice(2, 2, &[100.0, 99.0, 99.0, 100.0]);
        let score = &information * DVector::from_column_slice(&[0.0, 1.0]);
        let sum = Sum { score, information };
        let alone = test(&one(&[1.0, 0.0]), &sum, &known, 1.0, None).unwrap();
        let beside = test(&one(&[1.0, 0.0]), &sum, &known, 1.0, Some((1, 1e-9))).unwrap();
        assert!(alone.wald > 90.0 && beside.wald < 1e-6, "{beside:?}");
    }

    /// The factor is that of two normal densities: of a deviation of the change alone, and of that and a plausible size.
    #[test]
    fn the_factor_is_that_of_two_densities() {
        let sum = Sum {
            score: DVector::from_element(1, 30.0),
            information: DMatrix::from_element(1, 1, 100.0),
        };
        let known = Known {
            mean: DVector::zeros(1),
            covariance: DMatrix::from_element(1, 1, 1e-15),
        };
        let own = test(&one(&[1.0]), &sum, &known, 1.0, None).unwrap();
        let density = |variance: f64| -0.5 * (0.09 / variance + variance.ln());
        assert!((own.factor - density(0.02) + density(0.01)).abs() < 1e-9);
        // at the size that it has, it reaches what it has
        let least = own.smallest(&[0.01], own.factor).unwrap();
        assert!((least[0] - 0.3).abs() < 1e-9);
    }
}
