//! When both wheels lose their grip.

use slipstream_bus::RobotModel;

use super::GRAVITY_M_S2;

/// The torque at which both wheels break away when they drive straight ahead (Eq. 11, without
/// payload): F (r + 2 I_wy / (m_t r)) with F the friction at one wheel.
pub fn breakaway_nm(model: &RobotModel, friction: f64) -> Option<f64> {
    let body = &model.robot;
    let mass = body.body_mass_kg? + 2.0 * body.wheel_mass_kg?;
    let (d, e, r) = (
        body.com_to_axle_m?,
        body.com_to_caster_m?,
        body.wheel_radius_m,
    );
    let normal = mass * GRAVITY_M_S2 * e / (d + e) / 2.0;
    Some(friction * normal * (r + 2.0 * body.wheel_spin_inertia_kg_m2? / (mass * r)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, Robot};

    fn slipping(friction: f64) -> RobotModel {
        let values = [
            ("friction_static", friction),
            ("friction_kinetic", friction),
        ];
        RobotModel::default().with("wheel_slip", &values)
    }

    /// Whether a wheel ever slides in 0.2 s of this torque on both, from rest.
    fn breaks_away(model: &RobotModel, torque_nm: f64) -> bool {
        let robot: Robot = Robot::new(model).unwrap();
        let mut state = robot.start([0.0; 3]);
        let command = Command::Torque {
            right_nm: torque_nm,
            left_nm: torque_nm,
        };
        (0..200).any(|k| {
            robot.step(&mut state, f64::from(k) * 1e-3, 1e-3, &command);
            state.slides() == [true; 2]
        })
    }

    #[test]
    fn the_torque_of_the_condition_is_where_the_plant_breaks_away() {
        for friction in [0.1, 0.239, 0.5] {
            let model = slipping(friction);
            let torque_nm = breakaway_nm(&model, friction).unwrap();
            assert!(!breaks_away(&model, 0.99 * torque_nm), "{torque_nm}");
            assert!(breaks_away(&model, 1.01 * torque_nm), "{torque_nm}");
        }
    }
}
