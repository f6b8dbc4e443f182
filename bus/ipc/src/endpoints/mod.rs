//! Endpoints of plant and agents over shared memory: data by publish-subscribe, synchronisation by
//! the wake-up page.

mod agent;
mod links;
mod parent;
mod plant;
mod waiting;

pub use agent::{AgentEndpoint, LockstepRound};
pub use links::LinkEndpoints;
pub use parent::Parent;
pub use plant::PlantEndpoint;
pub use waiting::Presence;
