//! Catalogue of effects: physics that a robot model may include or leave out.
//!
//! Each effect is one file here, or one of a few alike in a file, and one name in the list below; plant,
//! `robot.toml`, diagnosis, trials, report and `slipstream effects` get it from the catalogue. Texts of [`Info`] and
//! [`Manoeuvre::words`] appear in answers of the commands byte for byte.
//!
//! Order of the effects on the command: delay, dead band, dead zone, saturation, lag, gain and supply
//! sag. The loss of the dead zone is counted behind the gain (see `command_limits`).

mod effect;
mod info;
mod law;
mod observability;
mod parameter;

use effect::numbers;
pub use effect::{Effect, FromValues, Motion, Values, Wrench};
pub use info::{Channel, Info, ModelSite};
pub use observability::{Manoeuvre, Variable, When};
pub use parameter::{Domain, LIST_MAX, ParameterInfo, Role};

use crate::parts::parameters::{Friction, RobotParameters};
use crate::parts::scalar::{Pair, Scalar};

macro_rules! catalogue {
    ($($module:ident :: {$($name:ident),*}),* $(,)?) => {
        $(mod $module;)*

        /// All effects. Those that act on the command are in the order in which they act.
        pub const CATALOGUE: &[Info] = &[$($(<$module::$name<f64> as Effect<f64>>::INFO),*),*];

        /// The effects of one robot.
        #[derive(Debug, Clone)]
        #[expect(non_snake_case, reason = "the effects of one type have its name")]
        pub(crate) struct Effects<S> {
            $($($name: Vec<$module::$name<S>>,)*)*
            /// Whether any effect adds a force.
            pub(crate) has_force: bool,
            /// Whether any effect adds to the motion that the wheels give the body.
            pub(crate) has_carry: bool,
            /// Whether any effect replaces the friction of a part of the floor.
            pub(crate) has_floor: bool,
        }

        impl<S: Scalar> Effects<S> {
            /// The effects of `list`, with their parameters.
            pub(crate) fn new(list: &[(&'static Info, Values<S>)]) -> Self {
                let mut effects = Self {
                    $($($name: Vec::new(),)*)*
                    has_force: false,
                    has_carry: false,
                    has_floor: false,
                };
                for (info, values) in list {
                    $($(if info.id == <$module::$name<S> as Effect<S>>::INFO.id {
                        let effect = <$module::$name<S> as FromValues<S>>::from_values(values);
                        let origin = [S::constant(0.0); 2];
                        effects.has_force |= effect.has_force();
                        effects.has_carry |= effect.has_carry();
                        effects.has_floor |= effect.floor(origin).is_some();
                        effects.$name.push(effect);
                    })*)*
                }
                effects
            }

            /// Changes the parameters of the robot, effect by effect.
            pub(crate) fn apply(&self, parameters: &mut RobotParameters<S>) {
                $($(for effect in &self.$name { effect.apply(parameters); })*)*
            }

            /// Adds the forces of all effects.
            pub(crate) fn force(&self, motion: &Motion<S>, wrench: &mut Wrench<S>) {
                $($(for effect in &self.$name { effect.force(motion, wrench); })*)*
            }

            /// Adds the speed (m/s) and the turn rate (rad/s) of all effects.
            pub(crate) fn carry(&self, motion: &Motion<S>, added: &mut Pair<S>) {
                $($(for effect in &self.$name { effect.carry(motion, added); })*)*
            }

            /// Calls `visit` for each part of the floor whose friction an effect replaces, with the
            /// depth (m) at which `contact` lies inside it and its friction.
            pub(crate) fn floors(&self, contact: Pair<S>, mut visit: impl FnMut(S, Friction<S>)) {
                $($(for effect in &self.$name {
                    if let Some((depth, friction)) = effect.floor(contact) {
                        visit(depth, friction);
                    }
                })*)*
            }
        }
    };
}

catalogue! {
    wheel_slip::{WheelSlip},
    friction_patch::{FrictionPatch},
    rolling_resistance::{RollingResistance},
    viscous_drag::{ViscousDrag},
    quadratic_drag::{QuadraticDrag},
    caster_drag::{CasterDrag},
    yaw_scrub::{YawScrub},
    actuator_delay::{ActuatorDelay},
    command_limits::{CommandDeadBand, CommandDeadZone, CommandSaturation},
    actuator_lag::{ActuatorLag},
    motor_gain::{MotorGain},
    supply_sag::{SupplySag},
    torque_speed_droop::{TorqueSpeedDroop},
    backlash::{Backlash},
    axle_friction::{AxleFriction},
    load_transfer::{LoadTransfer},
    wheel_radius::{WheelRadius},
    slip_ratio::{SlipRatio},
    track_width::{TrackWidth},
    payload::{Payload},
    floor_slope::{FloorSlope},
    push::{Push},
    force_law::{ForceLaw},
    motion_law::{MotionLaw},
    pose_offset::{PoseOffset},
    latency::{PoseLatency, WheelsLatency, ImuLatency},
    encoder_scale::{EncoderScale},
    clock_drift::{ClockDrift},
    link_delay::{LinkDelay},
}

/// The effect with this id, if there is one.
pub fn find(id: &str) -> Option<&'static Info> {
    CATALOGUE.iter().find(|info| info.id == id)
}
