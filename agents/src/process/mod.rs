//! Process of one agent: [`run_agent`] is the whole `main` of a program with a controller of its own.

mod agent_process;
mod arguments;
mod describe;
mod panics;
mod program;

pub use self::agent_process::{AgentOutcome, run};
pub use self::arguments::{Arguments, ROLE, Task};
pub use self::describe::Description;
pub use self::program::{run_agent, run_agent_with};
