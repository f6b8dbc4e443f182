//! Torque limits that avoid wheel slip (Eq. 11), with the assumed or the estimated friction.

use slipstream_bus::experiment::{Control, TorqueLimit};

use crate::friction_estimator::FrictionEstimator;
use crate::geometry::Geometry;
use crate::traction::{normal_forces_n, torque_limit_nm};
use crate::wheel_torques::WheelTorques;

/// The torque limits of one robot.
#[derive(Debug, Clone)]
pub(super) struct SlipLimit {
    estimator: FrictionEstimator,
}

impl SlipLimit {
    pub(super) fn new(control: &Control, geometry: &Geometry) -> Self {
        let estimator =
            FrictionEstimator::new(control.friction_start, control.inner_period_s, geometry);
        Self { estimator }
    }

    /// The limits at the end of the inner loop (N m). Updates the friction estimate with the
    /// measured wheel speeds (rad/s) if the limit is adaptive.
    pub(super) fn inner_nm(
        &mut self,
        wheel_speed: [f64; 2],
        control: &Control,
        geometry: &Geometry,
    ) -> [f64; 2] {
        match control.torque_limit {
            TorqueLimit::None | TorqueLimit::Outer => [control.torque_max_nm; 2],
            TorqueLimit::Inner => eq11_nm(control.friction, wheel_speed, control, geometry),
            TorqueLimit::Adaptive => {
                if let Some(dynamics) = &geometry.dynamics {
                    let twist = geometry.twist(wheel_speed);
                    let normal_n = normal_forces_n(dynamics, geometry, twist);
                    self.estimator
                        .update(wheel_speed, normal_n, dynamics, geometry);
                }
                eq11_nm(self.estimator.friction(), wheel_speed, control, geometry)
            }
        }
    }

    /// Stores the torques of an inner tick for the friction estimate.
    pub(super) fn store_torques(&mut self, torques: &WheelTorques) {
        self.estimator.store_torques(torques);
    }

    /// The friction coefficient behind the limits (1) and its standard deviation; 0 where there is
    /// none.
    pub(super) fn friction(&self, control: &Control) -> [f64; 2] {
        match control.torque_limit {
            TorqueLimit::None => [0.0; 2],
            TorqueLimit::Inner | TorqueLimit::Outer => [control.friction, 0.0],
            TorqueLimit::Adaptive => [
                self.estimator.friction(),
                self.estimator.standard_deviation(),
            ],
        }
    }
}

/// Eq. 11 for both wheels, each with its own normal force, at most the limit of the motors (N m).
pub(super) fn eq11_nm(
    friction: f64,
    wheel_speed: [f64; 2],
    control: &Control,
    geometry: &Geometry,
) -> [f64; 2] {
    let max_nm = control.torque_max_nm;
    let Some(dynamics) = &geometry.dynamics else {
        return [max_nm; 2];
    };
    let twist = geometry.twist(wheel_speed);
    normal_forces_n(dynamics, geometry, twist)
        .map(|n| torque_limit_nm(dynamics, geometry, friction, n).min(max_nm))
}
