//! Parameters of one robot and its floor, collected from the model and its effects before the plant is assembled.

use slipstream_bus::{InputError, RobotModel};

use super::actuator::Actuator;
use super::scalar::{Pair, Scalar};

/// Static and kinetic coefficient of Coulomb friction at a driven wheel (Eq. 9 and 10).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction<S> {
    /// μ_s: what it takes to break away.
    pub friction_static: S,
    /// μ_k: what is left while sliding.
    pub friction_kinetic: S,
}

/// How the sensors see the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensing<S> {
    /// Tracked point minus declared point, body frame (m), and measured minus true yaw (rad).
    pub pose_offset: [S; 3],
    /// Stamp minus true time of each stream (s).
    pub latency_s: Streams<S>,
    /// Stamp = t (1 + rate) in each stream.
    pub clock_rate: Streams<S>,
    /// Counts per true count of the right and the left encoder.
    pub encoder_scale: Pair<S>,
    /// Counts in one turn of the wheel, where known.
    pub counts_per_rev: Option<f64>,
    /// How much older a received message's content is than its stamp says (s).
    pub link_delay_s: S,
}

/// One number for each stream of measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Streams<S> {
    /// Camera or motion capture.
    pub pose: S,
    /// Encoders.
    pub wheels: S,
    /// Inertial measurement.
    pub imu: S,
}

/// One robot and its floor in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotParameters<S> {
    /// The first dynamic key that the model does not give; `None` where dynamics are known.
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
    /// r as it is, right and left (m).
    pub radius: Pair<S>,
    /// b as it is (m).
    pub half_track: S,
    /// r and b as the controller believes them (m).
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
    /// Friction at the driven wheels; `None` rolls without slipping (Eq. 1).
    pub grip: Option<Friction<S>>,
    /// Coulomb torque against the rotation of each wheel (N m).
    pub axle_torque: Option<S>,
    /// Force against the motion along the body's axis, as a share of the weight.
    pub rolling_coefficient: Option<S>,
    /// Moment against turning (N m).
    pub yaw_moment: Option<S>,
    /// Coulomb friction at the caster.
    pub caster_friction: Option<S>,
    /// Viscous drag at c (N s/m).
    pub drag: S,
    /// Height through which longitudinal acceleration shifts load (m).
    pub transfer_height: Option<S>,
    /// Downhill direction times grade, world frame.
    pub gradient: Pair<S>,
    /// Command to wheels.
    pub drive: Actuator<S>,
    /// Wheels and body to recordings.
    pub sensing: Sensing<S>,
}

impl<S: Scalar> RobotParameters<S> {
    /// The numbers of `model` without its effects. Where a mass or length is unknown, the robot is
    /// kinematic: a unit mass on the axle moves as any other would.
    ///
    /// # Errors
    /// See [`RobotModel::validate`].
    pub fn new(model: &RobotModel) -> Result<Self, InputError> {
        model.validate()?;
        let body = &model.robot;
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
        let missing = keys
            .iter()
            .find(|(_, value)| value.is_none())
            .map(|&(key, _)| key);
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
            grip: None,
            axle_torque: None,
            rolling_coefficient: None,
            yaw_moment: None,
            caster_friction: None,
            drag: zero,
            transfer_height: None,
            gradient: [zero; 2],
            drive: Actuator::direct(model),
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
            counts_per_rev: model.encoder.as_ref().map(|e| f64::from(e.counts_per_rev)),
            link_delay_s: zero,
        }
    }
}
