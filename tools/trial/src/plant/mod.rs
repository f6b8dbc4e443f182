//! A second simulator, for cases that share no step and no solver with the diagnosis.
//!
//! Steps of fixed length in impulses: forces that vary smoothly by the midpoint rule, dry friction
//! implicitly as impulses inside their limits (Moreau, Jean: time-stepping with Gauss and Seidel's
//! iteration over the contacts), each contact solved exactly. Contacts are closed, patches entered
//! and friction broken away from at instants found inside the step.

mod body;
mod cone;
mod contact;
mod drive;
mod gear;
mod motion;
mod physics;
mod state;
mod step;
mod strange;

pub use drive::{Commands, Quantity};
pub use motion::Plant;
pub use physics::{Patch, Physics, Push};
pub use state::{State, Velocity};
pub use strange::Strange;

/// g (m/s²), as the paper has it.
pub const GRAVITY_M_S2: f64 = 9.81;
