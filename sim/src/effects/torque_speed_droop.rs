//! Torque-speed droop: drive torque falls with wheel speed (back-EMF, viscous bearings).

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(TorqueSpeedDroop { coefficient });

impl<S: Scalar> Effect<S> for TorqueSpeedDroop<S> {
    const INFO: Info = Info {
        id: "torque_speed_droop",
        summary: "drive torque falls with wheel speed (back-EMF, viscous bearing)",
        equation: "tau = tau_c - k omega",
        source: "DC motor's torque-speed line",
        site: ModelSite::DriveTrain,
        channels: &[
            Channel::Longitudinal,
            Channel::Yaw,
            Channel::WheelRight,
            Channel::WheelLeft,
        ],
        parameters: &[ParameterInfo::number(
            Role::Size,
            "coefficient",
            "N m s/rad",
            0.0,
            10.0,
            &[5e-4, 2e-3, 8e-3],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "the more, the faster the wheels turn",
        follows: &[
            (Channel::WheelRight, Variable::Speed),
            (Channel::WheelLeft, Variable::Speed),
        ],
        manoeuvre: Manoeuvre::LiftedWheels,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.actuator.droop += self.coefficient;
    }
}
