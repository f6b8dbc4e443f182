//! Innovations at fixed gains: one simulation that the measurements correct as it goes.

use slipstream_sim::State;

use super::flow::Flow;
use super::linear::write;
use super::update::Gain;
use super::{Noise, in_order};

/// Whitened innovations, three for each row of the run; `watch` sees time and state before each row's
/// correction, and the disturbances. `None` where the simulation diverges, or
/// their sum of squares exceeds `most`.
pub(crate) fn innovations(
    flow: &Flow<'_>,
    noise: &Noise,
    gains: &[Gain],
    most: f64,
    mut watch: impl FnMut(f64, &State, &[f64; 5]),
) -> Option<Vec<f64>> {
    let run = flow.run;
    let order = in_order(flow.robot, run);
    let mut whitened = vec![0.0; 3 * run.rows.len()];
    let mut point = flow.start();
    let mut square = 0.0;
    for (place, &(true_s, index)) in order.iter().enumerate() {
        let row = &run.rows[index];
        flow.advance(&mut point, true_s);
        if point.is_lost() {
            return None;
        }
        watch(true_s, &point.state, &point.disturbance);
        let innovation = flow.innovation(&point, row);
        let gain = &gains[index];
        write(&mut whitened, index, gain, &innovation);
        let own = &whitened[3 * index..3 * index + 3];
        square += own.iter().map(|e| e * e).sum::<f64>();
        if square > most {
            return None;
        }
        flow.correct(&mut point, &gain.correction(&innovation));
        let next_s = order.get(place + 1).map_or(true_s, |(next_s, _)| *next_s);
        let decay = noise.decay(next_s - true_s);
        for (own, a) in point.disturbance.iter_mut().zip(&decay) {
            *own *= a;
        }
    }
    Some(whitened)
}
