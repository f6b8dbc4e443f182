//! Cooperative adaptive cruise control with a time headway (Ploeg, Scheepers, van Nunen, van de Wouw, Nijmeijer,
//! "Design and experimental evaluation of cooperative adaptive cruise control", 2011).
//!
//! A robot keeps the distance spacing + h v to the one ahead. It commands an acceleration u, which it sends with its
//! position, by h u̇ = −u + k_p e + k_d ė + u of the robot ahead.
//!
//!     cargo build --release -p slipstream-agents --features process --example cacc
//!     slipstream study sweep --robots 6 --set agents.*=,target/release/examples/cacc --set links.delay_s=0,0.1

use std::process::ExitCode;

use slipstream_agents::process::run_agent;
use slipstream_agents::{AgentContext, Controller, ControllerError, DesiredTwist, OuterInput};
use slipstream_bus::message::Extra;

struct Cacc {
    /// Time headway (s).
    h: f64,
    /// Gains (1/s², 1/s).
    k: [f64; 2],
    ahead: Option<u32>,
    /// Commanded acceleration (m/s²) and speed (m/s).
    u: f64,
    v: f64,
}

impl Cacc {
    fn new(context: &AgentContext<'_>) -> Result<Self, ControllerError> {
        Ok(Self {
            h: context.number("headway_s", 0.5)?,
            k: [context.number("k_p", 0.7)?, context.number("k_d", 1.5)?],
            ahead: context.robot().checked_sub(1),
            u: 0.0,
            v: 0.0,
        })
    }
}

impl Controller for Cacc {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let [v_r, w_r] = now.reference_velocity;
        let [e_x, e_y, e_theta] = now.error;
        let ahead = self.ahead.and_then(|robot| now.heard_from(robot));
        if let Some(ahead) = ahead.filter(|_| now.coordinates) {
            let sent = ahead.position.extra.numbers();
            let u_ahead = sent.first().copied().unwrap_or(0.0);
            let e = e_x - self.h * now.velocity[0];
            let e_rate = v_r - now.velocity[0] - self.h * self.u;
            let wanted = self.k[0] * e + self.k[1] * e_rate + u_ahead;
            self.u += now.period_s / self.h * (wanted - self.u);
            self.v += now.period_s * self.u;
        } else {
            // The front robot, and all before coordination begins, follow the profile.
            self.u = (v_r - self.v) / now.period_s;
            self.v = v_r;
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
