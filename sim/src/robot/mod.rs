//! One robot: the constants of its equations of motion, its contact Jacobian, the types of its
//! continuous state and of its mode.

pub(crate) mod body;
mod breakaway;
mod constants;
mod dry_friction;
mod effect_list;
mod jacobian;
pub(crate) mod mode;
mod normal_load;
pub(crate) mod rolling_motion;

pub use breakaway::breakaway_nm;
pub use constants::{GRAVITY_M_S2, Robot};
pub use effect_list::{ListedEffect, lift, lift_entries, read_effects};
