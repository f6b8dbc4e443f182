//! How whitened innovations change with forces on the body that are given functions of time.

use super::gains::Pass;
use super::{DISTURBED, N};

/// A force along the body (N) and a moment about the vertical (N m).
pub(crate) type Load = [f64; 2];

/// Derivatives of the whitened innovations (three for each row of the run) by the factor of each
/// function: `functions[i][q]` is the load of the i-th while the q-th row of the pass is reached. A load
/// is held from row to row.
pub(crate) fn columns(pass: &Pass, functions: &[Vec<Load>], rows: usize) -> Vec<Vec<f64>> {
    functions
        .iter()
        .map(|function| column(pass, function, rows))
        .collect()
}

fn column(pass: &Pass, function: &[Load], rows: usize) -> Vec<f64> {
    let mut out = vec![0.0; 3 * rows];
    // change of the state by the factor
    let mut off = [0.0; N];
    for (row, load) in pass.rows.iter().zip(function) {
        if *load == [0.0; 2] && off.iter().all(|x| *x == 0.0) {
            continue;
        }
        let gain = &pass.gains[row.row];
        let mut before = off;
        before[DISTURBED] += load[0];
        before[DISTURBED + 1] += load[1];
        let mut moved = [0.0; N];
        for (own, f) in moved.iter_mut().zip(&row.step.flow) {
            *own = f.iter().zip(&before).map(|(f, x)| f * x).sum();
        }
        moved[DISTURBED] -= load[0];
        moved[DISTURBED + 1] -= load[1];
        let seen: [f64; 3] = std::array::from_fn(|a| {
            let g = &row.step.measurement[a];
            -g.iter().zip(&before).map(|(g, x)| g * x).sum::<f64>()
        });
        let change = gain.correction(&seen);
        for (own, change) in moved.iter_mut().zip(&change) {
            *own += change;
        }
        for (own, a) in moved[DISTURBED..].iter_mut().zip(&row.decay) {
            *own *= a;
        }
        off = moved;
        let at = 3 * row.row;
        out[at..at + 3].copy_from_slice(&gain.whitened(&seen));
    }
    out
}
