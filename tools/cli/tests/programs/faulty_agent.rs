//! The program of an agent that goes wrong after 3.2 s, or after the seconds of its second argument, in the way that its
//! first argument names.
#![allow(clippy::panic, reason = "one of the ways")]

use std::process::ExitCode;
use std::time::Duration;

use slipstream_agents::process::run_agent;
use slipstream_agents::{
    Controller, ControllerError, DesiredTwist, InnerInput, OuterInput, WheelTorques,
};

struct Faulty {
    fault: String,
    at_s: f64,
}

impl Controller for Faulty {
    fn outer(&mut self, now: &OuterInput<'_>) -> Result<DesiredTwist, ControllerError> {
        let [v, w] = now.reference_velocity;
        if now.t_s > self.at_s {
            match self.fault.as_str() {
                "error" => return Err("the gain is lost".into()),
                // what no robot can do
                "wild" => {
                    let w = if now.t_s.fract() < 0.5 { 50.0 } else { -50.0 };
                    return Ok(DesiredTwist { v: 9.0, w });
                }
                "nan" => return Ok(DesiredTwist { v: f64::NAN, w }),
                "panic" => panic!("index out of order"),
                "exit" => std::process::exit(3),
                "leave" => std::process::exit(0),
                "hang" => std::thread::sleep(Duration::from_secs(1000)),
                _ => {}
            }
        }
        Ok(DesiredTwist { v, w })
    }

    fn inner(&mut self, now: &InnerInput<'_>) -> Result<WheelTorques, ControllerError> {
        match self.fault.as_str() {
            "torque" if now.t_s > self.at_s => Ok(now.limited([f64::INFINITY, 0.0])),
            "no torque" if now.t_s > self.at_s => Ok(WheelTorques {
                wanted_nm: [0.0; 2],
                torque_nm: [f64::NAN, 0.0],
            }),
            _ => Ok(now.paper()),
        }
    }
}

fn main() -> ExitCode {
    let fault = std::env::args().nth(1).unwrap_or_default();
    let at_s = std::env::args().nth(2).and_then(|own| own.parse().ok());
    let at_s = at_s.unwrap_or(3.2);
    run_agent(|_| match fault.as_str() {
        "refuse" => Err("there is no such law".into()),
        _ => Ok(Faulty { fault, at_s }),
    })
}
