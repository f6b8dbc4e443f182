//! Consensus on a circle: the robots spread evenly around a circle, each by the places of the robots that it hears
//! (Olfati-Saber, Murray, "Consensus problems in networks of agents with switching topology and time-delays", 2004).
//!
//!     cargo build --release -p slipstream-agents --features process --example consensus
//!     slipstream run platoon --robots 5 --agent target/release/examples/consensus --set links.topology=all \
//!         --set links.protocol=periodic --set duration_s=90

use std::f64::consts::TAU;
use std::process::ExitCode;

use slipstream_agents::process::run_agent;
use slipstream_agents::{AgentContext, Controller, ControllerError, DesiredTwist, OuterInput};

struct Consensus {
    radius_m: f64,
    /// Speed along the circle (m/s).
    speed_m_s: f64,
    /// Gain of the consensus (1/s).
    gain: f64,
    robot: u32,
    robots: u32,
}

impl Consensus {
    fn new(context: &AgentContext<'_>) -> Result<Self, ControllerError> {
        Ok(Self {
            radius_m: context.number("radius_m", 1.5)?,
            speed_m_s: context.number("speed_m_s", 0.3)?,
            gain: context.number("gain", 0.1)?,
            robot: context.robot(),
            robots: context.settings().robots.count,
        })
    }

    /// Where robot i wants to be from robot 0: i / N of a turn (rad).
    fn place(&self, robot: u32) -> f64 {
        TAU * f64::from(robot) / f64::from(self.robots)
    }
}

/// An angle in [−π, π).
fn wrapped(angle: f64) -> f64 {
    (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

impl Controller for Consensus {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let [x, y, yaw] = now.pose;
        // Angles less places come to agree.
        let own = y.atan2(x) - self.place(self.robot);
        let differences = now.heard.iter().map(|heard| {
            let other = &heard.position;
            wrapped(other.y_m.atan2(other.x_m) - self.place(other.from) - own)
        });
        let mean = differences.sum::<f64>() / now.heard.len().max(1) as f64;
        let v = self.speed_m_s + self.radius_m * self.gain * mean;
        let v = v.clamp(0.1, 0.6);
        // Along the tangent, turned towards the circle.
        let outside = x.hypot(y) - self.radius_m;
        let heading = y.atan2(x) + TAU / 4.0 + (2.0 * outside).atan();
        let w = v / self.radius_m + 2.0 * wrapped(heading - yaw);
        Ok(DesiredTwist {
            v,
            w: w.clamp(-2.0, 2.0),
        })
    }
}

fn main() -> ExitCode {
    run_agent(Consensus::new)
}
