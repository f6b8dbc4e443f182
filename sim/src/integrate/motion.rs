//! What a state is started, set and stepped by. With `f64` it is compiled here, once for all crates that use it.

use num_dual::DualSVec64;

use super::state::State;
use super::{event_step, initial, state};
use crate::parts::command::Command;
use crate::parts::scalar::{Pair, Scalar};
use crate::robot::Robot;

/// A scalar that robots move with: `f64`, or numbers with `N` first derivatives. Its methods are those of [`Robot`].
pub trait PlantScalar: Scalar {
    #[doc(hidden)]
    fn start(robot: &Robot<Self>, pose: [Self; 3]) -> State<Self>;
    #[doc(hidden)]
    fn step(
        robot: &Robot<Self>,
        state: &mut State<Self>,
        t_s: f64,
        dt_s: f64,
        command: &Command<Self>,
    );
    #[doc(hidden)]
    fn set_motion(
        robot: &Robot<Self>,
        state: &mut State<Self>,
        velocity: [Self; 3],
        wheel_speed: Pair<Self>,
    );
    #[doc(hidden)]
    fn replay_commands(
        robot: &Robot<Self>,
        state: &mut State<Self>,
        past: &[(f64, Command<Self>)],
        t_s: f64,
    );
}

/// Implements [`PlantScalar`] by the generic functions. Those of a type without parameters are compiled in this crate.
macro_rules! plant_scalar {
    ($type:ty $(, const $size:ident)?) => {
        impl$(<const $size: usize>)? PlantScalar for $type {
            fn start(robot: &Robot<Self>, pose: [Self; 3]) -> State<Self> {
                state::start(robot, pose)
            }

            fn step(
                robot: &Robot<Self>,
                state: &mut State<Self>,
                t_s: f64,
                dt_s: f64,
                command: &Command<Self>,
            ) {
                event_step::step(robot, state, t_s, dt_s, command);
            }

            fn set_motion(
                robot: &Robot<Self>,
                state: &mut State<Self>,
                velocity: [Self; 3],
                wheel_speed: Pair<Self>,
            ) {
                initial::set_motion(robot, state, velocity, wheel_speed);
            }

            fn replay_commands(
                robot: &Robot<Self>,
                state: &mut State<Self>,
                past: &[(f64, Command<Self>)],
                t_s: f64,
            ) {
                initial::replay_commands(robot, state, past, t_s);
            }
        }
    };
}

plant_scalar!(f64);
plant_scalar!(DualSVec64<N>, const N);

impl<S: PlantScalar> Robot<S> {
    /// The robot at rest at `pose`: x and y of c (m) and heading φ (rad), world frame.
    pub fn start(&self, pose: [S; 3]) -> State<S> {
        S::start(self, pose)
    }

    /// Advances `state` from time `t_s` by `dt_s` (s) under `command`, held throughout.
    ///
    /// Second order in `dt_s`. Changes between sticking and sliding, and all other events, are
    /// located inside the step. Allocates nothing, unless a delay line holds more than 1024
    /// commands.
    pub fn step(&self, state: &mut State<S>, t_s: f64, dt_s: f64, command: &Command<S>) {
        S::step(self, state, t_s, dt_s, command);
    }

    /// Sets the velocity of `state`: of c along and across the body (m/s), yaw rate (rad/s), and
    /// wheel speeds (rad/s). Contacts with slip slide from then on; slip of wheels that cannot
    /// slide is projected out. With a motion law it is the velocity that the wheels give.
    pub fn set_motion(&self, state: &mut State<S>, velocity: [S; 3], wheel_speed: Pair<S>) {
        S::set_motion(self, state, velocity, wheel_speed);
    }

    /// Sets `state` rolling without slip at forward speed `u` (m/s) and yaw rate `rate` (rad/s).
    pub fn set_rolling(&self, state: &mut State<S>, u: S, rate: S) {
        let turn = self.half_track * rate;
        let wheels = [(u + turn) / self.radius[0], (u - turn) / self.radius[1]];
        self.set_motion(state, [u, self.com_to_axle * rate, rate], wheels);
    }

    /// Sets delay, lag and gears of `state` to what `past` commands have left of them at `t_s` (s).
    /// Each entry is (from when (s), command), oldest first; the first is taken as steady.
    pub fn replay_commands(&self, state: &mut State<S>, past: &[(f64, Command<S>)], t_s: f64) {
        S::replay_commands(self, state, past, t_s);
    }
}
