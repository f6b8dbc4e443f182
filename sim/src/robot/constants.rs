//! One robot on its floor: the constants of the equations of motion, assembled once before a run.

use slipstream_bus::{InputError, RobotModel};

use super::dry_friction::DryFriction;
use super::effect_list::{ListedEffect, read_effects};
use super::normal_load::NormalLoad;
use super::rolling_motion::{Body, RollingMotion};
use crate::effects::Effects;
use crate::parts::actuator::Actuator;
use crate::parts::command::{Command, CommandKind};
use crate::parts::parameters::{Friction, RobotParameters, Sensing};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::Tolerances;

/// Acceleration of gravity g (m/s²), as in the paper.
pub const GRAVITY_M_S2: f64 = 9.81;

/// The constants of one robot. Immutable; everything that changes is in its [`crate::State`].
///
/// Generic over the scalar: with dual numbers for `S` a step carries derivatives with respect to
/// any parameter of an effect (see [`crate::lift`]).
#[derive(Debug, Clone)]
pub struct Robot<S = f64> {
    /// Mass of body, wheels and payloads (kg).
    pub(crate) mass: S,
    /// First moment of all mass about c, body frame (kg m). The wheels' share is −2 m_w d: the
    /// origin of m13 and m23 in Eq. 3.
    pub(crate) first_moment: Pair<S>,
    /// Yaw inertia of all mass about c (kg m²): I_t = I_rz + 2 I_wz + 2 m_w (b² + d²), and
    /// payloads.
    pub(crate) yaw_inertia: S,
    /// I_wy (kg m²).
    pub(crate) wheel_inertia: S,
    /// What each wheel's contact rolls by per angle that the wheel turns, right and left (m): r, or
    /// (1 - s) r with a slip ratio s.
    pub(crate) radius: Pair<S>,
    /// 1 - s of each wheel (1); 1 without a slip ratio. The equation of each wheel's rotation is
    /// multiplied by it: with the inertia and the torques of the wheel multiplied by 1 - s, the contact
    /// force enters with the lever (1 - s) r, by which the contact rolls, and the equations stay
    /// symmetric.
    pub(crate) travel: Pair<S>,
    /// Whether the model has a slip ratio.
    pub(crate) has_slip_ratio: bool,
    /// b (m).
    pub(crate) half_track: S,
    /// d (m).
    pub(crate) com_to_axle: S,
    /// e (m).
    pub(crate) com_to_caster: S,
    /// [r, b] (m) by which a twist command is converted into wheel speeds.
    pub(crate) nominal: Pair<f64>,
    /// Normal forces.
    pub(crate) load: NormalLoad<S>,
    /// Friction at the driven wheels away from patches; `None`: they never slide.
    pub(crate) wheel_friction: Option<Friction<S>>,
    /// All other dry friction.
    pub(crate) dry_friction: DryFriction<S>,
    /// Viscous damping of each velocity under a torque command: drag at c and droop.
    pub(crate) damping: Vector<S>,
    /// Whether any entry of `damping` is not zero.
    pub(crate) damped: bool,
    /// Component of gravity along the floor, world frame (m/s²); `None` on a level floor.
    pub(crate) slope_gravity: Option<Pair<S>>,
    pub(crate) actuator: Actuator<S>,
    pub(crate) sensing: Sensing<S>,
    pub(crate) effects: Effects<S>,
    pub(crate) tolerances: Tolerances,
    /// The equations of motion where both wheels roll, for robots of draft quality.
    pub(crate) rolling: Option<RollingMotion<S>>,
    /// The first key of the dynamic model that is not given.
    missing: Option<&'static str>,
    /// The effect that needs commands of wheel speeds, if there is one.
    of_speeds: Option<&'static str>,
}

impl Robot<f64> {
    /// The robot that `model` describes, with the effects it lists.
    ///
    /// # Errors
    /// An unphysical value; an effect that is not in the catalogue; a parameter that is missing,
    /// unknown or out of bounds; an effect that needs masses the model does not give.
    pub fn new(model: &RobotModel) -> Result<Self, InputError> {
        Self::assemble(model, &read_effects(model)?)
    }
}

impl<S: Scalar> Robot<S> {
    /// The robot with `model`'s masses and lengths and the effects of `list` in place of those that
    /// the model lists. With dual numbers in `list` (see [`crate::lift`]) every result carries
    /// derivatives with respect to the effects' parameters.
    ///
    /// # Errors
    /// As [`Robot::new`].
    pub fn assemble(model: &RobotModel, list: &[ListedEffect<S>]) -> Result<Self, InputError> {
        let mut parameters = RobotParameters::new(model)?;
        if let (Some(key), Some((info, _))) = (
            parameters.missing,
            list.iter().find(|(info, _)| !info.kinematic),
        ) {
            return Err(InputError::new(
                key,
                format!("is missing, and the effect {} needs it", info.id),
                "give all masses and lengths of [robot], or remove the effect",
            ));
        }
        let effects = Effects::new(list);
        effects.apply(&mut parameters);
        Self::build(parameters, effects)
    }

    /// Wheel radius r and half track b by which twists are converted (m).
    pub fn nominal_lengths(&self) -> Pair<f64> {
        self.nominal
    }

    /// The same robot at draft quality, for simulations by the thousand: events are located less
    /// exactly, and at most two in a step; and where both wheels roll, steps equal those of an accurate
    /// robot up to the order of the method alone.
    #[must_use]
    pub fn draft(self) -> Self {
        Self {
            tolerances: Tolerances::DRAFT,
            rolling: Some(RollingMotion::new(&Body {
                mass: self.mass,
                first_moment: self.first_moment,
                yaw_inertia: self.yaw_inertia,
                wheel_inertia: self.wheel_inertia,
                travel: self.travel,
                radius: self.radius,
                half_track: self.half_track,
                com_to_axle: self.com_to_axle,
            })),
            ..self
        }
    }

    fn build(parameters: RobotParameters<S>, effects: Effects<S>) -> Result<Self, InputError> {
        let (b, d) = (parameters.half_track, parameters.com_to_axle);
        let wheel_mass = parameters.wheel_mass;
        let bodies = parameters.body_mass + wheel_mass * 2.0;
        let mass = bodies + parameters.payload_mass;
        // An effective track moves no mass.
        let arm = d * d + parameters.nominal[1] * parameters.nominal[1];
        let wheels = parameters.wheel_yaw_inertia * 2.0 + wheel_mass * 2.0 * arm;
        let gradient = parameters.gradient;
        let grade_square = gradient[0] * gradient[0] + gradient[1] * gradient[1];
        // cosine of the slope's angle from its tangent
        let cosine = (grade_square + 1.0).sqrt().recip();
        let gravity = cosine * GRAVITY_M_S2;
        let load = NormalLoad::new(&parameters, mass, bodies, gravity)?;
        let travel = travel(&parameters)?;
        let (drag, droop) = (parameters.drag, parameters.actuator.droop);
        let slope_gravity = [gravity * gradient[0], gravity * gradient[1]];
        Ok(Self {
            mass,
            first_moment: [
                parameters.payload_moment[0] - wheel_mass * d * 2.0,
                parameters.payload_moment[1],
            ],
            yaw_inertia: parameters.body_yaw_inertia + wheels + parameters.payload_inertia,
            wheel_inertia: parameters.wheel_spin_inertia,
            radius: [0, 1].map(|i| parameters.radius[i] * travel[i]),
            travel,
            has_slip_ratio: parameters.travel.is_some(),
            half_track: b,
            com_to_axle: d,
            com_to_caster: parameters.com_to_caster,
            nominal: parameters.nominal,
            dry_friction: DryFriction::new(&parameters, load.total, travel),
            load,
            wheel_friction: parameters.wheel_friction,
            damping: Vector::from([drag, drag, S::constant(0.0), droop, droop]),
            damped: drag.value() != 0.0 || droop.value() != 0.0,
            slope_gravity: (grade_square.value() != 0.0).then_some(slope_gravity),
            actuator: parameters.actuator,
            sensing: parameters.sensing,
            effects,
            tolerances: Tolerances::ACCURATE,
            rolling: None,
            missing: parameters.missing,
            of_speeds: parameters.of_speeds,
        })
    }

    /// The prescribed quantity and its value at the right and the left wheel. Voltage prescribes speeds where masses
    /// are unknown.
    pub(crate) fn at_wheels(&self, command: &Command<S>) -> (CommandKind, Pair<S>) {
        let (kind, value) = command.at_wheels(self.nominal);
        match self.actuator.speed_per_volt {
            Some(per_volt) if kind == CommandKind::Voltage => {
                (CommandKind::Speed, value.map(|volts| volts * per_volt))
            }
            _ => (kind, value),
        }
    }

    /// Checks that this robot can be driven by commands of `kind`.
    ///
    /// # Errors
    /// Names the key that such a command needs and the model does not give, or the effect that needs
    /// another command.
    pub fn accepts(&self, kind: CommandKind) -> Result<(), InputError> {
        if kind == CommandKind::Voltage && self.actuator.speed_per_volt.is_some() {
            return Ok(());
        }
        if let (Some(key), true) = (self.of_speeds, kind != CommandKind::Speed) {
            return Err(InputError::new(
                key,
                format!(
                    "needs commanded wheel speeds, and a {} command is given",
                    kind.name()
                ),
                "list a force_law, or command wheel speeds or twists",
            ));
        }
        let needed = match kind {
            CommandKind::Speed => None,
            CommandKind::Voltage if self.actuator.torque_per_volt.is_none() => Some("motor"),
            CommandKind::Torque | CommandKind::Voltage => self.missing,
        };
        needed.map_or(Ok(()), |key| {
            Err(InputError::new(
                key,
                format!("is missing, and a {} command needs it", kind.name()),
                "give the robot's masses, lengths and motor, or command wheel speeds",
            ))
        })
    }
}

/// Least share of what a wheel turns by which its contact moves (1).
const TRAVEL_MIN: f64 = 0.02;

/// 1 - s of each wheel.
fn travel<S: Scalar>(parameters: &RobotParameters<S>) -> Result<Pair<S>, InputError> {
    let travel = parameters.travel.unwrap_or([S::constant(1.0); 2]);
    match travel.iter().find(|travel| travel.value() < TRAVEL_MIN) {
        None => Ok(travel),
        Some(travel) => Err(InputError::new(
            "effects.slip_ratio.asymmetry",
            format!(
                "leaves a wheel with a slip ratio of {}",
                1.0 - travel.value()
            ),
            format!(
                "give numbers that leave both wheels at {} or less",
                1.0 - TRAVEL_MIN
            ),
        )),
    }
}
