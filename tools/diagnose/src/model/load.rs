//! What the motors of a robot move, where wheels under voltage are all that is measured.
//!
//! How fast such wheels speed up tells the inertia over the stall torque and neither of both: a data sheet's torque is
//! good to some tens of per cent, and a robot that is held in the air moves its wheels alone. The share of the body
//! that loads the motors is fitted beside everything else. It is no finding.

use slipstream_bus::RobotModel;
use slipstream_sim::effects::{
    Channel, Domain, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When,
};

/// Its number.
pub(super) const NUMBER: &str = "share";

/// The share, as effects are described.
pub(super) static SHARE: Info = Info {
    id: "load",
    summary: "the motors move a share of the body",
    equation: "m = s m_0, I = s I_0",
    source: "equations of motion of the model, divided by the stall torque",
    site: ModelSite::Body,
    channels: &[Channel::Longitudinal, Channel::Yaw],
    parameters: &[ParameterInfo {
        role: Role::Factor,
        name: NUMBER,
        unit: "1",
        domain: Domain::Number {
            lower: 0.01,
            upper: 20.0,
            probes: &[0.5, 2.0],
        },
        alternative: false,
        optional: false,
    }],
    repeats: false,
    kinematic: false,
    acts: When::Always,
    condition: "always",
    follows: &[],
    manoeuvre: Manoeuvre::AddedMass,
};

/// Gives `model` this share of its body.
pub(super) fn apply(share: f64, model: &mut RobotModel) {
    let body = &mut model.robot;
    for own in [&mut body.body_mass_kg, &mut body.body_yaw_inertia_kg_m2] {
        *own = own.map(|whole| share * whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_the_body_is_that_of_its_mass_and_its_inertia() {
        let model = RobotModel::default();
        let mut own = model.clone();
        apply(0.5, &mut own);
        let of =
            |model: &RobotModel| [model.robot.body_mass_kg, model.robot.body_yaw_inertia_kg_m2];
        for (half, whole) in of(&own).into_iter().zip(of(&model)) {
            assert_eq!(half, whole.map(|own| 0.5 * own));
        }
    }
}
