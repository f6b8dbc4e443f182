//! Nominal model of the controller: kinematics (Eq. 1) and inertias, in the paper's symbols.

use std::f64::consts::TAU;

use slipstream_bus::{InputError, RobotModel};

/// Lengths of the nominal model, and its inertias if known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// r: wheel radius (m).
    pub r: f64,
    /// b: half of the distance between the wheels (m).
    pub b: f64,
    /// d: distance from c backwards to the axle (m); 0 if unknown.
    pub d: f64,
    /// Angle of one encoder count (rad).
    pub count_rad: f64,
    /// Masses and inertias, if all are known.
    pub dynamics: Option<Dynamics>,
}

/// Masses, inertias and heights of the nominal model: what torque limits and computed torque need.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dynamics {
    /// m_t = m_r + 2 m_w: total mass (kg).
    pub m_t: f64,
    /// m_r: mass of the body without the wheels (kg).
    pub m_r: f64,
    /// I_wy: inertia of a wheel about the axle (kg m²).
    pub i_wy: f64,
    /// Yaw inertia of the whole robot about the midpoint of the axle (kg m²).
    pub i_axle: f64,
    /// e: distance from c forwards to the caster (m).
    pub e: f64,
    /// h: height of c above the floor (m).
    pub h: f64,
}

impl Geometry {
    /// The nominal model of a robot. The effects of the model are unknown to the controller.
    ///
    /// # Errors
    /// The robot has no encoders, without which it cannot be controlled.
    pub fn new(model: &RobotModel) -> Result<Self, InputError> {
        let body = &model.robot;
        let Some(encoder) = &model.encoder else {
            return Err(InputError::new(
                "encoder.counts_per_rev",
                "is missing: the controller needs encoders",
                "give the counts per revolution of the wheel",
            ));
        };
        Ok(Self {
            r: body.wheel_radius_m,
            b: body.half_track_m,
            d: body.com_to_axle_m.unwrap_or(0.0),
            count_rad: TAU / encoder.counts_per_rev,
            dynamics: Dynamics::new(model),
        })
    }

    /// Wheel speeds (rad/s) for a forward velocity v (m/s) and a yaw rate w (rad/s): Eq. 1.
    pub fn wheel_speeds(&self, v: f64, w: f64) -> [f64; 2] {
        [(v + self.b * w) / self.r, (v - self.b * w) / self.r]
    }

    /// Forward velocity v (m/s) and yaw rate w (rad/s) for wheel speeds (rad/s): Eq. 1 inverted.
    pub fn twist(&self, [right, left]: [f64; 2]) -> [f64; 2] {
        [
            self.r * (right + left) / 2.0,
            self.r * (right - left) / (2.0 * self.b),
        ]
    }
}

impl Dynamics {
    fn new(model: &RobotModel) -> Option<Self> {
        let body = &model.robot;
        let (m_r, m_w) = (body.body_mass_kg?, body.wheel_mass_kg?);
        let (b, d) = (body.half_track_m, body.com_to_axle_m?);
        let yaw = body.body_yaw_inertia_kg_m2? + 2.0 * body.wheel_yaw_inertia_kg_m2?;
        Some(Self {
            m_t: m_r + 2.0 * m_w,
            m_r,
            i_wy: body.wheel_spin_inertia_kg_m2?,
            i_axle: yaw + m_r * d * d + 2.0 * m_w * b * b,
            e: body.com_to_caster_m?,
            h: body.com_height_m?,
        })
    }
}
