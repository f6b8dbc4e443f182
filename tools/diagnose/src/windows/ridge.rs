//! Numbers that are to predict: held near zero by as much as best predicts what they were not fitted
//! to (ridge regression, Hoerl and Kennard, 1970; chosen as by Stone, 1974).

use nalgebra::{DMatrix, DVector};

use crate::windows::linear::{Normal, reduced, solved};

/// Shares of what is known of the best known number by which all are held near zero.
const SHARES: [f64; 7] = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
/// The share where a single window says nothing of how well it predicts others.
const ALONE: f64 = 1e-3;

/// Equations of shared parameters, the starts eliminated.
type Equations = (DMatrix<f64>, DVector<f64>);

/// Step of all shared parameters that these windows ask for; those from `known` on are held.
pub(crate) fn step(normals: &[Normal], known: usize) -> Vec<f64> {
    let each = normals
        .iter()
        .map(|n| reduced(std::slice::from_ref(n), 1e-6));
    let each: Vec<Equations> = each.collect();
    let told = |i: usize| normals.iter().map(|normal| normal.told(i)).sum::<f64>();
    let count = each.first().map_or(0, |(_, slope)| slope.len());
    let most = (known..count).map(told).fold(0.0, f64::max);
    let step = |share: f64, without: Option<usize>| {
        let others = each.iter().enumerate().filter(|(w, _)| Some(*w) != without);
        let mut matrix = DMatrix::zeros(count, count);
        let mut slope = DVector::zeros(count);
        for (_, (own, own_slope)) in others {
            matrix += own;
            slope += own_slope;
        }
        (known..count).for_each(|i| matrix[(i, i)] += share * most);
        solved(&matrix, &slope)
    };
    // change of the sum of squares of each window by what the others ask for
    let change = |share: f64| {
        let windows = each.iter().enumerate().map(|(w, (own, own_slope))| {
            let step = DVector::from_vec(step(share, Some(w)));
            2.0 * own_slope.dot(&step) + step.dot(&(own * &step))
        });
        windows.sum::<f64>()
    };
    if each.len() < 2 {
        return step(ALONE, None);
    }
    let tried = SHARES.map(|share| (share, change(share)));
    let best = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    step(best.map_or(ALONE, |(share, _)| share), None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::windows::fixture;
    use crate::windows::linear::Linear;
    use crate::windows::track::CHANNELS;

    const ROWS: usize = 8;

    /// Equations of windows with a column each for two shared numbers and what they sum to.
    fn normals(windows: &[[[f64; ROWS]; 3]]) -> Vec<Normal> {
        let window = fixture::window(vec![0; ROWS]);
        let normal = |[first, second, sum]: &[[f64; ROWS]; 3]| {
            let linear = Linear {
                residuals: sum.to_vec(),
                ..Linear::default()
            };
            linear.normal(&window, &[1.0; CHANNELS], sum, &[first, second])
        };
        windows.iter().map(normal).collect()
    }

    /// Residuals that ask for these steps.
    fn asks(columns: [[f64; ROWS]; 2], steps: [f64; 2]) -> [[f64; ROWS]; 3] {
        let sum = std::array::from_fn(|i| -(columns[0][i] * steps[0] + columns[1][i] * steps[1]));
        [columns[0], columns[1], sum]
    }

    fn slow(i: usize) -> f64 {
        (i as f64).sin()
    }

    #[test]
    fn what_all_windows_ask_for_is_hardly_held() {
        let columns = [
            std::array::from_fn(slow),
            std::array::from_fn(|i| slow(i * i)),
        ];
        let step = step(&normals(&[asks(columns, [2.0, -3.0]); 3]), 0);
        assert!(
            (step[0] - 2.0).abs() < 1e-5 && (step[1] + 3.0).abs() < 1e-5,
            "{step:?}"
        );
    }

    /// What the second number is comes out of the first window alone, which hardly shows it, and is
    /// wrong in all others: without being held it would be 1000.
    #[test]
    fn what_one_window_alone_asks_for_is_held() {
        let columns = [
            std::array::from_fn(slow),
            std::array::from_fn(|i| 1e-3 * slow(i * i)),
        ];
        let mut windows = [asks(columns, [2.0, 0.0]); 4];
        windows[0] = asks(columns, [2.0, 4000.0]);
        let step = step(&normals(&windows), 0);
        assert!((step[0] - 2.0).abs() < 0.2, "{step:?}");
        assert!(step[1].abs() < 10.0, "{step:?}");
    }

    #[test]
    fn what_is_known_is_not_held() {
        let columns = [
            std::array::from_fn(slow),
            std::array::from_fn(|i| slow(i * i)),
        ];
        let one = step(&normals(&[asks(columns, [2.0, 0.0])]), 1);
        assert!((one[0] - 2.0).abs() < 1e-6, "{one:?}");
        let held = step(&normals(&[asks(columns, [2.0, 3.0])]), 1);
        assert!(held[1] < 3.0 && (held[1] - 3.0).abs() < 0.01, "{held:?}");
    }
}
