//! The wheels roll as if further apart, or closer, than told.

use super::{Channel, Effect, Experiment, Info, ParameterInfo, Place, Values, Variable, When};
use crate::parts::Parts;
use crate::scalar::Scalar;

/// See [`Effect::INFO`].
#[derive(Debug, Clone)]
pub(super) struct TrackWidth<S> {
    scale: S,
}

impl<S: Scalar> Effect<S> for TrackWidth<S> {
    const INFO: Info = Info {
        id: "track_width",
        summary: "effective track differs from nominal (skid steering: slip in turns)",
        equation: "b = s b_0",
        source: "plain factor",
        place: Place::Contact,
        channels: &[Channel::Yaw],
        parameters: &[ParameterInfo::number(
            "scale",
            "1",
            0.2,
            5.0,
            &[0.95, 0.98, 1.02, 1.05, 1.4],
        )],
        repeats: false,
        kinematic: true,
        acts: When::Always,
        condition: "whenever it turns",
        follows: &[(Channel::Yaw, Variable::TurnRate)],
        experiment: Experiment::SpinInPlace,
    };

    fn new(values: &Values<S>) -> Self {
        Self {
            scale: values.number("scale"),
        }
    }

    fn shape(&self, parts: &mut Parts<S>) {
        parts.half_track *= self.scale;
    }
}
