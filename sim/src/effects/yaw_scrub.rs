//! Yaw scrub: a moment of constant size against turning.

use super::parameter::size;
use super::{Effect, Info, numbers};
use crate::parts::parameters::RobotParameters;
use crate::parts::scalar::Scalar;

numbers!(YawScrub { moment_nm });

impl<S: Scalar> Effect<S> for YawScrub<S> {
    const INFO: Info = Info::turning("yaw_scrub", "moment of constant size against turning")
        .equation("M = -M_0 sign(dphi/dt)")
        .source("Coulomb's law")
        .parameters(&[size("moment_nm", "N m", [0.0, 100.0], &[0.003, 0.01, 0.04])]);

    fn apply(&self, parameters: &mut RobotParameters<S>) {
        parameters.yaw_moment = Some(self.moment_nm);
    }
}
