//! Event-driven time stepping of the hybrid system: trial step, event location by bisection, change
//! of the active set.

mod active_set;
mod carried;
mod correction;
mod event_step;
mod fast;
mod floor;
mod friction_jacobian;
mod friction_margin;
mod gears;
mod initial;
mod instant;
mod kinematics;
mod mode_check;
mod outcome;
mod prepare;
mod saltation;
mod state;
mod trial_step;
mod velocity_projection;

pub use correction::Correction;
pub use state::State;
