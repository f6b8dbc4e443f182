//! How far scores stray where nothing changes: by blocks of the baseline.

use nalgebra::{DMatrix, DVector};

use super::bank::Bank;
use super::filters::Filters;
use super::hypotheses::{Hypotheses, Hypothesis};
use super::statistic::{Known, Sum, test};

/// Lengths of blocks (s): each is twice the one before.
const SHORTEST_S: f64 = 1.0;
const LENGTHS: usize = 7;
/// Blocks that say something of their length.
const LEAST_BLOCKS: usize = 4;
/// A dispersion is taken this many deviations above its estimate: few blocks know it badly.
const ABOVE: f64 = 2.0;

/// The bank of one run of the baseline at rising times (s): sums since its begin.
pub(crate) type Course = Vec<(f64, Sum)>;

/// What the baseline says.
#[derive(Debug, Clone)]
pub(crate) struct Calibration {
    /// Where the parameters are, beside those of the filters.
    pub(crate) known: Known,
    /// Of each hypothesis, variance of scores over that of independent rows, by length of time.
    dispersion: Vec<[f64; LENGTHS]>,
}

impl Calibration {
    pub(crate) fn new(courses: &[Course], hypotheses: &Hypotheses) -> Option<Self> {
        let p = hypotheses.wide.len();
        let wide = Known {
            mean: DVector::zeros(p),
            covariance: DMatrix::from_diagonal(&DVector::from_column_slice(&hypotheses.wide)),
        };
        let ends = courses.iter().filter_map(|course| course.last());
        let total = ends.map(|(_, sum)| sum.clone()).reduce(|a, b| a.plus(&b))?;
        let middle = wide.with(&total, 1.0)?;
        let all = hypotheses.all.iter();
        let dispersion: Vec<[f64; LENGTHS]> =
            all.map(|own| dispersion(own, courses, &middle)).collect();
        let mut own = Self {
            known: middle,
            dispersion,
        };
        own.known.covariance = wide.with(&total, own.share())?.covariance;
        Some(own)
    }

    /// Dispersion of a hypothesis over so long (s).
    pub(crate) fn of(&self, hypothesis: usize, over_s: f64) -> f64 {
        let length = (over_s / SHORTEST_S)
            .log2()
            .clamp(0.0, LENGTHS as f64 - 1.0);
        let (low, share) = (length as usize, length.fract());
        let own = &self.dispersion[hypothesis];
        let high = own[(low + 1).min(LENGTHS - 1)];
        own[low] + (high - own[low]) * share
    }

    /// The share for which rows of a long time count.
    pub(crate) fn share(&self) -> f64 {
        let last = self.dispersion.iter().map(|own| own[LENGTHS - 1]);
        1.0 / median(last.collect())
    }

    /// A hypothesis strays so many times as far as was thought.
    pub(crate) fn widen(&mut self, hypothesis: usize, times: f64) {
        self.dispersion[hypothesis]
            .iter_mut()
            .for_each(|own| *own *= times);
    }
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(1.0)
}

/// Dispersion of one hypothesis over blocks of each length.
fn dispersion(own: &Hypothesis, courses: &[Course], middle: &Known) -> [f64; LENGTHS] {
    let exact = Known {
        covariance: &middle.covariance * 0.0,
        mean: middle.mean.clone(),
    };
    let mut all = [1.0; LENGTHS];
    let mut last = 1.0_f64;
    for (length, out) in all.iter_mut().enumerate() {
        let length_s = SHORTEST_S * f64::from(1 << length as u32);
        let blocks = courses.iter().flat_map(|course| blocks(course, length_s));
        let tested = blocks.filter_map(|sum| test(own, &sum, &exact, 1.0, None));
        let walds: Vec<f64> = tested.map(|own| own.wald).collect();
        if walds.len() >= LEAST_BLOCKS {
            let degrees = (walds.len() * own.len()) as f64;
            let mean = walds.iter().sum::<f64>() / degrees;
            last = last.max(mean * (1.0 + ABOVE * (2.0 / degrees).sqrt()));
        }
        *out = last;
    }
    all
}

/// Sums over blocks of a length.
fn blocks(course: &Course, length_s: f64) -> Vec<Sum> {
    let mut all = Vec::new();
    let Some(mut from) = course.first() else {
        return all;
    };
    for own in course {
        if own.0 >= from.0 + length_s {
            all.push(own.1.minus(&from.1));
            from = own;
        }
    }
    all
}

/// The course of a bank with a single onset while a robot's filters hear `hear` piece after piece; `hear` returns the
/// time (s), or nothing at the end.
pub(crate) fn course(
    filters: &mut Filters,
    bank: &mut Bank,
    mut hear: impl FnMut(&mut Filters, &mut Bank) -> Option<f64>,
) -> Course {
    filters.restart();
    bank.clear();
    bank.open(0.0);
    let mut course = Vec::new();
    while let Some(t_s) = hear(filters, bank) {
        if let Some(first) = bank.onsets.front() {
            course.push((t_s, first.sum.clone()));
        }
    }
    course
}
