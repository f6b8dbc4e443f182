//! Innovations at fixed gains: one simulation that the measurements correct as it goes.

use slipstream_sim::State;

use super::flow::Flow;
use super::linear::write;
use super::update::Gain;
use super::{Noise, in_order};

/// Whitened innovations, three for each row of the run; `watch` sees time and state before each row's
/// correction, and the disturbances.
pub(crate) fn innovations(
    flow: &Flow<'_>,
    noise: &Noise,
    gains: &[Gain],
    mut watch: impl FnMut(f64, &State, &[f64; 5]),
) -> Vec<f64> {
    let run = flow.run;
    let order = in_order(flow.robot, run);
    let mut whitened = vec![0.0; 3 * run.rows.len()];
    let mut point = flow.start();
    for (place, &(true_s, index)) in order.iter().enumerate() {
        let row = &run.rows[index];
        flow.advance(&mut point, true_s);
        watch(true_s, &point.state, &point.disturbance);
        let innovation = flow.innovation(&point, row);
        let gain = &gains[index];
        write(&mut whitened, index, gain, &innovation);
        flow.correct(&mut point, &gain.correction(&innovation));
        let next_s = order.get(place + 1).map_or(true_s, |(next_s, _)| *next_s);
        let decay = noise.decay(next_s - true_s);
        for (own, a) in point.disturbance.iter_mut().zip(&decay) {
            *own *= a;
        }
    }
    whitened
}
