//! The vocabulary of effects: physics that a model may have or leave out.
//!
//! One file each, one line each in the list below. A new effect is a new file and a new line;
//! plant, `robot.toml`, diagnosis, report and the documentation's table then know it.

use crate::parts::{Grip, Parts};
use crate::scalar::{Pair, Scalar};

mod shows;

pub use shows::{Experiment, Variable, When};

/// Where in the flow from command to recording an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Before the motor: on what the actuators are told.
    Command,
    /// Between motor and wheel.
    DriveTrain,
    /// Where wheels or caster touch the floor.
    Contact,
    /// On the body.
    Body,
    /// Between the robot and a recorded stream.
    Sensor,
    /// Between two robots.
    Link,
}

/// Where an effect shows (`where.channel` of a diagnosis).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Along the body.
    Longitudinal,
    /// Across the body.
    Lateral,
    /// About the vertical.
    Yaw,
    /// Rotation of the right wheel.
    WheelRight,
    /// Rotation of the left wheel.
    WheelLeft,
    /// Camera or motion capture.
    SensorPose,
    /// Encoders.
    SensorWheels,
    /// Inertial measurement.
    SensorImu,
    /// Messages between robots.
    Link,
}

impl Channel {
    /// The channel's name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Longitudinal => "longitudinal",
            Self::Lateral => "lateral",
            Self::Yaw => "yaw",
            Self::WheelRight => "wheel_right",
            Self::WheelLeft => "wheel_left",
            Self::SensorPose => "sensor_pose",
            Self::SensorWheels => "sensor_wheels",
            Self::SensorImu => "sensor_imu",
            Self::Link => "link",
        }
    }
}

/// What kind of value a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Domain {
    /// A number in [`lower`, `upper`].
    Number {
        /// Smallest value that is physical.
        lower: f64,
        /// Largest value that is plausible.
        upper: f64,
        /// Values, spread over what robots show, at which a search looks for the effect.
        probes: &'static [f64],
    },
    /// One of these words.
    Text(&'static [&'static str]),
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// The key in `robot.toml`; its end is the unit.
    pub name: &'static str,
    /// The unit, "1" for a plain number.
    pub unit: &'static str,
    /// What it may be.
    pub domain: Domain,
    /// Exactly one of an effect's alternatives is given.
    pub alternative: bool,
}

impl ParameterInfo {
    const fn number(
        name: &'static str,
        unit: &'static str,
        lower: f64,
        upper: f64,
        probes: &'static [f64],
    ) -> Self {
        let domain = Domain::Number {
            lower,
            upper,
            probes,
        };
        Self {
            name,
            unit,
            domain,
            alternative: false,
        }
    }

    const fn text(name: &'static str, words: &'static [&'static str]) -> Self {
        Self {
            name,
            unit: "text",
            domain: Domain::Text(words),
            alternative: false,
        }
    }

    const fn or(self) -> Self {
        Self {
            alternative: true,
            ..self
        }
    }
}

/// What an effect is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Info {
    /// Identity in the vocabulary.
    pub id: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
    /// Its equation, in the paper's symbols.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// Where it acts.
    pub place: Place,
    /// Where it shows.
    pub channels: &'static [Channel],
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// It may occur more than once.
    pub repeats: bool,
    /// A model without masses can express it.
    pub kinematic: bool,
    /// When it acts.
    pub acts: When,
    /// The same for a person, without its numbers.
    pub condition: &'static str,
    /// Where its force or moment tells most of it, and over what.
    pub follows: &'static [(Channel, Variable)],
    /// What shows it best.
    pub experiment: Experiment,
}

impl Info {
    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&'static ParameterInfo> {
        self.parameters.iter().find(|known| known.name == name)
    }
}

/// The values of one effect's parameters, judged against [`Info::parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct Values<S> {
    numbers: Vec<(&'static str, S)>,
    text: &'static str,
}

impl<S: Scalar> Values<S> {
    pub(crate) fn new(numbers: Vec<(&'static str, S)>, text: &'static str) -> Self {
        Self { numbers, text }
    }

    /// The same with other numbers: constants become numbers with derivatives.
    pub(crate) fn map<T: Scalar>(&self, mut number: impl FnMut(&'static str, S) -> T) -> Values<T> {
        let numbers = self
            .numbers
            .iter()
            .map(|&(name, value)| (name, number(name, value)));
        Values {
            numbers: numbers.collect(),
            text: self.text,
        }
    }

    /// The value of a parameter, if it is there and a number.
    pub fn get(&self, name: &str) -> Option<S> {
        self.numbers
            .iter()
            .find(|(known, _)| *known == name)
            .map(|&(_, value)| value)
    }

    /// The value of a parameter that every instance has: [`crate::robot`] refuses one without.
    fn number(&self, name: &str) -> S {
        self.get(name).unwrap_or_else(|| S::constant(f64::NAN))
    }
}

/// The robot as the forces on its body see it.
#[derive(Debug, Clone, Copy)]
pub struct Motion<S> {
    /// Time since the recording's start (s).
    pub t_s: f64,
    /// Length of the time that the force is averaged over, from `t_s` on (s).
    pub over_s: f64,
    /// Cosine and sine of the heading φ.
    pub heading: Pair<S>,
    /// Velocity of c along and across the body (m/s).
    pub velocity: Pair<S>,
}

/// Forces along and across the body (N) and moment about the vertical (N m), all at c.
#[derive(Debug, Clone, Copy)]
pub struct Wrench<S> {
    /// Force along the body (N).
    pub along: S,
    /// Force across the body, to the left (N).
    pub across: S,
    /// Moment, counter-clockwise (N m).
    pub moment: S,
}

/// One effect with its parameters. What a method does not override, the effect does not do.
pub trait Effect<S: Scalar>: Sized {
    /// What it is.
    const INFO: Info;

    /// The effect with these parameters.
    fn new(values: &Values<S>) -> Self;

    /// Writes the effect into the numbers of the robot. Done once, before the run.
    fn shape(&self, _parts: &mut Parts<S>) {}

    /// Adds a force on the body that depends on time, place or speed. Done in every step.
    fn force(&self, _motion: &Motion<S>, _wrench: &mut Wrench<S>) {}

    /// Whether [`Effect::force`] adds anything, ever.
    fn has_force(&self) -> bool {
        false
    }

    /// How far `contact` (m, world frame) lies inside a place whose friction this effect replaces
    /// (negative: outside), and that friction.
    fn floor(&self, _contact: Pair<S>) -> Option<(S, Grip<S>)> {
        None
    }
}

macro_rules! catalogue {
    ($($module:ident :: $name:ident),* $(,)?) => {
        $(mod $module;)*

        /// All effects, in the order in which the command's part of them acts.
        pub const CATALOGUE: &[Info] = &[$(<$module::$name<f64> as Effect<f64>>::INFO),*];

        /// The effects of one robot.
        #[derive(Debug, Clone)]
        pub(crate) struct Effects<S> {
            $($module: Vec<$module::$name<S>>,)*
            /// Some effect adds a force in every step.
            pub(crate) has_force: bool,
            /// Some effect replaces the friction of a place.
            pub(crate) has_floor: bool,
        }

        impl<S: Scalar> Effects<S> {
            /// The effects named in `list`, all of them in the catalogue.
            pub(crate) fn new(list: &[(&'static Info, Values<S>)]) -> Self {
                let mut effects = Self {
                    $($module: Vec::new(),)*
                    has_force: false,
                    has_floor: false,
                };
                for (info, values) in list {
                    $(if info.id == <$module::$name<S> as Effect<S>>::INFO.id {
                        let effect = $module::$name::new(values);
                        let origin = [S::constant(0.0); 2];
                        effects.has_force |= effect.has_force();
                        effects.has_floor |= effect.floor(origin).is_some();
                        effects.$module.push(effect);
                    })*
                }
                effects
            }

            pub(crate) fn shape(&self, parts: &mut Parts<S>) {
                $(for effect in &self.$module { effect.shape(parts); })*
            }

            pub(crate) fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
                $(for effect in &self.$module { effect.force(motion, wrench); })*
            }

            /// Calls `visit` for each place whose friction some effect replaces.
            pub(crate) fn floors(&self, contact: Pair<S>, mut visit: impl FnMut(S, Grip<S>)) {
                $(for effect in &self.$module {
                    if let Some((inside, grip)) = effect.floor(contact) {
                        visit(inside, grip);
                    }
                })*
            }
        }
    };
}

catalogue! {
    wheel_slip::WheelSlip,
    friction_patch::FrictionPatch,
    rolling_resistance::RollingResistance,
    viscous_drag::ViscousDrag,
    quadratic_drag::QuadraticDrag,
    caster_drag::CasterDrag,
    yaw_scrub::YawScrub,
    actuator_delay::ActuatorDelay,
    command_dead_band::CommandDeadBand,
    command_saturation::CommandSaturation,
    actuator_lag::ActuatorLag,
    motor_gain::MotorGain,
    supply_sag::SupplySag,
    torque_speed_droop::TorqueSpeedDroop,
    backlash::Backlash,
    axle_friction::AxleFriction,
    load_transfer::LoadTransfer,
    wheel_radius::WheelRadius,
    track_width::TrackWidth,
    payload::Payload,
    floor_slope::FloorSlope,
    push::Push,
    pose_offset::PoseOffset,
    pose_latency::PoseLatency,
    wheels_latency::WheelsLatency,
    imu_latency::ImuLatency,
    encoder_scale::EncoderScale,
    clock_drift::ClockDrift,
    link_delay::LinkDelay,
}

/// The effect of this name.
pub fn find(id: &str) -> Option<&'static Info> {
    CATALOGUE.iter().find(|info| info.id == id)
}
