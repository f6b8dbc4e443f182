//! STAND-IN until the plant is merged: rolling robots that slip like points of mass.
#![allow(missing_docs, reason = "goes away with the merge")]
use slipstream_bus::{ModelError, RobotModel};

pub enum Command {
    Torque { right_nm: f64, left_nm: f64 },
}
#[derive(Clone, Copy, Default)]
pub struct Truth {
    pub pose: [f64; 3],
    pub velocity: [f64; 3],
    pub wheel_angle: [f64; 2],
    pub wheel_speed: [f64; 2],
    pub torque_nm: [f64; 2],
    pub normal_n: [f64; 2],
    pub slip_m_s: [f64; 2],
}
pub struct Setup {
    pub name: String,
    pub model: RobotModel,
    pub pose: [f64; 3],
}
pub struct World {
    now: i64,
    robots: Vec<Truth>,
}
impl World {
    pub fn new(robots: &[Setup], _seed: u64) -> Result<Self, ModelError> {
        Ok(Self {
            now: 0,
            robots: robots
                .iter()
                .map(|s| Truth {
                    pose: s.pose,
                    normal_n: [5.0575; 2],
                    ..Truth::default()
                })
                .collect(),
        })
    }
    pub fn time_ns(&self) -> i64 {
        self.now
    }
    pub fn truth(&self, i: usize) -> Truth {
        self.robots[i]
    }
    pub fn encoder_counts(&self, i: usize) -> [i64; 2] {
        self.robots[i]
            .wheel_angle
            .map(|a| (a * 1856.0 / std::f64::consts::TAU).floor() as i64)
    }
    pub fn step(&mut self, dt_ns: i64, commands: &[Command]) {
        self.now += dt_ns;
        let dt = dt_ns as f64 * 1e-9;
        for (robot, Command::Torque { right_nm, left_nm }) in self.robots.iter_mut().zip(commands) {
            let (r, b, m) = (0.0365, 0.105, 1.628);
            let mut force = [0.0; 2];
            for (i, tau) in [*right_nm, *left_nm].into_iter().enumerate() {
                let side = if i == 0 { b } else { -b };
                let slip = robot.wheel_speed[i] * r - robot.velocity[0] - side * robot.velocity[2];
                force[i] =
                    (tau * m * r / (2.0 * 0.001168 + m * r * r) + 40.0 * slip).clamp(-1.21, 1.21);
                robot.wheel_speed[i] += (tau - r * force[i]) / 0.001168 * dt;
                robot.wheel_angle[i] += robot.wheel_speed[i] * dt;
                robot.slip_m_s[i] = slip.abs();
            }
            robot.torque_nm = [*right_nm, *left_nm];
            robot.velocity[0] += (force[0] + force[1]) / m * dt;
            robot.velocity[2] += (force[0] - force[1]) * b / 0.018 * dt;
            robot.pose[0] += robot.velocity[0] * robot.pose[2].cos() * dt;
            robot.pose[1] += robot.velocity[0] * robot.pose[2].sin() * dt;
            robot.pose[2] += robot.velocity[2] * dt;
        }
    }
}
