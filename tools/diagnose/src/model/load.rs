//! What the motors of a robot move, where wheels under voltage are all that is measured.
//!
//! How fast such wheels speed up tells the inertia over the stall torque and neither of both: a data sheet's torque is
//! good to some tens of per cent, and a robot that is held in the air moves its wheels alone. The share of the body
//! that loads the motors is fitted beside everything else. It is no finding.

use slipstream_bus::RobotModel;
use slipstream_sim::effects::{
    Channel, Domain, Info, Manoeuvre, ModelSite, ParameterInfo, Role, When,
};

use super::hypothesis::Hypothesis;

/// The share, as effects are described.
static SHARE: Info = Info {
    id: "load",
    summary: "the motors move a share of the body",
    equation: "m = s m_0, I = s I_0",
    source: "equations of motion of the model, divided by the stall torque",
    site: ModelSite::Body,
    channels: &[Channel::Longitudinal, Channel::Yaw],
    parameters: &[ParameterInfo {
        role: Role::Factor,
        name: "share",
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

/// The whole body.
pub(crate) fn whole() -> Hypothesis {
    Hypothesis::new(&SHARE, vec![("share", 1.0)])
}

/// Whether `own` is a share of the body and no effect.
pub(crate) fn is_load(own: &Hypothesis) -> bool {
    own.info.id == SHARE.id
}

/// Gives `model` the share of its body that `own` says.
pub(super) fn apply(own: &Hypothesis, model: &mut RobotModel) {
    let share = own.value("share").unwrap_or(1.0);
    let body = &mut model.robot;
    for own in [&mut body.body_mass_kg, &mut body.body_yaw_inertia_kg_m2] {
        *own = own.map(|whole| share * whole);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::hypothesis::with;

    #[test]
    fn a_share_of_the_body_is_that_of_its_mass_and_its_inertia() {
        let model = RobotModel::default();
        let mut half = whole();
        half.set("share", 0.5);
        let own = with(&model, &[half]);
        assert!(own.effects.is_empty());
        let of =
            |model: &RobotModel| [model.robot.body_mass_kg, model.robot.body_yaw_inertia_kg_m2];
        for (half, whole) in of(&own).into_iter().zip(of(&model)) {
            assert_eq!(half, whole.map(|own| 0.5 * own));
        }
        assert_eq!(of(&with(&model, &[whole()])), of(&model));
    }
}
