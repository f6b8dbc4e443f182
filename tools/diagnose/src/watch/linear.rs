//! One row of a filter, linear about the course that the filter takes: what a change of its state or of a parameter makes
//! of the row's innovation and of the state behind it.

/// A row of `m` numbers heard by a filter with a state of `n`, of which `p` parameters may change.
#[derive(Debug, Clone, Default)]
pub(crate) struct Linear {
    pub(crate) m: usize,
    pub(crate) n: usize,
    pub(crate) p: usize,
    /// Its innovation, whitened.
    pub(crate) innovation: Vec<f64>,
    /// Derivatives of it by the state before the row (m by n) and by the parameters (m by p).
    pub(crate) by_state: Vec<f64>,
    pub(crate) by_parameters: Vec<f64>,
    /// Derivatives of the state behind it, by the state before it (n by n) and by the parameters (n by p).
    pub(crate) state_by_state: Vec<f64>,
    pub(crate) state_by_parameters: Vec<f64>,
}

/// What a filter makes of a row from one state and with one choice of parameters: measured minus predicted, and the
/// state behind it.
pub(crate) type Made<const M: usize, const N: usize> = ([f64; M], [f64; N]);

/// Size of a change by which a filter is differentiated.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Change {
    /// Of an entry of the state.
    State(usize, f64),
    /// Of a parameter; who is differentiated knows by how much.
    Parameter(usize),
}

impl Linear {
    /// By differences: `step` is the filter of one row after a change, `steps` the sizes of changes of the state, and
    /// `parameters` those of the parameters (0: the row does not depend on it). `whitening` is what makes the innovation
    /// white (rows of a triangular factor), times the root of the weight of the row.
    pub(crate) fn by_differences<const M: usize, const N: usize>(
        whitening: &[[f64; M]; M],
        steps: &[f64; N],
        parameters: &[f64],
        mut step: impl FnMut(Option<Change>) -> Made<M, N>,
    ) -> Self {
        let (e, x) = step(None);
        let p = parameters.len();
        let white = |d: &[f64; M]| whitening.map(|row| row.iter().zip(d).map(|(w, d)| w * d).sum());
        let innovation: [f64; M] = white(&e);
        let mut own = Self {
            m: M,
            n: N,
            p,
            innovation: innovation.to_vec(),
            by_state: vec![0.0; M * N],
            by_parameters: vec![0.0; M * p],
            state_by_state: vec![0.0; N * N],
            state_by_parameters: vec![0.0; N * p],
        };
        let mut put = |made: Made<M, N>, size: f64, at: usize, of_state: bool| {
            let slope: [f64; M] = white(&std::array::from_fn(|i| (made.0[i] - e[i]) / size));
            let width = if of_state { N } else { p };
            let (seen, moved) = if of_state {
                (&mut own.by_state, &mut own.state_by_state)
            } else {
                (&mut own.by_parameters, &mut own.state_by_parameters)
            };
            for i in 0..M {
                seen[i * width + at] = slope[i];
            }
            for i in 0..N {
                moved[i * width + at] = (made.1[i] - x[i]) / size;
            }
        };
        for (i, size) in steps.iter().enumerate() {
            put(step(Some(Change::State(i, *size))), *size, i, true);
        }
        for (i, size) in parameters.iter().enumerate().filter(|(_, s)| **s != 0.0) {
            put(step(Some(Change::Parameter(i))), *size, i, false);
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_linear_filter_are_its_matrices() {
        // x' = [x0 + 2 x1 + 3 p, 0.5 x1], e = 4 - x0 - 0.5 p
        let own = Linear::by_differences(&[[2.0]], &[1e-3, 1e-3], &[1e-3, 0.0], |change| {
            let (mut x, mut p) = ([1.0, -2.0], 0.7);
            match change {
                Some(Change::State(i, h)) => x[i] += h,
                Some(Change::Parameter(0)) => p += 1e-3,
                _ => (),
            }
            (
                [4.0 - x[0] - 0.5 * p],
                [x[0] + 2.0 * x[1] + 3.0 * p, 0.5 * x[1]],
            )
        });
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(&own.innovation, &[2.0 * (3.0 - 0.35)]));
        assert!(near(&own.by_state, &[-2.0, 0.0]));
        assert!(near(&own.by_parameters, &[-1.0, 0.0]));
        assert!(near(&own.state_by_state, &[1.0, 2.0, 0.0, 0.5]));
        assert!(near(&own.state_by_parameters, &[3.0, 0.0, 0.0, 0.0]));
    }
}
