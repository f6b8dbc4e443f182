//! A second simulator of the robots, independent of `slipstream-sim`: no shared step, solver or line of
//! code, so that a fault of one shows against the other.
//!
//! Moreau's time-stepping with fixed steps: smooth forces by the midpoint rule, dry friction implicitly
//! as impulses within their limits, block Gauss-Seidel over the contacts with an exact solution of each
//! contact (Moreau, 1988; Jean, 1999). Steps end early, at an instant found by bisection, where backlash
//! closes, a wheel enters a friction patch or a contact breaks away.

mod actuators;
mod advance;
mod backlash;
mod body;
mod constants;
mod contact;
mod contact_solver;
mod forces;
mod friction_disc;
mod law;
mod outside;
mod physics;
mod plant;
mod state;
mod step;

pub use actuators::{Commands, Quantity};
pub use constants::GRAVITY_M_S2;
pub use law::{Gives, Law, Over};
pub use outside::OutsideEffect;
pub use physics::{Patch, Physics, Push};
pub use plant::Plant;
pub use state::{State, Velocity};
