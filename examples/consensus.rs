//! Consensus on a circle: the robots spread evenly around a circle, each from the angles of the robots that it hears
//! (Olfati-Saber, Murray, "Consensus problems in networks of agents with switching topology and time-delays", 2004).
//!
//!     cargo build --release -p slipstream-agents --features process --example consensus
//!     slipstream run platoon --robots 5 --agent target/release/examples/consensus --set links.topology=all \
//!         --set links.protocol=periodic --set duration_s=60

use std::f64::consts::TAU;
use std::process::ExitCode;

use serde::{Deserialize, Serialize};
use slipstream_agents::process::run_agent;
use slipstream_agents::{AgentContext, Controller, ControllerError, DesiredTwist, OuterInput};

/// Keys `controller.NAME.…` of the experiment.
#[derive(Serialize, Deserialize)]
struct Circle {
    radius_m: f64,
    /// Speed along the circle (m/s).
    speed_m_s: f64,
    /// Gain of the consensus (1/s), and of the way to the circle (1/m).
    gain: f64,
    pull: f64,
}

impl Default for Circle {
    fn default() -> Self {
        Self {
            radius_m: 1.5,
            speed_m_s: 0.3,
            gain: 0.1,
            pull: 2.0,
        }
    }
}

struct Consensus {
    circle: Circle,
    robot: u32,
    robots: u32,
}

impl Consensus {
    fn new(context: &AgentContext<'_>) -> Result<Self, ControllerError> {
        let robots = context.settings().robots.count;
        Ok(Self {
            circle: context.parameters()?,
            robot: context.robot(),
            robots,
        })
    }
}

/// An angle in [−π, π).
fn wrapped(angle: f64) -> f64 {
    (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

impl Controller for Consensus {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let circle = &self.circle;
        let [x, y, yaw] = now.pose;
        // Robot i wants to be i / N of a turn from robot 0: the differences to these places come to agree.
        let place = |robot: u32| TAU * f64::from(robot) / f64::from(self.robots);
        let own = y.atan2(x) - place(self.robot);
        let differences = now.heard.iter().map(|heard| {
            let other = heard.position.y_m.atan2(heard.position.x_m) - place(heard.position.from);
            wrapped(other - own)
        });
        let rate = circle.gain * differences.sum::<f64>() / now.heard.len().max(1) as f64;
        let v = (circle.speed_m_s + circle.radius_m * rate).clamp(0.1, 0.6);
        // Along the tangent, turned towards the circle.
        let outside = x.hypot(y) - circle.radius_m;
        let heading = y.atan2(x) + TAU / 4.0 + (circle.pull * outside).atan();
        let w = v / circle.radius_m + 2.0 * wrapped(heading - yaw);
        Ok(DesiredTwist {
            v,
            w: w.clamp(-2.0, 2.0),
        })
    }
}

fn main() -> ExitCode {
    run_agent(Consensus::new)
}
