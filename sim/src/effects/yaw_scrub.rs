//! Yaw scrub: a moment of constant size against turning.

use super::{
    Channel, Effect, Info, Manoeuvre, ModelSite, ParameterInfo, Role, Variable, When, numbers,
};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(YawScrub { moment_nm });

impl<S: Scalar> Effect<S> for YawScrub<S> {
    const INFO: Info = Info {
        id: "yaw_scrub",
        summary: "moment of constant size against turning",
        equation: "M = -M_0 sign(dphi/dt)",
        source: "Coulomb's law",
        site: ModelSite::Contact,
        channels: &[Channel::Yaw],
        parameters: &[ParameterInfo::number(
            Role::Size,
            "moment_nm",
            "N m",
            0.0,
            100.0,
            &[0.003, 0.01, 0.04],
        )],
        repeats: false,
        kinematic: false,
        acts: When::Always,
        condition: "whenever it turns",
        follows: &[(Channel::Yaw, Variable::TurnRate)],
        manoeuvre: Manoeuvre::SpinInPlace,
    };

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.yaw_moment = Some(self.moment_nm);
    }
}
