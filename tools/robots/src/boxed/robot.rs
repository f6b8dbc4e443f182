//! The robot in the box, without I/O, clock or threads.

use std::f64::consts::TAU;

use slipstream_bag::ros::wire::{ImuValue, OdometryValue};
use slipstream_bus::message::Actuation;
use slipstream_bus::{Encoder, InputError, RobotModel, Sensors};
use slipstream_sim::{Command, Setup, World};

/// Longest step of the plant (ns).
const STEP_NS: i64 = 1_000_000;

/// A simulated robot that follows twists or torques.
#[derive(Debug)]
pub struct BoxedRobot {
    world: World,
    counts_per_rev: f64,
    r: f64,
    b: f64,
    com_to_axle_m: f64,
    /// What lets it stand.
    rest: Actuation,
    /// What it was told last, and when that came (ns).
    told: (Actuation, i64),
    timeout_ns: i64,
    odometry: [f64; 3],
    angles: [f64; 2],
    velocity: [f64; 2],
    sampled_ns: i64,
}

impl BoxedRobot {
    /// A robot with the effects of its model that stands at `pose` (x (m), y (m), yaw (rad) of c). `rest`: what it follows
    /// when no command has come for `timeout_ns`; `sensors`: measure its pose and how it moves.
    ///
    /// # Errors
    /// The model cannot be simulated.
    pub fn new(
        name: &str,
        model: &RobotModel,
        pose: [f64; 3],
        sensors: Sensors,
        rest: Actuation,
        timeout_ns: i64,
        seed: u64,
    ) -> Result<Self, InputError> {
        let setup = Setup {
            name: name.to_owned(),
            model: model.clone(),
            pose,
            sensors,
        };
        let encoder = model.encoder.as_ref().unwrap_or(&Encoder::MICRORADIANS);
        let mut own = Self {
            world: World::new(&[setup], seed)?,
            counts_per_rev: encoder.counts_per_rev,
            r: model.robot.wheel_radius_m,
            b: model.robot.half_track_m,
            com_to_axle_m: model.robot.com_to_axle_m.unwrap_or(0.0),
            rest,
            told: (rest, i64::MIN),
            timeout_ns,
            odometry: pose,
            angles: [0.0; 2],
            velocity: [0.0; 2],
            sampled_ns: 0,
        };
        own.angles = own.wheel_angles();
        Ok(own)
    }

    /// Takes a command that came at `now_ns`.
    pub fn tell(&mut self, command: Actuation, now_ns: i64) {
        self.told = (command, now_ns);
    }

    /// What it follows at `now_ns`: the newest command, or none after a silence.
    pub fn followed(&self, now_ns: i64) -> Actuation {
        let (command, told_ns) = self.told;
        match now_ns.saturating_sub(told_ns) > self.timeout_ns {
            true => self.rest,
            false => command,
        }
    }

    /// Advances to `now_ns`. Calls `measured` with all that its sensors have measured.
    pub fn advance(&mut self, now_ns: i64, mut measured: impl FnMut(Measured)) {
        while self.world.time_ns() < now_ns {
            let at_ns = self.world.time_ns();
            let command = match self.followed(at_ns) {
                Actuation::Twist([v_m_s, w_rad_s]) => Command::Twist { v_m_s, w_rad_s },
                Actuation::Torque([right_nm, left_nm]) => Command::Torque { right_nm, left_nm },
            };
            let step_ns = STEP_NS.min(now_ns - at_ns);
            self.world.step(step_ns, &[command]);
            if let Some(sample) = self.world.camera(0) {
                measured(Measured::Pose(sample.stamp_ns, sample.value));
            }
            if let Some(sample) = self.world.imu(0) {
                let [ax, ay, yaw_rate_rad_s] = sample.value;
                let value = ImuValue {
                    acceleration_m_s2: [ax, ay],
                    yaw_rate_rad_s,
                };
                measured(Measured::Imu(sample.stamp_ns, value));
            }
        }
    }

    /// Angles of the wheels by their encoders (rad), [right, left].
    pub fn wheel_angles(&self) -> [f64; 2] {
        let counts = self.world.encoder_counts(0);
        counts.map(|count| count as f64 * TAU / self.counts_per_rev)
    }

    /// The robot's own odometry, by its nominal lengths. To be asked at its rate: velocities are means since the last time.
    pub fn odometry(&mut self) -> OdometryValue {
        let angles = self.wheel_angles();
        let turned = [0, 1].map(|side| (angles[side] - self.angles[side]) * self.r);
        let driven = f64::midpoint(turned[0], turned[1]);
        let turn = (turned[0] - turned[1]) / (2.0 * self.b);
        let (sin, cos) = (self.odometry[2] + turn / 2.0).sin_cos();
        self.odometry[0] += driven * cos;
        self.odometry[1] += driven * sin;
        self.odometry[2] += turn;
        let now_ns = self.world.time_ns();
        let dt_s = (now_ns - self.sampled_ns) as f64 * 1e-9;
        if dt_s > 0.0 {
            self.velocity = [driven / dt_s, turn / dt_s];
        }
        (self.angles, self.sampled_ns) = (angles, now_ns);
        OdometryValue {
            pose: self.odometry,
            velocity: self.velocity,
        }
    }

    /// d: distance from c backwards to the axle (m); 0 if unknown.
    pub fn com_to_axle_m(&self) -> f64 {
        self.com_to_axle_m
    }

    /// Time of the robot (ns).
    pub fn time_ns(&self) -> i64 {
        self.world.time_ns()
    }

    /// Its true pose: x (m), y (m), yaw (rad) of c.
    pub fn true_pose(&self) -> [f64; 3] {
        self.world.truth(0).pose
    }

    /// Its true forward speed (m/s) and yaw rate (rad/s).
    pub fn true_velocity(&self) -> [f64; 2] {
        let [forward, _, yaw_rate] = self.world.truth(0).velocity;
        [forward, yaw_rate]
    }
}

/// What a sensor has measured, and when (ns).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured {
    /// x (m), y (m), yaw (rad) of c.
    Pose(i64, [f64; 3]),
    /// By the inertial sensor.
    Imu(i64, ImuValue),
}

#[cfg(test)]
mod tests {
    use slipstream_bus::{Body, Camera};

    use super::*;

    fn boxed(effects: &[(&str, &[(&str, f64)])]) -> BoxedRobot {
        let mut model = RobotModel {
            robot: Body::kinematic(0.033, 0.08),
            motor: None,
            encoder: None,
            effects: Vec::new(),
        };
        for (effect, parameters) in effects {
            model = model.with(effect, parameters);
        }
        let sensors = Sensors {
            camera: Some(Camera::default()),
            imu: None,
        };
        let rest = Actuation::Twist([0.0; 2]);
        BoxedRobot::new("r1", &model, [0.0; 3], sensors, rest, 250_000_000, 1).unwrap()
    }

    #[test]
    fn it_follows_twists_until_they_stop_coming() {
        let mut robot = boxed(&[]);
        robot.tell(Actuation::Twist([0.2, 0.0]), 0);
        let mut poses = 0;
        robot.advance(1_000_000_000, |_| poses += 1);
        // 0.25 s of driving.
        assert!(
            (robot.true_pose()[0] - 0.05).abs() < 1e-3,
            "{:?}",
            robot.true_pose()
        );
        assert!((robot.odometry().pose[0] - 0.05).abs() < 1e-3);
        assert!((29..=31).contains(&poses), "{poses}");
        assert_eq!(robot.followed(1_000_000_000), Actuation::Twist([0.0; 2]));
    }

    #[test]
    fn odometry_does_not_see_a_wheel_that_is_smaller() {
        let mut robot = boxed(&[("wheel_radius", &[("right_scale", 0.9), ("left_scale", 0.9)])]);
        robot.tell(Actuation::Twist([0.2, 0.0]), 0);
        robot.advance(200_000_000, |_| ());
        let (odometry, truth) = (robot.odometry().pose[0], robot.true_pose()[0]);
        assert!((truth / odometry - 0.9).abs() < 1e-3, "{truth} {odometry}");
    }
}
