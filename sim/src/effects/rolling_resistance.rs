//! Rolling resistance: a force of constant size against the motion.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(RollingResistance { coefficient });

impl<S: Scalar> Effect<S> for RollingResistance<S> {
    const INFO: Info = Info {
        id: "rolling_resistance",
        summary: "force of constant size on the body, along its axis, against the motion",
        equation: "F = -c m g sign(u)",
        source: "Coulomb's law; c = force / weight, payload included",
        site: ModelSite::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
            "coefficient",
            "1",
            0.0,
            1.0,
            &[0.003, 0.01, 0.03],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[(Channel::Longitudinal, Variable::Speed)],
        manoeuvre: Manoeuvre::CoastDown,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.rolling_coefficient = Some(self.coefficient);
    }
}
