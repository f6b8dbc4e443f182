//! One robot on its floor: constants of the equations of motion, assembled once before the run.

use slipstream_bus::{EffectSpec, InputError, Parameter, RobotModel};

use crate::command::CommandKind;
use crate::effects::{self, Domain, Effects, Info, ParameterInfo, Values};
use crate::parts::{Drive, Grip, Parts, Sensing};
use crate::rows::{Element, Elements};
use crate::scalar::{Pair, Scalar, Vector};
use crate::step::Care;

/// g (m/s²), as the paper has it.
pub const GRAVITY_M_S2: f64 = 9.81;

/// An effect and the values of its parameters.
pub type Listed<S> = (&'static Info, Values<S>);

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
    pub(crate) grip: Option<Grip<S>>,
    /// Sizes of the dry friction that is not at the driven wheels.
    pub(crate) dry: Dry<S>,
    /// Damping in proportion to each velocity under a torque command: drag at c and droop.
    pub(crate) damping: Vector<S>,
    /// Some damping is not zero.
    pub(crate) damped: bool,
    /// Horizontal part of gravity, world frame (m/s²).
    pub(crate) pull: Option<Pair<S>>,
    pub(crate) drive: Drive<S>,
    pub(crate) sensing: Sensing<S>,
    pub(crate) effects: Effects<S>,
    pub(crate) care: Care,
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
    pub(crate) elements: Elements,
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
    fn new(parts: &Parts<S>, weight: S) -> Self {
        let there = [
            (parts.axle_torque.is_some(), Element::AxleRight),
            (parts.axle_torque.is_some(), Element::AxleLeft),
            (parts.rolling_coefficient.is_some(), Element::Surge),
            (parts.yaw_moment.is_some(), Element::Yaw),
            (parts.caster_friction.is_some(), Element::Caster),
        ];
        let there = there.iter().filter(|(there, _)| *there);
        Self {
            elements: there.fold(Elements::default(), |set, &(_, element)| set.with(element)),
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
        let mut parts = Parts::new(model)?;
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
        effects.shape(&mut parts);
        Self::build(parts, effects)
    }

    /// The same robot, for simulations by the thousand of which most are of no consequence: events
    /// are found less exactly, and few of them in one step.
    #[must_use]
    pub fn coarse(self) -> Self {
        Self {
            care: Care::COARSE,
            ..self
        }
    }

    fn build(parts: Parts<S>, effects: Effects<S>) -> Result<Self, InputError> {
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
            care: Care::FINE,
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

/// The effects that `model` lists, judged against the vocabulary.
///
/// # Errors
/// An effect or parameter that is unknown, missing, twice there or out of bounds.
pub fn read_effects(model: &RobotModel) -> Result<Vec<Listed<f64>>, InputError> {
    let mut list: Vec<Listed<f64>> = Vec::new();
    for spec in &model.effects {
        let key = format!("effects.{}", spec.effect);
        let info = effects::find(&spec.effect).ok_or_else(|| {
            InputError::new(
                &key,
                "is no effect",
                "`slipstream effects` lists those that are",
            )
        })?;
        if !info.repeats && list.iter().any(|(known, _)| known.id == info.id) {
            return Err(InputError::new(key, "is listed twice", "list it once"));
        }
        list.push((info, read_values(info, spec, &key)?));
    }
    Ok(list)
}

/// The same effects with other numbers: `number` is given the effect's place in the list, the
/// parameter's name and its value. For [`Robot::assemble`] with numbers that carry derivatives.
pub fn lift<S: Scalar>(
    list: &[Listed<f64>],
    mut number: impl FnMut(usize, &'static str, f64) -> S,
) -> Vec<Listed<S>> {
    let lifted = list.iter().enumerate();
    lifted
        .map(|(i, (info, values))| (*info, values.map(|name, value| number(i, name, value))))
        .collect()
}

fn read_values(info: &Info, spec: &EffectSpec, key: &str) -> Result<Values<f64>, InputError> {
    let mut numbers = Vec::new();
    let mut text = "";
    for (name, value) in &spec.parameters {
        let at = format!("{key}.{name}");
        let known = info.parameter(name);
        let known = known.ok_or_else(|| {
            let names: Vec<&str> = info.parameters.iter().map(|p| p.name).collect();
            let remedy = format!("its parameters are {}", names.join(", "));
            InputError::new(&at, "is no parameter of this effect", remedy)
        })?;
        match (known.domain, value) {
            (Domain::Number { lower, upper, .. }, &Parameter::Number(number)) => {
                if !(lower..=upper).contains(&number) {
                    let remedy = format!("give a number from {lower} to {upper} {}", known.unit);
                    return Err(InputError::new(at, format!("is {number}"), remedy));
                }
                numbers.push((known.name, number));
            }
            (Domain::Text(words), Parameter::Text(word)) => {
                let found = words.iter().find(|known| *known == word);
                text = found.ok_or_else(|| one_of(&at, word, words))?;
            }
            (Domain::Number { .. }, Parameter::Text(word)) => {
                return Err(InputError::new(
                    at,
                    format!("is \"{word}\""),
                    "give a number",
                ));
            }
            (Domain::Text(words), Parameter::Number(number)) => {
                return Err(one_of(&at, &number.to_string(), words));
            }
        }
    }
    complete(info, spec, key)?;
    Ok(Values::new(numbers, text))
}

fn one_of(at: &str, given: &str, words: &[&str]) -> InputError {
    InputError::new(
        at,
        format!("is \"{given}\""),
        format!("give one of {}", words.join(", ")),
    )
}

/// Every parameter is given once; of alternatives exactly one.
fn complete(info: &Info, spec: &EffectSpec, key: &str) -> Result<(), InputError> {
    let given = |p: &ParameterInfo| spec.parameters.iter().filter(|(n, _)| n == p.name).count();
    for parameter in info.parameters {
        let count = given(parameter);
        if count > 1 || (count == 0 && !parameter.alternative) {
            return Err(InputError::new(
                format!("{key}.{}", parameter.name),
                if count > 1 {
                    "is given twice"
                } else {
                    "is not given"
                },
                format!("give it once, in {}", parameter.unit),
            ));
        }
    }
    let mut alternatives = info.parameters.iter().filter(|p| p.alternative).peekable();
    if alternatives.peek().is_some() && alternatives.clone().map(given).sum::<usize>() != 1 {
        let names: Vec<&str> = alternatives.map(|p| p.name).collect();
        let remedy = format!("give exactly one of {}", names.join(", "));
        return Err(InputError::new(key, "has not one parameter", remedy));
    }
    Ok(())
}
