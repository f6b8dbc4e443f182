//! Cooperative adaptive cruise control with a time headway (Ploeg, Scheepers, van Nunen, van de Wouw, Nijmeijer,
//! "Design and experimental evaluation of cooperative adaptive cruise control", 2011).
//!
//! A robot keeps the distance spacing + h v to the one ahead. It commands an acceleration u, which it sends with its
//! position, by h u̇ = −u + k_p e + k_d ė + u of the robot ahead.
//!
//!     cargo build --release -p slipstream-agents --features process --example cacc
//!     slipstream run platoon --agent target/release/examples/cacc --set links.protocol=periodic --set links.delay_s=0.1

use std::process::ExitCode;

use serde::{Deserialize, Serialize};
use slipstream_agents::process::run_agent;
use slipstream_agents::{AgentContext, Controller, ControllerError, DesiredTwist, OuterInput};
use slipstream_bus::message::Extra;

/// Keys `controller.NAME.…` of the experiment.
#[derive(Serialize, Deserialize)]
struct Gains {
    /// h: time headway (s).
    headway_s: f64,
    /// k_p (1/s²).
    k_p: f64,
    /// k_d (1/s).
    k_d: f64,
}

impl Default for Gains {
    fn default() -> Self {
        Self {
            headway_s: 0.5,
            k_p: 0.7,
            k_d: 1.5,
        }
    }
}

struct Cacc {
    gains: Gains,
    ahead: Option<u32>,
    /// Commanded acceleration (m/s²) and speed (m/s).
    u: f64,
    v: f64,
}

impl Cacc {
    fn new(context: &AgentContext<'_>) -> Result<Self, ControllerError> {
        let ahead = context.robot().checked_sub(1);
        Ok(Self {
            gains: context.parameters()?,
            ahead,
            u: 0.0,
            v: 0.0,
        })
    }
}

impl Controller for Cacc {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let Gains {
            headway_s: h,
            k_p,
            k_d,
        } = self.gains;
        let [v_r, w_r] = now.reference_velocity;
        let [e_x, e_y, e_theta] = now.error;
        let ahead = self.ahead.and_then(|robot| now.from(robot));
        match ahead.filter(|_| now.coordinates) {
            Some(ahead) => {
                let u_ahead = ahead
                    .position
                    .extra
                    .numbers()
                    .first()
                    .copied()
                    .unwrap_or(0.0);
                let e = e_x - h * now.velocity[0];
                let e_rate = v_r - now.velocity[0] - h * self.u;
                self.u += now.period_s / h * (k_p * e + k_d * e_rate + u_ahead - self.u);
                self.v += now.period_s * self.u;
            }
            None => {
                // The front robot, and all before coordination begins, follow the profile.
                self.u = (v_r - self.v) / now.period_s;
                self.v = v_r;
            }
        }
        let w = w_r + v_r * (15.0 * e_y + 6.0 * e_theta.sin());
        Ok(DesiredTwist { v: self.v, w })
    }

    fn message(&self) -> Extra {
        Extra::new(&[self.u]).unwrap_or_default()
    }
}

fn main() -> ExitCode {
    run_agent(Cacc::new)
}
