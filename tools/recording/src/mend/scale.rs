//! How far a column gets in an interval: the measure of what is plausible.

use super::column::{Column, Sample};
use crate::rows::Rows;

/// Most faults of one kind that are kept; further ones are not looked for.
pub(super) const MOST_FAULTS: usize = 10_000;
/// Steps that are kept to take quantiles of.
const MOST_STEPS: usize = 8192;
/// Fewest steps with a change; fewer say nothing about the speed of a column.
const FEWEST_CHANGES: usize = 15;
/// The speed that nine of ten steps with a change do not exceed: faults are fewer than one in ten.
const TOP: f64 = 0.9;
/// Hardly any step is faster than this one.
const FASTEST: f64 = 0.99;

/// What a column does from row to row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Median time between rows (s).
    pub(super) interval_s: f64,
    /// Change per second, by [`TOP`].
    pub(super) top_per_s: f64,
    /// Change per second, by [`FASTEST`].
    pub(super) fastest_per_s: f64,
}

impl Scale {
    /// The scale of a column without these rows, read modulo `modulus` if it wraps.
    pub(super) fn of(column: Column<'_>, left_out: &[usize], modulus: Option<f64>) -> Option<Self> {
        let stride = column.rows.len().div_ceil(MOST_STEPS).max(1);
        let (mut last, mut count, mut steps) = (None::<Sample>, 0_usize, Vec::new());
        column.visit_but(left_out, &mut |sample| {
            if let Some(last) = last.replace(sample) {
                if count.is_multiple_of(stride) {
                    let step = fold(sample.value - last.value, modulus);
                    steps.push((sample.t_s - last.t_s, step.abs()));
                }
                count += 1;
            }
        });
        Self::of_steps(&steps)
    }

    fn of_steps(steps: &[(f64, f64)]) -> Option<Self> {
        let interval_s = quantile(steps.iter().map(|(dt_s, _)| *dt_s).collect(), 0.5)?;
        // a stamp that is too early must not make a step look fast
        let rate = |(dt_s, step): &(f64, f64)| step / dt_s.max(interval_s);
        let rates: Vec<f64> = steps.iter().filter(|s| s.1 > 0.0).map(rate).collect();
        if interval_s <= 0.0 || rates.len() < FEWEST_CHANGES {
            return None;
        }
        Some(Self {
            interval_s,
            top_per_s: quantile(rates.clone(), TOP)?,
            fastest_per_s: quantile(rates, FASTEST)?,
        })
    }

    /// How far the column gets in this time, at least an interval.
    pub(super) fn reach(&self, dt_s: f64) -> f64 {
        self.top_per_s * dt_s.max(self.interval_s)
    }
}

/// Median time between rows (s), and the median deviation from it over it (1).
pub(super) fn intervals(rows: &Rows<'_>) -> Option<[f64; 2]> {
    let stride = rows.len().div_ceil(MOST_STEPS).max(1);
    let (mut last, mut count, mut steps) = (None::<f64>, 0_usize, Vec::new());
    rows.visit_times(&mut |times| {
        for t_s in times {
            if let Some(last) = last.replace(*t_s) {
                if count.is_multiple_of(stride) {
                    steps.push(*t_s - last);
                }
                count += 1;
            }
        }
    });
    let median_s = quantile(steps.clone(), 0.5).filter(|median_s| *median_s > 0.0)?;
    let away = steps.iter().map(|dt_s| (dt_s - median_s).abs());
    Some([median_s, quantile(away.collect(), 0.5)? / median_s])
}

/// Median time between rows (s); `None` where it is not positive.
pub(crate) fn interval_s(rows: &Rows<'_>) -> Option<f64> {
    intervals(rows).map(|[median_s, _]| median_s)
}

/// The number below which this share lies.
pub(super) fn quantile(mut numbers: Vec<f64>, share: f64) -> Option<f64> {
    let at = (share * numbers.len() as f64) as usize;
    let at = at.min(numbers.len().checked_sub(1)?);
    Some(*numbers.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// The step of a column that wraps: the smallest that ends where this one does.
pub(super) fn fold(step: f64, modulus: Option<f64>) -> f64 {
    modulus.map_or(step, |modulus| step - modulus * (step / modulus).round())
}
