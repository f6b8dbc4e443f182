//! The paper's outer loop (Eq. 12) as a program of its own: the same states, bit for bit, as the built-in controller.
//!
//!     cargo build --release -p slipstream-agents --features process --example paper_law
//!     slipstream run platoon --agent target/release/examples/paper_law

use std::process::ExitCode;

use serde::{Deserialize, Serialize};
use slipstream_agents::process::run_agent;
use slipstream_agents::{Controller, ControllerError, DesiredTwist, OuterInput};

/// Keys `controller.NAME.…` of the experiment: the gains of Eq. 12.
#[derive(Serialize, Deserialize)]
struct Gains {
    k_x: f64,
    k_y: f64,
    k_theta: f64,
}

impl Default for Gains {
    fn default() -> Self {
        Self {
            k_x: 1.0,
            k_y: 15.0,
            k_theta: 6.0,
        }
    }
}

impl Controller for Gains {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let [v_r, w_r] = now.reference_velocity;
        let [e_x, e_y, e_theta] = now.error;
        Ok(DesiredTwist {
            v: v_r * e_theta.cos() + self.k_x * e_x,
            w: w_r + v_r * (self.k_y * e_y + self.k_theta * e_theta.sin()),
        })
    }
}

fn main() -> ExitCode {
    run_agent(|context| Ok(context.parameters::<Gains>()?))
}
