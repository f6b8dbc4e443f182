//! Track width: the effective distance between the wheels differs from nominal.

use super::parameter::factor;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(TrackWidth { scale });

impl<S: Scalar> Effect<S> for TrackWidth<S> {
    const INFO: Info = Info::turning(
        "track_width",
        "effective track differs from nominal (skid steering: slip in turns)",
    )
    .equation("b = s b_0")
    .source("plain factor")
    .parameters(&[factor("scale", [0.2, 5.0], &[0.95, 0.98, 1.02, 1.05, 1.4])])
    .kinematic();

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.half_track *= self.scale;
    }
}
