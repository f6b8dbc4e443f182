//! A robot model as plain data: what `robot.toml` says, in the paper's symbols and SI units.
//!
//! A key that is absent is unknown, not zero. [`RobotModel::validate`] judges what is present;
//! whether enough is known for a simulation is for the simulator to say.

use serde::{Deserialize, Serialize};

use crate::error::InputError;

/// The model of one robot. The default is the robot of Konduri, Torres and Pagilla (section 3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotModel {
    /// Masses and lengths.
    pub robot: Body,
    /// The motor of each wheel, where known. Needed for voltage commands.
    pub motor: Option<Motor>,
    /// The encoder of each wheel, where known. Needed where wheels are recorded as ticks.
    pub encoder: Option<Encoder>,
    /// Physics beyond rolling without slip, in the order in which the file lists it.
    pub effects: Vec<EffectSpec>,
}

/// Masses and lengths of a robot with two driven wheels on one axle and a caster ahead of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// m_r: mass of the body without its wheels (kg).
    pub body_mass_kg: Option<f64>,
    /// I_rz: yaw inertia of the body about its centre of mass c (kg m²).
    pub body_yaw_inertia_kg_m2: Option<f64>,
    /// m_w: mass of one wheel, on the axle (kg).
    pub wheel_mass_kg: Option<f64>,
    /// I_wy: inertia of one wheel about the axle (kg m²).
    pub wheel_spin_inertia_kg_m2: Option<f64>,
    /// I_wz: inertia of one wheel about its vertical (kg m²).
    pub wheel_yaw_inertia_kg_m2: Option<f64>,
    /// r: wheel radius (m).
    pub wheel_radius_m: f64,
    /// b: half of the distance between the wheels (m).
    pub half_track_m: f64,
    /// d: distance from c back to the axle (m).
    pub com_to_axle_m: Option<f64>,
    /// e: distance from c forward to the caster's contact (m).
    pub com_to_caster_m: Option<f64>,
    /// h: height of c above the floor (m).
    pub com_height_m: Option<f64>,
}

/// The DC motor of each wheel: τ = τ_stall V / V_nominal − (τ_stall / ω_0) ω.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// V_nominal (V).
    pub nominal_voltage_v: f64,
    /// ω_0: speed without load at the nominal voltage (rad/s).
    pub no_load_speed_rad_s: f64,
    /// τ_stall: torque at standstill at the nominal voltage (N m).
    pub stall_torque_nm: f64,
}

/// The incremental encoder of each wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Counts in one turn of the wheel.
    pub counts_per_rev: u32,
}

/// One effect that a model lists: its name in the vocabulary and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectSpec {
    /// The identity in the vocabulary of effects, such as `wheel_slip`.
    pub effect: String,
    /// Name and value of each parameter that the model gives.
    pub parameters: Vec<(String, Parameter)>,
}

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Parameter {
    /// A number in the unit that the parameter's name carries.
    Number(f64),
    /// A text, such as the name of a stream.
    Text(String),
}

impl EffectSpec {
    /// An effect with numbers for parameters.
    pub fn new(effect: &str, parameters: &[(&str, f64)]) -> Self {
        Self {
            effect: effect.to_owned(),
            parameters: parameters
                .iter()
                .map(|&(name, value)| (name.to_owned(), Parameter::Number(value)))
                .collect(),
        }
    }
}

impl Default for RobotModel {
    fn default() -> Self {
        Self {
            robot: Body {
                body_mass_kg: Some(1.5),
                body_yaw_inertia_kg_m2: Some(0.009_753),
                wheel_mass_kg: Some(0.064),
                wheel_spin_inertia_kg_m2: Some(0.001_168),
                wheel_yaw_inertia_kg_m2: Some(0.000_584),
                wheel_radius_m: 0.0365,
                half_track_m: 0.105,
                com_to_axle_m: Some(0.055),
                com_to_caster_m: Some(0.095),
                com_height_m: Some(0.0216),
            },
            motor: Some(Motor {
                nominal_voltage_v: 12.0,
                no_load_speed_rad_s: 36.65,
                stall_torque_nm: 0.78,
            }),
            encoder: Some(Encoder {
                counts_per_rev: 1856,
            }),
            effects: Vec::new(),
        }
    }
}

impl RobotModel {
    /// The same robot with one effect more.
    #[must_use]
    pub fn with(mut self, effect: &str, parameters: &[(&str, f64)]) -> Self {
        self.effects.push(EffectSpec::new(effect, parameters));
        self
    }

    /// The paper's robot on the paper's floor: μ_s = 0.241, μ_k = 0.239 (section 3).
    pub fn paper_with_slip() -> Self {
        Self::default().with(
            "wheel_slip",
            &[("friction_static", 0.241), ("friction_kinetic", 0.239)],
        )
    }

    /// Judges the values that are present, one by one and together.
    ///
    /// # Errors
    /// The first value that is not finite or that no robot can have. Effects are judged by the
    /// simulator, which knows their bounds.
    pub fn validate(&self) -> Result<(), InputError> {
        let Body {
            body_mass_kg,
            body_yaw_inertia_kg_m2,
            wheel_mass_kg,
            wheel_spin_inertia_kg_m2,
            wheel_yaw_inertia_kg_m2,
            wheel_radius_m,
            half_track_m,
            com_to_axle_m,
            com_to_caster_m,
            com_height_m,
        } = self.robot;
        positive("robot.wheel_radius_m", Some(wheel_radius_m))?;
        positive("robot.half_track_m", Some(half_track_m))?;
        positive("robot.body_mass_kg", body_mass_kg)?;
        positive("robot.body_yaw_inertia_kg_m2", body_yaw_inertia_kg_m2)?;
        not_negative("robot.wheel_mass_kg", wheel_mass_kg)?;
        positive("robot.wheel_spin_inertia_kg_m2", wheel_spin_inertia_kg_m2)?;
        not_negative("robot.wheel_yaw_inertia_kg_m2", wheel_yaw_inertia_kg_m2)?;
        not_negative("robot.com_height_m", com_height_m)?;
        finite("robot.com_to_axle_m", com_to_axle_m)?;
        finite("robot.com_to_caster_m", com_to_caster_m)?;
        if let (Some(d), Some(e)) = (com_to_axle_m, com_to_caster_m) {
            caster_ahead(d, e)?;
        }
        if let Some(motor) = &self.motor {
            positive("motor.nominal_voltage_v", Some(motor.nominal_voltage_v))?;
            positive("motor.no_load_speed_rad_s", Some(motor.no_load_speed_rad_s))?;
            positive("motor.stall_torque_nm", Some(motor.stall_torque_nm))?;
        }
        if self
            .encoder
            .as_ref()
            .is_some_and(|encoder| encoder.counts_per_rev == 0)
        {
            return Err(InputError::new(
                "encoder.counts_per_rev",
                "is 0",
                "give the counts in one turn of the wheel",
            ));
        }
        Ok(())
    }
}

/// Eq. 6 needs the caster ahead of the axle and c between the two, else a wheel or the caster
/// would pull at the floor.
fn caster_ahead(d: f64, e: f64) -> Result<(), InputError> {
    if d < 0.0 {
        return Err(InputError::new(
            "robot.com_to_axle_m",
            format!("is {d}: the axle lies ahead of the centre of mass"),
            "give a distance of 0 or more, measured backwards from the centre of mass",
        ));
    }
    if e < 0.0 || d + e <= 0.0 {
        return Err(InputError::new(
            "robot.com_to_caster_m",
            format!("is {e}: the caster lies behind the centre of mass or on the axle"),
            "give the distance measured forwards from the centre of mass",
        ));
    }
    Ok(())
}

fn finite(key: &str, value: Option<f64>) -> Result<(), InputError> {
    match value {
        Some(value) if !value.is_finite() => Err(InputError::new(
            key,
            format!("is {value}"),
            "give a finite number",
        )),
        _ => Ok(()),
    }
}

fn not_negative(key: &str, value: Option<f64>) -> Result<(), InputError> {
    finite(key, value)?;
    match value {
        Some(value) if value < 0.0 => Err(InputError::new(
            key,
            format!("is {value}"),
            "give 0 or more",
        )),
        _ => Ok(()),
    }
}

fn positive(key: &str, value: Option<f64>) -> Result<(), InputError> {
    not_negative(key, value)?;
    match value {
        Some(0.0) => Err(InputError::new(key, "is 0", "give a number above 0")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_robot_is_one() {
        assert_eq!(RobotModel::paper_with_slip().validate(), Ok(()));
    }

    #[test]
    fn what_no_robot_can_be_names_its_key() {
        type Spoil = fn(&mut RobotModel);
        let cases: [(&str, Spoil); 6] = [
            ("robot.body_mass_kg", |m| m.robot.body_mass_kg = Some(0.0)),
            ("robot.wheel_mass_kg", |m| {
                m.robot.wheel_mass_kg = Some(-1.0)
            }),
            ("robot.wheel_radius_m", |m| {
                m.robot.wheel_radius_m = f64::NAN
            }),
            ("robot.com_to_caster_m", |m| {
                m.robot.com_to_caster_m = Some(-0.06)
            }),
            ("robot.com_to_axle_m", |m| {
                m.robot.com_to_axle_m = Some(-0.01)
            }),
            ("encoder.counts_per_rev", |m| {
                m.encoder = Some(Encoder { counts_per_rev: 0 })
            }),
        ];
        for (key, spoil) in cases {
            let mut model = RobotModel::default();
            spoil(&mut model);
            assert_eq!(model.validate().unwrap_err().place, key);
        }
    }
}
