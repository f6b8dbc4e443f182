//! One robot on its floor: constants of the equations of motion, assembled once before the run.

use slipstream_bus::{InputError, RobotModel};

use super::listed::{Listed, read_effects};
use crate::effects::Effects;
use crate::parts::actuator::Actuator;
use crate::parts::command::CommandKind;
use crate::parts::friction_elements::{Element, ElementSet};
use crate::parts::parameters::{Friction, RobotParameters, Sensing};
use crate::parts::scalar::{Pair, Scalar, Vector};
use crate::parts::tolerances::Tolerances;

/// g (m/s²), as the paper has it.
pub const GRAVITY_M_S2: f64 = 9.81;

/// The constants of one robot. Immutable; what changes is in [`crate::State`].
#[derive(Debug, Clone)]
pub struct Robot<S = f64> {
    /// Mass of body, wheels and payloads (kg).
    pub(crate) mass: S,
    /// First moment of all mass about c, body frame (kg m). The wheels' share is −2 m_w d: the
    /// origin of m13 and m23 in Eq. 3.
    pub(crate) moment: Pair<S>,
    /// Yaw inertia of all mass about c (kg m²): I_t = I_rz + 2 I_wz + 2 m_w (b² + d²), and payloads.
    pub(crate) inertia: S,
    /// I_wy (kg m²).
    pub(crate) wheel_inertia: S,
    /// r, right and left (m).
    pub(crate) radius: Pair<S>,
    /// b (m).
    pub(crate) half_track: S,
    /// d (m).
    pub(crate) com_to_axle: S,
    /// e (m).
    pub(crate) com_to_caster: S,
    /// r and b as a twist command is turned into wheel speeds.
    pub(crate) nominal: Pair<f64>,
    /// Normal forces.
    pub(crate) load: Load<S>,
    /// Friction at the driven wheels away from patches; `None` never slips.
    pub(crate) grip: Option<Friction<S>>,
    /// Sizes of the dry friction that is not at the driven wheels.
    pub(crate) dry: Dry<S>,
    /// Damping in proportion to each velocity under a torque command: drag at c and droop.
    pub(crate) damping: Vector<S>,
    /// Some damping is not zero.
    pub(crate) damped: bool,
    /// Horizontal part of gravity, world frame (m/s²).
    pub(crate) pull: Option<Pair<S>>,
    pub(crate) drive: Actuator<S>,
    pub(crate) sensing: Sensing<S>,
    pub(crate) effects: Effects<S>,
    pub(crate) tolerances: Tolerances,
    /// The first dynamic key that the model does not give.
    missing: Option<&'static str>,
}

/// Eq. 4 to 6 with payloads, slope and longitudinal load transfer.
#[derive(Debug, Clone)]
pub(crate) struct Load<S> {
    /// N_r + N_l + N_ca (N).
    pub(crate) total: S,
    /// N_r + N_l without longitudinal acceleration (N).
    pub(crate) driven: S,
    /// h / b: N_r − N_l for each newton of lateral force (Eq. 5).
    pub(crate) lateral: S,
    /// N_r − N_l at rest, from payloads beside the axis (N).
    pub(crate) offset: S,
    /// N_r + N_l for each m/s² of longitudinal acceleration (N s²/m); `None` as in Eq. 6.
    pub(crate) transfer: Option<S>,
}

/// Limits of dry friction beside the driven wheels' contacts.
#[derive(Debug, Clone)]
pub(crate) struct Dry<S> {
    /// Those that there are.
    pub(crate) elements: ElementSet,
    /// At each axle (N m).
    pub(crate) axle: Option<S>,
    /// Along the body (N).
    pub(crate) surge: Option<S>,
    /// About the vertical (N m).
    pub(crate) yaw: Option<S>,
    /// At the caster, for each newton of normal force.
    pub(crate) caster: Option<S>,
}

impl<S: Scalar> Dry<S> {
    fn new(parts: &RobotParameters<S>, weight: S) -> Self {
        let there = [
            (parts.axle_torque.is_some(), Element::AxleRight),
            (parts.axle_torque.is_some(), Element::AxleLeft),
            (parts.rolling_coefficient.is_some(), Element::Surge),
            (parts.yaw_moment.is_some(), Element::Yaw),
            (parts.caster_friction.is_some(), Element::Caster),
        ];
        let there = there.iter().filter(|(there, _)| *there);
        Self {
            elements: there.fold(ElementSet::default(), |set, &(_, element)| {
                set.with(element)
            }),
            axle: parts.axle_torque,
            surge: parts.rolling_coefficient.map(|c| c * weight),
            yaw: parts.yaw_moment,
            caster: parts.caster_friction,
        }
    }
}

impl Robot<f64> {
    /// The robot that `model` describes, with the effects that it lists.
    ///
    /// # Errors
    /// A value that no robot can have, an effect that is not in the vocabulary, a parameter that is
    /// missing, unknown or out of bounds, an effect that needs masses that the model lacks.
    pub fn new(model: &RobotModel) -> Result<Self, InputError> {
        Self::assemble(model, &read_effects(model)?)
    }
}

impl<S: Scalar> Robot<S> {
    /// The robot of `model`'s masses and lengths with the effects of `list` in place of the
    /// model's own: the way to derivatives with respect to an effect's parameters.
    ///
    /// # Errors
    /// As [`Robot::new`].
    pub fn assemble(model: &RobotModel, list: &[Listed<S>]) -> Result<Self, InputError> {
        let mut parts = RobotParameters::new(model)?;
        if let (Some(key), Some((info, _))) =
            (parts.missing, list.iter().find(|(info, _)| !info.kinematic))
        {
            return Err(InputError::new(
                key,
                format!("is not given, and the effect {} needs it", info.id),
                "give the masses and lengths of [robot], or leave the effect out",
            ));
        }
        let effects = Effects::new(list);
        effects.apply(&mut parts);
        Self::build(parts, effects)
    }

    /// The same robot, for simulations by the thousand of which most are of no consequence: events
    /// are found less exactly, and few of them in one step.
    #[must_use]
    pub fn draft(self) -> Self {
        Self {
            tolerances: Tolerances::DRAFT,
            ..self
        }
    }

    fn build(parts: RobotParameters<S>, effects: Effects<S>) -> Result<Self, InputError> {
        let (b, d, e) = (parts.half_track, parts.com_to_axle, parts.com_to_caster);
        let bodies = parts.body_mass + parts.wheel_mass * 2.0;
        let mass = bodies + parts.payload_mass;
        let wheels = parts.wheel_yaw_inertia * 2.0 + parts.wheel_mass * 2.0 * (b * b + d * d);
        let grade = parts.gradient[0] * parts.gradient[0] + parts.gradient[1] * parts.gradient[1];
        // sin and cos of the slope's angle from its tangent
        let upright = (grade + 1.0).sqrt().recip();
        let gravity = upright * GRAVITY_M_S2;
        let total = mass * gravity;
        let payload_about_axle = parts.payload_moment[0] + parts.payload_mass * d;
        let caster = (bodies * d + payload_about_axle) * gravity / (d + e);
        if caster.value() > total.value() || caster.value() < 0.0 {
            return Err(InputError::new(
                "effects.payload.x_m",
                "lifts the driven wheels or the caster off the floor",
                "give a place between axle and caster, or a smaller mass",
            ));
        }
        let droop = parts.drive.droop;
        let pull = gravity * parts.gradient[0];
        let zero = S::constant(0.0);
        Ok(Self {
            mass,
            moment: [
                parts.payload_moment[0] - parts.wheel_mass * d * 2.0,
                parts.payload_moment[1],
            ],
            inertia: parts.body_yaw_inertia + wheels + parts.payload_inertia,
            wheel_inertia: parts.wheel_spin_inertia,
            radius: parts.radius,
            half_track: b,
            com_to_axle: d,
            com_to_caster: e,
            nominal: parts.nominal,
            load: Load {
                total,
                driven: total - caster,
                lateral: parts.com_height / b,
                offset: -parts.payload_moment[1] * gravity / b,
                transfer: parts.transfer_height.map(|h| mass * h / (d + e)),
            },
            grip: parts.grip,
            dry: Dry::new(&parts, total),
            damping: Vector::from([parts.drag, parts.drag, zero, droop, droop]),
            damped: parts.drag.value() != 0.0 || droop.value() != 0.0,
            pull: (grade.value() != 0.0).then(|| [pull, gravity * parts.gradient[1]]),
            drive: parts.drive,
            sensing: parts.sensing,
            effects,
            tolerances: Tolerances::ACCURATE,
            missing: parts.missing,
        })
    }

    /// Whether this robot can be driven by commands of `kind`.
    ///
    /// # Errors
    /// The key that such a command needs and the model does not give.
    pub fn accepts(&self, kind: CommandKind) -> Result<(), InputError> {
        let needed = match kind {
            CommandKind::Speed => None,
            CommandKind::Voltage if self.drive.torque_per_volt.is_none() => Some("motor"),
            CommandKind::Torque | CommandKind::Voltage => self.missing,
        };
        needed.map_or(Ok(()), |key| {
            Err(InputError::new(
                key,
                format!("is not given, and a {} command needs it", kind.name()),
                "give the robot's masses, lengths and motor, or command speeds",
            ))
        })
    }
}
