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

/// Whether the innovations of a reference are white: no autocorrelation is larger than chance makes it.
pub(super) fn is_white(machine: &FromWheels, at: &[f64], reference: Reference) -> bool {
    let view = View {
        machine,
        robust: true,
    };
    (0..machine.runs.len()).all(|run| {
        // standardised innovations, series after series; NaN where a row does not count
        let mut rows: [Vec<f64>; 3] = Default::default();
        view.innovations(reference, run, at, &mut |row: Innovation<f64>| {
            for (i, own) in rows.iter_mut().enumerate() {
                let variance = row.covariance[i][i];
                let seen = row.difference[i] != 0.0 && variance > 0.0;
                own.push(if seen && row.ordinary > ORDINARY {
                    row.difference[i] / variance.sqrt()
                } else {
                    f64::NAN
                });
            }
        });
        let is_white = |own: &Vec<f64>, lag| correlation(own, lag).is_none_or(|size| size < WHITE);
        rows.iter()
            .all(|own| (1..=LAGS).all(|lag| is_white(own, lag)))
    })
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
