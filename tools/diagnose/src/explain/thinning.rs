//! How dense rows may be filtered: as dense as their innovations are white.
//!
//! Rows of a real log repeat each other's errors, and at full rate their structure is taken for
//! evidence; rows of a camera whose errors are independent are all evidence.

use crate::filter::Innovation;
use crate::model::from_wheels::{FromWheels, Reference};
use crate::model::view::View;

/// Largest autocorrelation of white innovations beside what chance makes of it.
const WHITE: f64 = 0.03;
/// Standard deviations that chance is granted.
const CHANCE: f64 = 2.5;
/// Lags that are looked at (rows).
const LAGS: usize = 4;
/// A row with a smaller probability of being ordinary is left out.
const ORDINARY: f64 = 0.5;

/// Largest autocorrelation of the innovations of a reference, less what chance makes of it; `None`
/// without that reference.
pub(super) fn colour(machine: &FromWheels, at: &[f64], reference: Reference) -> Option<f64> {
    let view = View {
        machine,
        robust: true,
    };
    let mut worst: Option<f64> = None;
    for run in 0..machine.runs.len() {
        // standardised innovations, series after series; NaN where a row does not count
        let mut rows: Vec<[f64; 3]> = Vec::new();
        view.innovations(reference, run, at, &mut |row: Innovation<f64>| {
            let own = std::array::from_fn(|i| {
                let variance = row.covariance[i][i];
                let seen = row.difference[i] != 0.0 && variance > 0.0;
                if seen && row.ordinary > ORDINARY {
                    row.difference[i] / variance.sqrt()
                } else {
                    f64::NAN
                }
            });
            rows.push(own);
        });
        for channel in 0..3 {
            let own: Vec<f64> = rows.iter().map(|row| row[channel]).collect();
            for lag in 1..=LAGS {
                if let Some(excess) = correlation(&own, lag) {
                    worst = Some(worst.map_or(excess, |w: f64| w.max(excess)));
                }
            }
        }
    }
    worst
}

/// Size of the autocorrelation at a lag, less what chance makes of it.
fn correlation(rows: &[f64], lag: usize) -> Option<f64> {
    let pairs = rows.iter().zip(rows.iter().skip(lag));
    let pairs: Vec<(f64, f64)> = pairs
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .map(|(a, b)| (*a, *b))
        .collect();
    if pairs.len() < 20 {
        return None;
    }
    let count = pairs.len() as f64;
    let product: f64 = pairs.iter().map(|(a, b)| a * b).sum();
    let square: f64 = pairs.iter().map(|(a, b)| a * a + b * b).sum::<f64>() / 2.0;
    Some((product / square).abs() - CHANCE / count.sqrt())
}

/// Whether the innovations of a reference are white.
pub(super) fn is_white(machine: &FromWheels, at: &[f64], reference: Reference) -> bool {
    colour(machine, at, reference).is_none_or(|colour| colour < WHITE)
}
