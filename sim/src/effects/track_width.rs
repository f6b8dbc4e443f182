//! Track width: the effective distance between the wheels differs from nominal.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(TrackWidth { scale });

impl<S: Scalar> Effect<S> for TrackWidth<S> {
    const INFO: Info = Info {
        id: "track_width",
        summary: "effective track differs from nominal (skid steering: slip in turns)",
        equation: "b = s b_0",
        source: "plain factor",
        site: ModelSite::Contact,
        channels: &[Channel::Yaw],
        parameters: &[ParameterInfo::number(
            Role::Factor,
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
        manoeuvre: Manoeuvre::SpinInPlace,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.half_track *= self.scale;
    }
}
