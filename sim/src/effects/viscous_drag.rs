//! Viscous drag: a force in proportion to speed.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(ViscousDrag { coefficient });

impl<S: Scalar> Effect<S> for ViscousDrag<S> {
    const INFO: Info = Info {
        id: "viscous_drag",
        summary: "drag in proportion to the full velocity vector of c",
        equation: "F = -c v",
        source: "Stokes's law of drag",
        site: ModelSite::Body,
        channels: &[
            Channel::Longitudinal,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
            "coefficient",
            "N s/m",
            0.0,
            100.0,
            &[0.1, 0.4, 1.5],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[(Channel::Longitudinal, Variable::Speed)],
        manoeuvre: Manoeuvre::CoastDown,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.drag += self.coefficient;
    }
}
