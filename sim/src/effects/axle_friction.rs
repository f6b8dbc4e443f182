//! Axle friction: Coulomb friction in the wheels' bearings.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(AxleFriction { torque_nm });

impl<S: Scalar> Effect<S> for AxleFriction<S> {
    const INFO: Info = Info {
        id: "axle_friction",
        summary: "Coulomb torque against wheel rotation, both wheels alike",
        equation: "tau = -tau_0 sign(omega)",
        source: "Coulomb's law",
        site: ModelSite::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
            "torque_nm",
            "N m",
            0.0,
            100.0,
            &[0.002, 0.006, 0.02],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it moves",
        follows: &[
            (Channel::WheelRight, Variable::Speed),
            (Channel::WheelLeft, Variable::Speed),
        ],
        manoeuvre: Manoeuvre::LiftedWheels,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.axle_torque = Some(self.torque_nm);
    }
}
