//! The parameters of one robot and its floor: those of the model and of its effects.

use slipstream_bus::{EffectSpec, Parameter, RobotModel};

use crate::law::Law;
use crate::outside::OutsideEffect;

/// The parameters of a robot and its floor. Pairs are [right, left].
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    /// m_r (kg).
    pub body_mass: f64,
    /// I_rz (kg m²).
    pub body_inertia: f64,
    /// m_w (kg).
    pub wheel_mass: f64,
    /// I_wy (kg m²).
    pub spin_inertia: f64,
    /// I_wz (kg m²).
    pub wheel_yaw_inertia: f64,
    /// True r (m).
    pub radius: [f64; 2],
    /// Slip ratio of each wheel: its contact moves by 1 - s of what it turns.
    pub slip: [f64; 2],
    /// True b (m).
    pub half_track: f64,
    /// Nominal r and b, which the commands are made with (m).
    pub nominal: [f64; 2],
    /// d (m).
    pub to_axle: f64,
    /// e (m).
    pub to_caster: f64,
    /// h (m).
    pub height: f64,
    /// Point masses (kg), with their positions forward and left of c (m).
    pub payloads: Vec<[f64; 3]>,
    /// Torque per volt (N m/V).
    pub per_volt: f64,
    /// Torque lost per wheel speed under a voltage command (N m s/rad).
    pub back_emf: f64,
    /// μ_s and μ_k; `None`: the wheels never slip.
    pub friction: Option<[f64; 2]>,
    /// Friction patches.
    pub patches: Vec<Patch>,
    /// Rolling resistance, as a share of the weight (1).
    pub rolling: f64,
    /// Viscous drag (N s/m).
    pub drag: f64,
    /// Quadratic drag (N s²/m²).
    pub square_drag: f64,
    /// Coulomb friction of the caster (1).
    pub caster: f64,
    /// Yaw scrub (N m).
    pub scrub: f64,
    /// Axle friction (N m).
    pub axle: f64,
    /// Torque lost per wheel speed under any command (N m s/rad).
    pub droop: f64,
    /// Time constant of the command's lag (s).
    pub lag_s: f64,
    /// Delay of the command (s).
    pub delay_s: f64,
    /// Factor on each wheel's drive.
    pub gain: [f64; 2],
    /// Relative loss of drive strength per time (1/s).
    pub sag_per_s: f64,
    /// Dead band of torque (N m) and of speed (rad/s).
    pub dead_band: [f64; 2],
    /// What is lost of a torque (N m), a voltage (V) and a speed (rad/s), behind the gain.
    pub dead_zone: [f64; 3],
    /// Largest torque (N m) and speed (rad/s).
    pub saturation: [f64; 2],
    /// Backlash between motor and wheel (rad); 0 for none.
    pub gap: f64,
    /// Lever arm of the load transfer by acceleration (m).
    pub transfer_height: f64,
    /// Grade of the floor along world x and y (1).
    pub grade: [f64; 2],
    /// Pushes.
    pub pushes: Vec<Push>,
    /// Forces and motions as tables.
    pub laws: Vec<Law>,
    /// Effects outside the vocabulary.
    pub outside: Vec<OutsideEffect>,
}

/// A disc of the floor with its own friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Centre (m).
    pub centre: [f64; 2],
    /// Radius (m).
    pub radius: f64,
    /// Static and kinetic coefficient (1).
    pub friction: f64,
}

/// A constant force that lasts 60 ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// Start (s).
    pub t_s: f64,
    /// Impulse along world x and y (N s).
    pub impulse: [f64; 2],
}

impl Push {
    /// Duration (s).
    pub const DURATION_S: f64 = 0.06;
}

impl Physics {
    /// The parameters of a model with masses, and of the effects that it lists. Effects of sensors and
    /// links do not affect the motion and are ignored.
    ///
    /// # Errors
    /// Names the missing mass, length or parameter, or the effect that is not known.
    pub fn new(model: &RobotModel) -> Result<Self, String> {
        let robot = &model.robot;
        let known = |value: Option<f64>, name: &str| value.ok_or(format!("{name} is missing"));
        let (stall, volts, free) = model.motor.as_ref().map_or((0.0, 1.0, 1.0), |motor| {
            (
                motor.stall_torque_nm,
                motor.nominal_voltage_v,
                motor.no_load_speed_rad_s,
            )
        });
        let mut physics = Self {
            body_mass: known(robot.body_mass_kg, "body_mass_kg")?,
            body_inertia: known(robot.body_yaw_inertia_kg_m2, "body_yaw_inertia_kg_m2")?,
            wheel_mass: known(robot.wheel_mass_kg, "wheel_mass_kg")?,
            spin_inertia: known(robot.wheel_spin_inertia_kg_m2, "wheel_spin_inertia_kg_m2")?,
            wheel_yaw_inertia: known(robot.wheel_yaw_inertia_kg_m2, "wheel_yaw_inertia_kg_m2")?,
            radius: [robot.wheel_radius_m; 2],
            slip: [0.0; 2],
            half_track: robot.half_track_m,
            nominal: [robot.wheel_radius_m, robot.half_track_m],
            to_axle: known(robot.com_to_axle_m, "com_to_axle_m")?,
            to_caster: known(robot.com_to_caster_m, "com_to_caster_m")?,
            height: known(robot.com_height_m, "com_height_m")?,
            payloads: Vec::new(),
            per_volt: stall / volts,
            back_emf: stall / free,
            friction: None,
            patches: Vec::new(),
            rolling: 0.0,
            drag: 0.0,
            square_drag: 0.0,
            caster: 0.0,
            scrub: 0.0,
            axle: 0.0,
            droop: 0.0,
            lag_s: 0.0,
            delay_s: 0.0,
            gain: [1.0; 2],
            sag_per_s: 0.0,
            dead_band: [0.0; 2],
            dead_zone: [0.0; 3],
            saturation: [f64::INFINITY; 2],
            gap: 0.0,
            transfer_height: 0.0,
            grade: [0.0; 2],
            pushes: Vec::new(),
            laws: Vec::new(),
            outside: Vec::new(),
        };
        for effect in &model.effects {
            physics.add(effect)?;
        }
        Ok(physics)
    }

    /// Adds an effect.
    fn add(&mut self, effect: &EffectSpec) -> Result<(), String> {
        let values = EffectValues(effect);
        if self.add_resistance(&values)? || self.add_drive(&values)? || self.add_body(&values)? {
            return Ok(());
        }
        match effect.effect.as_str() {
            "pose_offset" | "pose_latency" | "wheels_latency" | "imu_latency" | "encoder_scale"
            | "clock_drift" | "link_delay" => Ok(()),
            other => Err(format!("{other} is not an effect")),
        }
    }

    /// Adds an effect of friction or drag; false if it is another one.
    fn add_resistance(&mut self, values: &EffectValues<'_>) -> Result<bool, String> {
        let number = |name: &str| values.number(name);
        match values.id() {
            "wheel_slip" => {
                self.friction = Some([number("friction_static")?, number("friction_kinetic")?])
            }
            "friction_patch" => self.patches.push(Patch {
                centre: [number("x_m")?, number("y_m")?],
                radius: number("radius_m")?,
                friction: number("friction")?,
            }),
            "rolling_resistance" => self.rolling = number("coefficient")?,
            "viscous_drag" => self.drag = number("coefficient")?,
            "quadratic_drag" => self.square_drag = number("coefficient")?,
            "caster_drag" => self.caster = number("friction")?,
            "yaw_scrub" => self.scrub = number("moment_nm")?,
            "axle_friction" => self.axle = number("torque_nm")?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Adds an effect of the drive; false if it is another one.
    fn add_drive(&mut self, values: &EffectValues<'_>) -> Result<bool, String> {
        let number = |name: &str| values.number(name);
        let torque_and_speed = |absent: f64| {
            ["torque_nm", "speed_rad_s"].map(|name| values.optional(name).unwrap_or(absent))
        };
        match values.id() {
            "torque_speed_droop" => self.droop = number("coefficient")?,
            "actuator_lag" => self.lag_s = number("time_constant_s")?,
            "actuator_delay" => self.delay_s = number("delay_s")?,
            "motor_gain" => self.gain = [number("right")?, number("left")?],
            "supply_sag" => self.sag_per_s = number("rate_per_s")?,
            "command_dead_band" => self.dead_band = torque_and_speed(0.0),
            "command_dead_zone" => {
                let sizes = ["torque_nm", "voltage_v", "speed_rad_s"];
                self.dead_zone = sizes.map(|name| values.optional(name).unwrap_or(0.0));
            }
            "command_saturation" => self.saturation = torque_and_speed(f64::INFINITY),
            "backlash" => self.gap = number("gap_rad")?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Adds an effect of geometry, masses or external forces; false if it is another one.
    fn add_body(&mut self, values: &EffectValues<'_>) -> Result<bool, String> {
        let number = |name: &str| values.number(name);
        match values.id() {
            "load_transfer" => self.transfer_height = number("com_height_m")?,
            "wheel_radius" => {
                self.radius[0] *= number("right_scale")?;
                self.radius[1] *= number("left_scale")?;
            }
            "slip_ratio" => {
                let (mean, apart) = (number("ratio")?, values.optional("asymmetry"));
                let half = apart.unwrap_or(0.0) / 2.0;
                self.slip = [mean + half, mean - half];
            }
            "track_width" => self.half_track *= number("scale")?,
            "payload" => self
                .payloads
                .push([number("mass_kg")?, number("x_m")?, number("y_m")?]),
            "floor_slope" => {
                let (sin, cos) = number("downhill_rad")?.sin_cos();
                let grade = number("grade")?;
                self.grade = [grade * cos, grade * sin];
            }
            "push" => {
                let (sin, cos) = number("direction_rad")?.sin_cos();
                let impulse = number("impulse_n_s")?;
                let impulse = [impulse * cos, impulse * sin];
                self.pushes.push(Push {
                    t_s: number("t_s")?,
                    impulse,
                });
            }
            "force_law" | "motion_law" => self.laws.push(values.law()?),
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// By how much each wheel's contact moves per angle of the wheel (m).
    pub(crate) fn rolls(&self) -> [f64; 2] {
        [0, 1].map(|i| (1.0 - self.slip[i]) * self.radius[i])
    }
}

/// The parameters of an effect.
struct EffectValues<'a>(&'a EffectSpec);

impl EffectValues<'_> {
    fn id(&self) -> &str {
        &self.0.effect
    }

    fn optional(&self, name: &str) -> Option<f64> {
        let mut parameters = self.0.parameters.iter();
        parameters.find_map(|(known, value)| match value {
            Parameter::Number(number) if known == name => Some(*number),
            _ => None,
        })
    }

    fn number(&self, name: &str) -> Result<f64, String> {
        self.optional(name)
            .ok_or_else(|| format!("{}.{name} is missing", self.id()))
    }

    fn law(&self) -> Result<Law, String> {
        let find = |name: &str| {
            let mut parameters = self.0.parameters.iter();
            parameters.find_map(|(known, value)| (known == name).then_some(value))
        };
        let (Some(Parameter::Text(gives)), Some(Parameter::Text(over))) =
            (find("acts_on"), find("driver"))
        else {
            return Err(format!("{} does not say what it is over", self.id()));
        };
        let (Some(Parameter::List(knots)), Some(Parameter::List(values))) =
            (find("knots"), find("values"))
        else {
            return Err(format!("{} has no table", self.id()));
        };
        let points = knots.iter().zip(values).map(|(&at, &value)| [at, value]);
        Law::new(gives, over, points.collect())
            .ok_or_else(|| format!("{}: {gives} over {over} is not known", self.id()))
    }
}
