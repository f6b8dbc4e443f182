//! Endpoints of plant and agents over shared memory: data by publish-subscribe, synchronisation by
//! the wake-up page.

mod agent;
mod crossing;
mod links;
mod plant;

pub use agent::{AgentEndpoint, Awaited, LockstepRound};
pub use crossing::CrossingLinks;
pub use links::LinkEndpoints;
pub use plant::PlantEndpoint;
