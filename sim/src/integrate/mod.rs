//! One step: trial step, event location, change of the active set.

mod active_set;
mod event_step;
mod events;
mod fast;
mod friction_jacobian;
mod initial;
mod kinematics;
mod margin;
mod outcome;
mod state;
mod trial_step;

pub use state::State;
