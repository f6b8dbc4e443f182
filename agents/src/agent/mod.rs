//! Controller of one robot: cascade of outer loop (Kanayama) and inner loop (PI or computed
//! torque).
//!
//! It has no I/O, clock or threads: the same inputs give the same outputs, bit for bit.

mod reference;
mod slip_limit;
mod watchdog;

use slipstream_bus::experiment::{Clock, Experiment, Law, Settings, TorqueLimit};
use slipstream_bus::message::{Encoders, Position, RobotIndex};
use slipstream_bus::record::{InnerTick, OuterTick};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::{InputError, RobotSetup};

use self::reference::ReferenceGenerator;
use self::slip_limit::{SlipLimit, eq11_nm};
use self::watchdog::Watchdog;
use crate::computed_torque::{AccelerationCommand, computed_torque, limit_turn};
use crate::geometry::Geometry;
use crate::kanayama::{DesiredTwist, desired_twist};
use crate::odometry::{Odometry, wheel_rotation};
use crate::pose::Pose;
use crate::speed_loop::SpeedLoops;
use crate::traction::rolling_acceleration;
use crate::wheel_torques::WheelTorques;

/// The controller of one robot.
///
/// [`Self::outer`] and [`Self::inner`] run one tick of a loop. The caller decides when they are due
/// ([`Settings::schedule`]) and delivers the predecessor's positions ([`Self::receive`]).
#[derive(Debug, Clone)]
pub struct Agent {
    robot: RobotIndex,
    settings: Settings,
    geometry: Geometry,
    odometry: Odometry,
    reference: ReferenceGenerator,
    watchdog: Watchdog,
    loops: SpeedLoops,
    slip_limit: SlipLimit,
    plant_lost: bool,
    /// The last outer tick.
    outer: OuterTick,
    /// Change of v_r and w_r between the last two outer ticks (m/s², rad/s²).
    reference_rate: [f64; 2],
    /// Encoders at the last inner tick.
    inner_encoders: Option<Encoders>,
    wheel_speed: [f64; 2],
    /// Torques commanded at the last inner tick and at the one before (N m).
    torques_nm: [[f64; 2]; 2],
    max_desired_m_s: f64,
}

impl Agent {
    /// The controller of robot `index` of an experiment.
    ///
    /// # Errors
    /// The experiment has no such robot, or its model lacks what the control law needs.
    pub fn new(experiment: &Experiment, index: RobotIndex) -> Result<Self, InputError> {
        let settings = experiment.settings.clone();
        let setup = find(experiment, index)?;
        let geometry = Geometry::new(&setup.model)?;
        check_dynamics(setup, &settings, &geometry)?;
        let start = Pose::new(setup.pose);
        let predecessor = match index.checked_sub(1) {
            Some(predecessor) => Some(Pose::new(find(experiment, predecessor)?.pose)),
            None => None,
        };
        Ok(Self {
            robot: index,
            odometry: Odometry::new(start, &geometry),
            reference: ReferenceGenerator::new(start, predecessor, geometry.d),
            watchdog: Watchdog::new(experiment),
            loops: SpeedLoops::default(),
            slip_limit: SlipLimit::new(&settings.control, &geometry),
            plant_lost: false,
            outer: OuterTick::default(),
            reference_rate: [0.0; 2],
            inner_encoders: None,
            wheel_speed: [0.0; 2],
            torques_nm: [[0.0; 2]; 2],
            max_desired_m_s: 0.0,
            geometry,
            settings,
        })
    }

    /// Receives a position of the predecessor, newer than all before, at the outer tick `now_ns`.
    pub fn receive(&mut self, position: &Position, now_ns: i64) {
        self.reference.receive(position);
        self.watchdog.reset(now_ns);
    }

    /// One tick of the outer loop: odometry, reference, Eq. 12, set-points of the wheel speeds.
    pub fn outer(&mut self, now_ns: i64, encoders: &Encoders) -> OuterTick {
        self.odometry.update(encoders.counts, &self.geometry);
        let axle = self.odometry.axle();
        let reference = self.reference.at(now_ns, &self.settings);
        let control = &self.settings.control;
        let reference_axle = reference.pose.ahead(-self.geometry.d);
        let mut desired = desired_twist(axle, reference_axle, reference.velocity, control);
        let (follows, last_v) = (self.reference.follows(), self.outer.desired[0]);
        self.watchdog
            .check(now_ns, follows, last_v, control, &mut desired);
        self.max_desired_m_s = self.max_desired_m_s.max(desired.v.abs());
        let before = self.outer.reference_velocity;
        let period_s = control.outer_period_s;
        self.reference_rate = [0, 1].map(|i| (reference.velocity[i] - before[i]) / period_s);
        self.outer = OuterTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            pose: self.pose(),
            velocity: self.geometry.twist(self.wheel_speed),
            reference: reference.pose.to_array(),
            reference_velocity: reference.velocity,
            error: desired.error,
            desired: [desired.v, desired.w],
            set_point_rad_s: self.set_points(&desired),
            message: reference.message,
        };
        self.outer
    }

    /// One tick of the inner loop: wheel speeds, torque limits, torques.
    pub fn inner(&mut self, now_ns: i64, encoders: &Encoders) -> InnerTick {
        self.odometry.update(encoders.counts, &self.geometry);
        self.measure_speed(encoders);
        let control = &self.settings.control;
        let limit_nm = self
            .slip_limit
            .inner_nm(self.wheel_speed, control, &self.geometry);
        self.plant_lost = self.settings.clock == Clock::Wall
            && now_ns - encoders.sampled_ns > ns_from_s(control.plant_timeout_s);
        let torques = self.torques(now_ns, limit_nm);
        self.slip_limit.store_torques(&torques);
        self.torques_nm = [torques.torque_nm, self.torques_nm[0]];
        InnerTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            outer_ns: self.outer.t_ns,
            wheel_speed_rad_s: self.wheel_speed,
            wanted_nm: torques.wanted_nm,
            limit_nm,
            torque_nm: torques.torque_nm,
            friction: self.slip_limit.friction(&self.settings.control),
        }
    }

    /// Updates the odometry without a tick of a loop.
    pub fn update_odometry(&mut self, encoders: &Encoders) {
        self.odometry.update(encoders.counts, &self.geometry);
    }

    /// The position message for the successor, as of the last outer tick. The sender adds `seq`,
    /// `token_round` and `sent_ns`.
    pub fn position(&self) -> Position {
        let [x_m, y_m, yaw_rad] = self.outer.pose;
        let [v_m_s, w_rad_s] = self.outer.reference_velocity;
        Position {
            from: self.robot,
            sampled_ns: self.outer.sampled_ns,
            tick_ns: self.outer.t_ns,
            x_m,
            y_m,
            yaw_rad,
            v_m_s,
            w_rad_s,
            ..Position::default()
        }
    }

    /// Continues the odometry of an agent that died: pose of c, x (m), y (m), φ (rad), and the
    /// encoder counts behind it.
    pub fn resume(&mut self, pose: [f64; 3], counts: [i64; 2]) {
        self.odometry = Odometry::resumed(Pose::new(pose), counts, &self.geometry);
    }

    /// The encoder counts behind the odometry's pose.
    pub fn counts(&self) -> [i64; 2] {
        self.odometry.counts()
    }

    /// The estimated pose of c by odometry: x (m), y (m), φ (rad).
    pub fn pose(&self) -> [f64; 3] {
        self.odometry.centre_of_mass(&self.geometry).to_array()
    }

    /// The largest desired speed so far, before limiting (m/s).
    pub fn max_desired_speed_m_s(&self) -> f64 {
        self.max_desired_m_s
    }

    /// Whether the watchdog has fired, so that the follower brakes.
    pub fn watchdog_fired(&self) -> bool {
        self.watchdog.fired()
    }

    /// Whether the encoder readings are too old, so that there is no torque.
    pub fn plant_lost(&self) -> bool {
        self.plant_lost
    }

    /// Mean wheel speeds since the last inner tick, by the time stamps of the encoders.
    fn measure_speed(&mut self, encoders: &Encoders) {
        let before = self.inner_encoders.replace(*encoders).unwrap_or(*encoders);
        let elapsed_ns = encoders.sampled_ns - before.sampled_ns;
        if elapsed_ns > 0 {
            self.wheel_speed = wheel_rotation(before.counts, encoders.counts, &self.geometry)
                .map(|angle| angle / s_from_ns(elapsed_ns));
        }
    }

    /// The set-points of the wheel speeds (rad/s), limited if the torque limit is in the outer
    /// loop.
    fn set_points(&self, desired: &DesiredTwist) -> [f64; 2] {
        let set_point = self.geometry.wheel_speeds(desired.v, desired.w);
        let control = &self.settings.control;
        if control.torque_limit != TorqueLimit::Outer {
            return set_point;
        }
        // The limit must hold even if a measured speed is wrong by one encoder count per tick.
        let margin_nm = control.k_p * self.geometry.count_rad / control.inner_period_s;
        let limit_nm = eq11_nm(control.friction, self.wheel_speed, control, &self.geometry)
            .map(|n| (n - margin_nm).max(0.0));
        let drift = self.drift_rad_s();
        self.loops
            .within_torque_limit(self.wheel_speed, drift, set_point, limit_nm, control)
    }

    /// Predicted change of the measured wheel speeds until the next inner tick (rad/s), from the
    /// torques of the last two ticks, because a measured speed is the mean over its tick.
    fn drift_rad_s(&self) -> [f64; 2] {
        let Some(dynamics) = &self.geometry.dynamics else {
            return [0.0; 2];
        };
        let [last, before] = self.torques_nm;
        let mean = [0, 1].map(|i| (last[i] + before[i]) / 2.0);
        rolling_acceleration(mean, dynamics, &self.geometry)
            .map(|alpha| alpha * self.settings.control.inner_period_s)
    }

    /// The torques of the control law, or of the open loop; none if the plant is lost.
    fn torques(&mut self, now_ns: i64, limit_nm: [f64; 2]) -> WheelTorques {
        let control = &self.settings.control;
        if self.plant_lost {
            self.loops.reset();
            return WheelTorques::ZERO;
        }
        if self.settings.open_loop.enabled {
            return self.open_loop(now_ns, limit_nm);
        }
        if let (Law::ComputedTorque, Some(dynamics)) = (control.law, &self.geometry.dynamics) {
            return computed_torque(&self.acceleration_command(), dynamics, &self.geometry);
        }
        let set_point = self.outer.set_point_rad_s;
        self.loops
            .step(self.wheel_speed, set_point, limit_nm, control)
    }

    fn open_loop(&self, now_ns: i64, limit_nm: [f64; 2]) -> WheelTorques {
        let open_loop = &self.settings.open_loop;
        let active = now_ns < ns_from_s(open_loop.torque_for_s);
        let wanted_nm = if active { open_loop.torque_nm } else { 0.0 };
        WheelTorques {
            wanted_nm: [wanted_nm; 2],
            torque_nm: limit_nm.map(|limit| wanted_nm.clamp(-limit, limit)),
        }
    }

    /// The input of the computed-torque law: acceleration of the reference (feed-forward) and k_v
    /// times the velocity error (feedback).
    fn acceleration_command(&self) -> AccelerationCommand {
        let control = &self.settings.control;
        let twist = self.geometry.twist(self.wheel_speed);
        let friction = Some(self.slip_limit.friction(control)[0])
            .filter(|_| control.torque_limit != TorqueLimit::None);
        let mut desired = self.outer.desired;
        if let (Some(friction), Some(dynamics)) = (friction, &self.geometry.dynamics) {
            desired = limit_turn(desired, friction, dynamics, &self.geometry);
        }
        let rate = if self.watchdog.fired() {
            [0.0; 2]
        } else {
            self.reference_rate
        };
        AccelerationCommand {
            acceleration: [0, 1].map(|i| rate[i] + control.k_v * (desired[i] - twist[i])),
            twist,
            friction,
            torque_max_nm: control.torque_max_nm,
        }
    }
}

fn find(experiment: &Experiment, index: RobotIndex) -> Result<&RobotSetup, InputError> {
    experiment.robots.get(index as usize).ok_or_else(|| {
        let problem = format!("has no robot {}", index + 1);
        InputError::new("robots.count", problem, "increase the number of robots")
    })
}

/// Torque limits and the computed-torque law need masses and inertias.
fn check_dynamics(
    setup: &RobotSetup,
    settings: &Settings,
    geometry: &Geometry,
) -> Result<(), InputError> {
    let lacks = |key: &str, alternative: &str| {
        let name = &setup.name;
        let problem = format!("needs masses and lengths that the model of {name} lacks");
        let remedy = format!("give them in its robot.toml, or set {alternative}");
        Err(InputError::new(key, problem, remedy))
    };
    if geometry.dynamics.is_some() {
        Ok(())
    } else if settings.control.torque_limit != TorqueLimit::None {
        lacks("control.torque_limit", "control.torque_limit = \"none\"")
    } else if settings.control.law == Law::ComputedTorque {
        lacks("control.law", "control.law = \"paper\"")
    } else {
        Ok(())
    }
}
