//! A machine whose masses are known as it was fitted to recordings, for whoever watches it go on.

use slipstream_bus::InputError;

use super::examine::unusable;
use super::judged::alone;
use crate::filter::dynamic::Noise;
use crate::model::hypothesis::with;
use crate::model::plant::machine::Machine;
use crate::predict::predictor::Predictor;
use crate::request::{Request, Runs};

/// What happened once says nothing of what goes on.
const ONCE: &str = "push";

/// A machine as it was fitted.
pub(crate) struct Baseline {
    /// Its model has everything that was lacking.
    pub(crate) machine: Machine,
    pub(crate) noise: Noise,
}

/// Fits one machine.
///
/// # Errors
/// A machine that cannot be simulated by its model, or with too little to fit.
pub(crate) fn baseline(
    request: &Request<'_>,
    runs: &Runs<'_>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Baseline, InputError> {
    let excluded = [request.excluded, &[ONCE.to_owned()]].concat();
    let request = &Request {
        excluded: &excluded,
        ..*request
    };
    let predictor = Predictor::new(request, runs)?;
    let judged = alone(request, &predictor, progress).ok_or_else(|| unusable(&runs[0].1.name))?;
    let fit = &judged.selected.fit;
    let model = with(&judged.machine.model, &fit.hypotheses);
    Ok(Baseline {
        machine: Machine::new(judged.machine.tracks.clone(), model, &excluded),
        noise: fit.noise,
    })
}
