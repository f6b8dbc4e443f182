//! Static normal forces (Eq. 4 to 6), extended by payloads, slope and longitudinal load transfer.

use slipstream_bus::InputError;

use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::{Pair, Scalar};

/// Constants of the normal forces.
#[derive(Debug, Clone)]
pub(crate) struct NormalLoad<S> {
    /// N_r + N_l + N_ca (N).
    pub(crate) total: S,
    /// N_r + N_l without longitudinal acceleration (N).
    pub(crate) driven: S,
    /// h / b: N_r − N_l per newton of lateral force (Eq. 5).
    pub(crate) lateral: S,
    /// N_r − N_l at rest, from payloads beside the axis (N).
    pub(crate) offset: S,
    /// N_r + N_l per longitudinal acceleration (N s²/m); `None` as in Eq. 6.
    pub(crate) transfer: Option<S>,
}

impl<S: Scalar> NormalLoad<S> {
    /// For a robot of `mass` with `bodies` of it without payloads (kg), under `gravity` normal to
    /// the floor (m/s²).
    ///
    /// # Errors
    /// If a payload lifts the driven wheels or the caster off the floor.
    pub(super) fn new(
        parameters: &RobotParameters<S>,
        mass: S,
        bodies: S,
        gravity: S,
    ) -> Result<Self, InputError> {
        // The wheels stand where they are, whatever their effective track.
        let b = S::constant(parameters.nominal[1]);
        let (d, e) = (parameters.com_to_axle, parameters.com_to_caster);
        let total = mass * gravity;
        let payload_about_axle = parameters.payload_moment[0] + parameters.payload_mass * d;
        let caster = (bodies * d + payload_about_axle) * gravity / (d + e);
        if caster.value() > total.value() || caster.value() < 0.0 {
            return Err(InputError::new(
                "effects.payload.x_m",
                "lifts the driven wheels or the caster off the floor",
                "give a place between axle and caster, or a smaller mass",
            ));
        }
        Ok(Self {
            total,
            driven: total - caster,
            lateral: parameters.com_height / b,
            offset: -parameters.payload_moment[1] * gravity / b,
            transfer: parameters.transfer_height.map(|h| mass * h / (d + e)),
        })
    }

    /// N_r and N_l under a lateral force (N), without longitudinal acceleration; negative where a wheel would
    /// lift off.
    #[inline(always)]
    pub(crate) fn of_wheels(&self, lateral_n: S) -> Pair<S> {
        let difference = self.lateral * lateral_n + self.offset;
        [
            (self.driven + difference) * 0.5,
            (self.driven - difference) * 0.5,
        ]
    }

    /// N_ca without longitudinal acceleration (N).
    pub(crate) fn caster(&self) -> S {
        self.total - self.driven
    }
}
