//! Parameters of one robot and its floor, collected from the model and its effects before the plant
//! is assembled.

use slipstream_bus::{Body, InputError, RobotModel};

use super::actuator::Actuator;
use super::scalar::{Pair, Scalar};

/// Coulomb friction coefficients at a driven wheel (Eq. 9 and 10).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction<S> {
    /// μ_s, static: the contact sticks up to μ_s N (1).
    pub friction_static: S,
    /// μ_k, kinetic: the force of a sliding contact is μ_k N (1).
    pub friction_kinetic: S,
}

/// Systematic errors of the sensors, and the encoders' resolution.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensing<S> {
    /// Tracked minus declared point, x and y in the body frame (m), and measured minus true yaw
    /// (rad).
    pub pose_offset: [S; 3],
    /// Stamp minus true time of each stream (s).
    pub latency_s: Streams<S>,
    /// Clock error of each stream, stamp = t (1 + rate) (s/s).
    pub clock_rate: Streams<S>,
    /// Counted over true counts of the right and the left encoder (1).
    pub encoder_scale: Pair<S>,
    /// Counts per revolution of the wheel, where known.
    pub counts_per_rev: Option<f64>,
    /// Age of a received message's content beyond what its stamp says (s).
    pub link_delay_s: S,
}

/// One value for each stream of measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Streams<S> {
    /// Camera or motion capture.
    pub pose: S,
    /// Encoders.
    pub wheels: S,
    /// Inertial measurement.
    pub imu: S,
}

/// Parameters of one robot and its floor; symbols are those of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotParameters<S> {
    /// The first key of the dynamic model that is not given; `None` if all are.
    pub missing: Option<&'static str>,
    /// m_r (kg).
    pub body_mass: S,
    /// I_rz (kg m²).
    pub body_yaw_inertia: S,
    /// m_w (kg).
    pub wheel_mass: S,
    /// I_wy (kg m²).
    pub wheel_spin_inertia: S,
    /// I_wz (kg m²).
    pub wheel_yaw_inertia: S,
    /// True r, right and left (m).
    pub radius: Pair<S>,
    /// True b (m).
    pub half_track: S,
    /// [r, b] as the controller assumes them (m).
    pub nominal: Pair<f64>,
    /// d (m).
    pub com_to_axle: S,
    /// e (m).
    pub com_to_caster: S,
    /// h (m).
    pub com_height: S,
    /// Mass of all payloads (kg).
    pub payload_mass: S,
    /// Σ m x and Σ m y of the payloads about c, body frame (kg m).
    pub payload_moment: Pair<S>,
    /// Σ m (x² + y²) of the payloads (kg m²).
    pub payload_inertia: S,
    /// Friction at the driven wheels; `None`: they roll without slipping (Eq. 1).
    pub wheel_friction: Option<Friction<S>>,
    /// Coulomb friction torque of each wheel's bearing (N m).
    pub axle_torque: Option<S>,
    /// Rolling resistance along the body over weight (1).
    pub rolling_coefficient: Option<S>,
    /// Coulomb friction moment against yaw (N m).
    pub yaw_moment: Option<S>,
    /// Coulomb friction coefficient of the caster's contact (1).
    pub caster_friction: Option<S>,
    /// Viscous drag coefficient at c (N s/m).
    pub drag: S,
    /// Share of what each wheel turns by which its contact moves (1); `None`: all of it.
    pub travel: Option<Pair<S>>,
    /// The effect that needs commands of wheel speeds, if there is one.
    pub of_speeds: Option<&'static str>,
    /// Height of c for longitudinal load transfer (m); `None`: no transfer (Eq. 6).
    pub transfer_height: Option<S>,
    /// Slope of the floor: grade times the unit vector downhill, world frame (1).
    pub gradient: Pair<S>,
    /// Chain from command to wheels.
    pub actuator: Actuator<S>,
    /// Systematic errors of the sensors.
    pub sensing: Sensing<S>,
}

impl<S: Scalar> RobotParameters<S> {
    /// The parameters of `model` without its effects.
    ///
    /// If a mass or length is missing the model is kinematic and stand-ins take the place of the
    /// masses: under prescribed wheel speeds and without slip the motion does not depend on them.
    ///
    /// # Errors
    /// See [`RobotModel::validate`].
    pub fn new(model: &RobotModel) -> Result<Self, InputError> {
        model.validate()?;
        let body = &model.robot;
        let missing = first_missing_key(body);
        let known = |value: Option<f64>, stand_in: f64| {
            S::constant(if missing.is_none() {
                value.unwrap_or(stand_in)
            } else {
                stand_in
            })
        };
        let zero = S::constant(0.0);
        let radius = S::constant(body.wheel_radius_m);
        Ok(Self {
            missing,
            body_mass: known(body.body_mass_kg, 1.0),
            body_yaw_inertia: known(body.body_yaw_inertia_kg_m2, 1.0),
            wheel_mass: known(body.wheel_mass_kg, 0.0),
            wheel_spin_inertia: known(body.wheel_spin_inertia_kg_m2, 1.0),
            wheel_yaw_inertia: known(body.wheel_yaw_inertia_kg_m2, 0.0),
            radius: [radius; 2],
            half_track: S::constant(body.half_track_m),
            nominal: [body.wheel_radius_m, body.half_track_m],
            com_to_axle: S::constant(body.com_to_axle_m.unwrap_or(0.0)),
            com_to_caster: known(body.com_to_caster_m, 1.0),
            com_height: known(body.com_height_m, 0.0),
            payload_mass: zero,
            payload_moment: [zero; 2],
            payload_inertia: zero,
            wheel_friction: None,
            axle_torque: None,
            rolling_coefficient: None,
            yaw_moment: None,
            caster_friction: None,
            drag: zero,
            travel: None,
            of_speeds: None,
            transfer_height: None,
            gradient: [zero; 2],
            actuator: Actuator {
                speed_per_volt: model
                    .motor
                    .as_ref()
                    .filter(|_| missing.is_some())
                    .map(|motor| S::constant(motor.speed_per_volt())),
                ..Actuator::ideal(model)
            },
            sensing: Sensing::exact(model),
        })
    }
}

impl<S: Scalar> Sensing<S> {
    fn exact(model: &RobotModel) -> Self {
        let zero = S::constant(0.0);
        let none = Streams {
            pose: zero,
            wheels: zero,
            imu: zero,
        };
        Self {
            pose_offset: [zero; 3],
            latency_s: none,
            clock_rate: none,
            encoder_scale: [S::constant(1.0); 2],
            counts_per_rev: model.encoder.as_ref().map(|e| e.counts_per_rev),
            link_delay_s: zero,
        }
    }
}

/// The first key of the dynamic model that `body` does not give.
fn first_missing_key(body: &Body) -> Option<&'static str> {
    let keys = [
        ("robot.body_mass_kg", body.body_mass_kg),
        ("robot.body_yaw_inertia_kg_m2", body.body_yaw_inertia_kg_m2),
        ("robot.wheel_mass_kg", body.wheel_mass_kg),
        (
            "robot.wheel_spin_inertia_kg_m2",
            body.wheel_spin_inertia_kg_m2,
        ),
        (
            "robot.wheel_yaw_inertia_kg_m2",
            body.wheel_yaw_inertia_kg_m2,
        ),
        ("robot.com_to_axle_m", body.com_to_axle_m),
        ("robot.com_to_caster_m", body.com_to_caster_m),
        ("robot.com_height_m", body.com_height_m),
    ];
    let missing = keys.iter().find(|(_, value)| value.is_none());
    missing.map(|&(key, _)| key)
}
