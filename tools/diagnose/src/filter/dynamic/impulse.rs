//! Score and information of an impulse at every row, by one backward pass (generalised likelihood
//! ratio; Willsky and Jones 1976).

use super::gains::{Pass, Passed};
use super::update::Gain;
use super::{DISTURBANCES, DISTURBED, Matrix, N, Vector};

/// An impulse between two rows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Impulse {
    /// When (s).
    pub(crate) t_s: f64,
    /// Along the body and across it (N s).
    pub(crate) size: [f64; 2],
    /// Gain in −2 ln L, were the innovations linear in it.
    pub(crate) gain: f64,
}

/// Intervals between rows that are shorter are not looked at (s).
const SHORTEST_S: f64 = 3e-3;

/// What all later rows say of a change of the state.
struct LaterRows {
    information: Matrix,
    score: Vector,
}

/// One row with what it would say of a change of the state before it.
struct SeenRow<'a> {
    row: &'a Passed,
    gain: &'a Gain,
    /// Weighted, whitened innovation.
    innovation: [f64; 3],
    /// Its derivatives by the state before the row.
    derivatives: [Vector; 3],
    /// State after the row's correction, by the state before it.
    carried: Matrix,
}

/// Impulses of a force at c, along and across the body, that gain most in each interval. The part
/// across acts as a moment with the lever `com_to_axle_m`. `whitened` and `weights` are those of the
/// rows of the run.
pub(crate) fn impulses(
    pass: &Pass,
    whitened: &[f64],
    weights: &[f64],
    com_to_axle_m: f64,
) -> Vec<Impulse> {
    let mut later = LaterRows {
        information: [[0.0; N]; N],
        score: [0.0; N],
    };
    let mut out = Vec::new();
    for (place, row) in pass.rows.iter().enumerate().rev() {
        let at = 3 * row.row;
        let gain = &pass.gains[row.row];
        let seen = SeenRow::new(row, gain, &whitened[at..at + 3], &weights[at..at + 3]);
        let since_s = place
            .checked_sub(1)
            .map_or(row.true_s, |before| pass.rows[before].true_s);
        let over_s = row.true_s - since_s;
        if over_s > SHORTEST_S {
            out.extend(seen.impulse(&later, [since_s, over_s], com_to_axle_m));
        }
        later = later.before(&seen);
    }
    out
}

impl<'a> SeenRow<'a> {
    fn new(row: &'a Passed, gain: &'a Gain, whitened: &[f64], weights: &[f64]) -> Self {
        let derivatives = std::array::from_fn(|a| {
            std::array::from_fn(|j| {
                let seen = (0..=a).map(|b| gain.whitening[a][b] * row.step.measurement[b][j]);
                -weights[a] * seen.sum::<f64>()
            })
        });
        let mut carried = row.step.flow;
        for (i, line) in carried.iter_mut().enumerate() {
            for (k, g) in gain.gain[i].iter().zip(&row.step.measurement) {
                for (own, g) in line.iter_mut().zip(g) {
                    *own -= k * g;
                }
            }
            if let Some(a) = i.checked_sub(DISTURBED).and_then(|i| row.decay.get(i)) {
                line.iter_mut().for_each(|own| *own *= a);
            }
        }
        Self {
            row,
            gain,
            innovation: std::array::from_fn(|a| whitened[a] * weights[a]),
            derivatives,
            carried,
        }
    }

    /// State after the row, and its innovation, by a force on the disturbance `k` that ends with the
    /// row.
    fn column(&self, k: usize, lever: f64) -> (Vector, [f64; 3]) {
        let state = std::array::from_fn(|i| {
            if !(DISTURBED..DISTURBED + DISTURBANCES).contains(&i) {
                return lever * self.carried[i][k];
            }
            let gain = self.gain.gain[i].iter().zip(&self.row.step.measurement);
            let corrected: f64 = gain.map(|(gain, g)| gain * g[k]).sum();
            -lever * self.row.decay[i - DISTURBED] * corrected
        });
        (state, self.derivatives.map(|line| lever * line[k]))
    }

    /// The impulse in the interval before the row that gains most.
    fn impulse(
        &self,
        later: &LaterRows,
        [since_s, over_s]: [f64; 2],
        lever: f64,
    ) -> Option<Impulse> {
        let columns = [
            self.column(DISTURBED, 1.0),
            self.column(DISTURBED + 1, lever),
        ];
        let b = [0, 1].map(|i| {
            let (state, own) = &columns[i];
            dot(state, &later.score) + dot(own, &self.innovation)
        });
        let n = |i: usize, k: usize| {
            let ((v, own), (w, other)) = (&columns[i], &columns[k]);
            let far: f64 = (0..N).map(|r| v[r] * dot(&later.information[r], w)).sum();
            far + dot(own, other)
        };
        let (n00, n01, n11) = (n(0, 0), n(0, 1), n(1, 1));
        let ridge = 1e-9 * (n00 + n11) + 1e-12;
        let (n00, n11) = (n00 + ridge, n11 + ridge);
        let determinant = n00 * n11 - n01 * n01;
        let x = [
            -(n11 * b[0] - n01 * b[1]) / determinant,
            -(n00 * b[1] - n01 * b[0]) / determinant,
        ];
        (determinant > 0.0).then(|| Impulse {
            t_s: since_s + over_s / 2.0,
            size: x.map(|x| x * over_s),
            gain: -(x[0] * b[0] + x[1] * b[1]),
        })
    }
}

impl LaterRows {
    /// What all rows from this one on say of a change of the state before it.
    fn before(&self, seen: &SeenRow<'_>) -> Self {
        // information times A
        let mut half = [[0.0; N]; N];
        for (line, information) in half.iter_mut().zip(&self.information) {
            for (n, carried) in information.iter().zip(&seen.carried) {
                add(line, *n, carried);
            }
        }
        let mut information = [[0.0; N]; N];
        let mut score = [0.0; N];
        for ((carried, half), own) in seen.carried.iter().zip(&half).zip(&self.score) {
            add(&mut score, *own, carried);
            for (line, a) in information.iter_mut().zip(carried) {
                add(line, *a, half);
            }
        }
        for (line, e) in seen.derivatives.iter().zip(&seen.innovation) {
            add(&mut score, *e, line);
            for (own, a) in information.iter_mut().zip(line) {
                add(own, *a, line);
            }
        }
        Self { information, score }
    }
}

/// Adds `factor` times `from` to `to`.
fn add(to: &mut Vector, factor: f64, from: &Vector) {
    if factor != 0.0 {
        for (own, other) in to.iter_mut().zip(from) {
            *own += factor * other;
        }
    }
}

fn dot<const M: usize>(a: &[f64; M], b: &[f64; M]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::impulses;
    use crate::filter::dynamic::Noise;
    use crate::model::plant::machine::Machine;
    use crate::predict::fixture;

    #[test]
    fn a_push_is_seen_where_and_as_large_as_it_was() {
        let push = [("t_s", 4.0), ("impulse_n_s", 0.1), ("direction_rad", 0.5)];
        let truth = RobotModel::default().with("push", &push);
        let track = fixture::driven(&truth, 8.0, fixture::gentle);
        let machine = Machine::new(vec![track], RobotModel::default(), &[]);
        let noise = Noise {
            size: [0.2, 4e-4, 1e-5, 1e-4, 1e-5],
            time_s: [0.05, 0.1, 0.2],
            of_wheels: false,
            jitter_s: 0.0,
            beyond: [0.0; 3],
        };
        let fit = machine.pass(Vec::new(), noise).unwrap();
        let weights = vec![1.0; fit.whitened.len()];
        let lever = machine.model.robot.com_to_axle_m.unwrap();
        let all = impulses(&fit.passes[0], &fit.whitened, &weights, lever);
        let best = all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain)).unwrap();
        // in the interval between two rows, 20 ms, in which most of its 60 ms lie
        assert!((best.t_s - 4.03).abs() < 0.03, "{best:?}");
        // what lies beyond that interval is taken for noise
        let size = best.size[0].hypot(best.size[1]);
        assert!((0.02..0.15).contains(&size), "{best:?}");
    }
}
