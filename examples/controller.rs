//! One robot's controller without a plant: its wheels follow the set-points of the outer loop exactly.
//!
//!     cargo run --release -p slipstream-agents --example controller

use std::f64::consts::TAU;

use slipstream_agents::Node;
use slipstream_bus::message::{Encoders, Position};
use slipstream_bus::record::Record;
use slipstream_bus::transport::{BusError, PositionLink};
use slipstream_bus::{Experiment, InputError, RobotModel, Settings};

/// The links of a robot without neighbours.
struct NoLink;

impl PositionLink for NoLink {
    fn poll(&mut self) -> Result<Option<Position>, BusError> {
        Ok(None)
    }

    fn send(&mut self, position: &mut Position) -> Result<i64, BusError> {
        Ok(position.tick_ns)
    }

    fn now_ns(&self) -> i64 {
        0
    }
}

/// Why the example fails.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error(transparent)]
    Input(#[from] InputError),
    #[error(transparent)]
    Bus(#[from] BusError),
}

fn main() -> Result<(), Error> {
    let mut settings = Settings::default();
    settings.robots.count = 1;
    let experiment = Experiment::new(settings, &RobotModel::default());
    let schedule = experiment.settings.schedule();
    let mut node = Node::new(&experiment, 0)?;
    let mut records = Vec::new();
    let (mut now_ns, mut angle_rad, mut speed_rad_s) = (0_i64, [0.0_f64; 2], [0.0_f64; 2]);
    println!("    time   odometry x   reference x   desired speed");
    while now_ns <= 15_000_000_000 {
        let encoders = Encoders {
            sampled_ns: now_ns,
            counts: angle_rad.map(|angle| (angle * 1856.0 / TAU).floor() as i64),
        };
        let due = schedule.due(now_ns);
        node.step(now_ns, due, &encoders, &mut NoLink, &mut records)?;
        for record in records.drain(..) {
            if let Record::Outer(tick) = record {
                speed_rad_s = tick.set_point_rad_s;
                if now_ns % 1_500_000_000 == 0 {
                    println!(
                        "{:6.1} s {:10.3} m {:11.3} m {:11.3} m/s",
                        now_ns as f64 / 1e9,
                        tick.pose[0],
                        tick.reference[0],
                        tick.desired[0]
                    );
                }
            }
        }
        let next_ns = schedule.next_after(now_ns);
        let passed_s = (next_ns - now_ns) as f64 / 1e9;
        for (angle, speed) in angle_rad.iter_mut().zip(speed_rad_s) {
            *angle += speed * passed_s;
        }
        now_ns = next_ns;
    }
    Ok(())
}
