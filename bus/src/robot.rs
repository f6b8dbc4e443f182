//! Robot model as plain data: the content of `robot.toml`, in the paper's symbols and SI units.
//!
//! A missing key means unknown, not zero. [`RobotModel::validate`] checks the values that are
//! given; the simulator checks whether they suffice for a simulation.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::range::{self, invalid, within};

/// The model of one robot. The default is the paper's robot (Konduri, Torres, Pagilla, section 3),
/// without wheel slip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotModel {
    /// Masses, inertias and lengths.
    pub robot: Body,
    /// The motor of each wheel, where known. Needed for voltage commands.
    pub motor: Option<Motor>,
    /// The encoder of each wheel, where known. Needed where wheels are recorded as ticks.
    pub encoder: Option<Encoder>,
    /// Physics beyond pure rolling, in the order of the file.
    pub effects: Vec<EffectSpec>,
}

/// Masses, inertias and lengths of a robot with two driven wheels on one axle and a caster ahead of
/// them.
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
    /// d: distance from c backwards to the axle (m).
    pub com_to_axle_m: Option<f64>,
    /// e: distance from c forwards to the caster's contact (m).
    pub com_to_caster_m: Option<f64>,
    /// h: height of c above the floor (m).
    pub com_height_m: Option<f64>,
}

impl Body {
    /// A robot of which wheel radius and half track (m) alone are known.
    pub fn kinematic(wheel_radius_m: f64, half_track_m: f64) -> Self {
        Self {
            body_mass_kg: None,
            body_yaw_inertia_kg_m2: None,
            wheel_mass_kg: None,
            wheel_spin_inertia_kg_m2: None,
            wheel_yaw_inertia_kg_m2: None,
            wheel_radius_m,
            half_track_m,
            com_to_axle_m: None,
            com_to_caster_m: None,
            com_height_m: None,
        }
    }
}

/// The DC motor of each wheel: τ = τ_stall V / V_nominal − (τ_stall / ω_0) ω.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// V_nominal (V).
    pub nominal_voltage_v: f64,
    /// ω_0: no-load speed at the nominal voltage (rad/s).
    pub no_load_speed_rad_s: f64,
    /// τ_stall: stall torque at the nominal voltage (N m).
    pub stall_torque_nm: f64,
}

impl Motor {
    /// Speed without a load per volt (rad/s/V): ω_0 / V_nominal.
    pub fn speed_per_volt(&self) -> f64 {
        self.no_load_speed_rad_s / self.nominal_voltage_v
    }

    /// Speed that a motor loses per torque (rad/s per N m): ω_0 / τ_stall.
    pub fn speed_per_torque(&self) -> f64 {
        self.no_load_speed_rad_s / self.stall_torque_nm
    }
}

/// The incremental encoder on each wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Encoder {
    /// Counts per revolution of the wheel. Gears make it a fraction, such as 2578.33.
    pub counts_per_rev: f64,
}

impl Encoder {
    /// An encoder that counts microradians, where nothing is known of the real one.
    pub const MICRORADIANS: Self = Self {
        counts_per_rev: std::f64::consts::TAU * 1e6,
    };
    /// Counts per revolution that an encoder may have.
    pub const COUNTS: std::ops::RangeInclusive<f64> = 1.0..=4_294_967_295.0;
}

/// An effect of a model: its name in the catalogue of effects and its parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectSpec {
    /// Name in the catalogue of effects, such as `wheel_slip`.
    pub effect: String,
    /// Name and value of each given parameter.
    pub parameters: Vec<(String, Parameter)>,
}

/// The value of an effect's parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Parameter {
    /// A number in the unit named by the parameter's suffix.
    Number(f64),
    /// A text, such as the name of a stream.
    Text(String),
    /// Numbers, such as the knots of a table.
    List(Vec<f64>),
}

impl EffectSpec {
    /// An effect whose parameters are all numbers.
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
                counts_per_rev: 1856.0,
            }),
            effects: Vec::new(),
        }
    }
}

impl RobotModel {
    /// Adds an effect.
    #[must_use]
    pub fn with(mut self, effect: &str, parameters: &[(&str, f64)]) -> Self {
        self.effects.push(EffectSpec::new(effect, parameters));
        self
    }

    /// The number `parameter` of the first effect `effect` that the model lists; `None` where it lists none.
    pub fn number(&self, effect: &str, parameter: &str) -> Option<f64> {
        let spec = self.effects.iter().find(|spec| spec.effect == effect)?;
        spec.parameters.iter().find_map(|(own, value)| match value {
            Parameter::Number(value) if own == parameter => Some(*value),
            _ => None,
        })
    }

    /// The paper's robot with wheel slip on the paper's floor: μ_s = 0.241, μ_k = 0.239 (section
    /// 3).
    pub fn paper_with_slip() -> Self {
        Self::default().with(
            "wheel_slip",
            &[("friction_static", 0.241), ("friction_kinetic", 0.239)],
        )
    }

    /// Checks the given values, each by itself and in combination.
    ///
    /// # Errors
    /// The first value outside of its [`range`]. The simulator checks effects, because it knows
    /// their bounds.
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
        for (key, value, range) in [
            ("wheel_radius_m", Some(wheel_radius_m), range::LENGTH_M),
            ("half_track_m", Some(half_track_m), range::LENGTH_M),
            ("body_mass_kg", body_mass_kg, range::MASS_KG),
            (
                "body_yaw_inertia_kg_m2",
                body_yaw_inertia_kg_m2,
                range::INERTIA_KG_M2,
            ),
            ("wheel_mass_kg", wheel_mass_kg, range::PART_MASS_KG),
            (
                "wheel_spin_inertia_kg_m2",
                wheel_spin_inertia_kg_m2,
                range::INERTIA_KG_M2,
            ),
            (
                "wheel_yaw_inertia_kg_m2",
                wheel_yaw_inertia_kg_m2,
                range::PART_INERTIA_KG_M2,
            ),
            ("com_height_m", com_height_m, range::HEIGHT_M),
            ("com_to_axle_m", com_to_axle_m, range::OFFSET_M),
            ("com_to_caster_m", com_to_caster_m, range::OFFSET_M),
        ] {
            if let Some(value) = value {
                within(&format!("robot.{key}"), value, range)?;
            }
        }
        if let (Some(d), Some(e)) = (com_to_axle_m, com_to_caster_m) {
            check_caster(d, e)?;
        }
        if let Some(motor) = &self.motor {
            motor.validate()?;
        }
        let encoder = self.encoder.as_ref();
        if let Some(counts) = encoder.map(|encoder| encoder.counts_per_rev)
            && !Encoder::COUNTS.contains(&counts)
        {
            let remedy = "give the counts per revolution of the wheel";
            return invalid("encoder.counts_per_rev", format!("is {counts}"), remedy);
        }
        Ok(())
    }
}

impl Motor {
    fn validate(&self) -> Result<(), InputError> {
        let Self {
            nominal_voltage_v,
            no_load_speed_rad_s,
            stall_torque_nm,
        } = *self;
        let speed = range::MOTOR_SPEED_RAD_S;
        within(
            "motor.nominal_voltage_v",
            nominal_voltage_v,
            range::VOLTAGE_V,
        )?;
        within("motor.no_load_speed_rad_s", no_load_speed_rad_s, speed)?;
        within(
            "motor.stall_torque_nm",
            stall_torque_nm,
            range::MOTOR_TORQUE_NM,
        )
    }
}

/// The normal forces of Eq. 4 and 6 are positive only if c lies between the axle and the caster.
fn check_caster(d: f64, e: f64) -> Result<(), InputError> {
    if d < 0.0 {
        return invalid(
            "robot.com_to_axle_m",
            format!("is {d}: the axle lies ahead of the centre of mass"),
            "give a distance of 0 or more, measured backwards from the centre of mass",
        );
    }
    if e < 0.0 || d + e < range::LENGTH_M[0] {
        return invalid(
            "robot.com_to_caster_m",
            format!("is {e}: the caster lies behind the centre of mass or on the axle"),
            "give the distance measured forwards from the centre of mass",
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_robot_is_valid() {
        assert_eq!(RobotModel::paper_with_slip().validate(), Ok(()));
    }

    #[test]
    fn an_invalid_value_names_its_key() {
        type Change = fn(&mut RobotModel);
        let cases: [(&str, Change); 6] = [
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
                m.encoder = Some(Encoder {
                    counts_per_rev: 0.0,
                })
            }),
        ];
        for (key, change) in cases {
            let mut model = RobotModel::default();
            change(&mut model);
            assert_eq!(model.validate().unwrap_err().place, key);
        }
    }
}
