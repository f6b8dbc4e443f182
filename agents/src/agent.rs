//! One robot's controller: what it decides at a tick, from what it knows at that tick.
//!
//! No I/O, no clock, no thread: the same inputs give the same bits.

use slipstream_bus::experiment::{Clock, Experiment, Feedforward, Law, Settings, TorqueLimit};
use slipstream_bus::message::{Encoders, Position, RobotIndex};
use slipstream_bus::record::{InnerTick, OuterTick};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::{InputError, RobotSetup};

use crate::computed_torque::{Wish, computed_torque, on_this_floor};
use crate::friction::FrictionEstimate;
use crate::geometry::Geometry;
use crate::kanayama::{Desired, desired};
use crate::odometry::{Odometry, turned};
use crate::path::Path;
use crate::pose::Pose;
use crate::traction::{normal_forces_n, rolling_acceleration, torque_limit_nm};
use crate::wheels::{WheelLoops, WheelTorque};

/// The longest step in which the profile is integrated (ns).
const PROFILE_STEP_NS: i64 = 5_000_000;

/// The controller of one robot.
#[derive(Debug, Clone)]
pub struct Agent {
    robot: RobotIndex,
    settings: Settings,
    geometry: Geometry,
    timeout_ns: i64,
    odometry: Odometry,
    loops: WheelLoops,
    friction: FrictionEstimate,
    ahead: Option<Path>,
    /// Where the profile by itself would have the axle's middle.
    profile_axle: Pose,
    profile_ns: i64,
    newest: Option<Position>,
    fresh_ns: i64,
    watchdog: bool,
    plant_lost: bool,
    outer: OuterTick,
    /// How v_r and w_r changed between the last two outer ticks (m/s², rad/s²).
    reference_rate: [f64; 2],
    inner_encoders: Option<Encoders>,
    wheel_speed: [f64; 2],
    /// Commanded at the last inner tick and at the one before.
    torques_nm: [[f64; 2]; 2],
    max_desired_m_s: f64,
}

impl Agent {
    /// The controller of robot `index` of an experiment.
    ///
    /// # Errors
    /// A robot whose model lacks what the chosen control needs.
    pub fn new(experiment: &Experiment, index: RobotIndex) -> Result<Self, InputError> {
        let settings = experiment.settings.clone();
        let setup = find(experiment, index)?;
        let geometry = Geometry::new(&setup.model)?;
        let lacks = |key: &str, remedy: &str| {
            let name = &setup.name;
            let problem = format!("needs masses and lengths that the model of {name} lacks");
            InputError::new(
                key,
                problem,
                format!("give them in its robot.toml, or set {remedy}"),
            )
        };
        if geometry.dynamics.is_none() && settings.control.torque_limit != TorqueLimit::None {
            let remedy = "control.torque_limit = \"none\"";
            return Err(lacks("control.torque_limit", remedy));
        }
        if geometry.dynamics.is_none() && settings.control.law == Law::ComputedTorque {
            return Err(lacks("control.law", "control.law = \"paper\""));
        }
        let control = &settings.control;
        let start = Pose::new(setup.pose);
        let ahead = match index.checked_sub(1) {
            Some(ahead) => Some(Path::new(Pose::new(find(experiment, ahead)?.pose))),
            None => None,
        };
        Ok(Self {
            robot: index,
            timeout_ns: timeout_ns(experiment),
            odometry: Odometry::new(start, &geometry),
            loops: WheelLoops::default(),
            friction: FrictionEstimate::new(
                control.friction_start,
                control.inner_period_s,
                &geometry,
            ),
            ahead,
            profile_axle: start.ahead(-geometry.d),
            profile_ns: 0,
            newest: None,
            fresh_ns: 0,
            watchdog: false,
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

    /// Takes in a position of the robot ahead, newer than all before, at the outer tick `now_ns`.
    pub fn take(&mut self, position: &Position, now_ns: i64) {
        if let Some(path) = &mut self.ahead {
            let pose = Pose::new([position.x_m, position.y_m, position.yaw_rad]);
            path.extend(pose, [position.v_m_s, position.w_rad_s]);
            self.newest = Some(*position);
            self.fresh_ns = now_ns;
        }
    }

    /// The outer loop: reference, Eq. 12, set-points for the wheels.
    pub fn outer(&mut self, now_ns: i64, encoders: &Encoders) -> OuterTick {
        self.odometry.update(encoders.counts, &self.geometry);
        self.integrate_profile(now_ns);
        let axle = self.odometry.axle();
        let (reference, velocity, message) = self.reference(now_ns);
        let behind = reference.ahead(-self.geometry.d);
        let mut wish = desired(axle, behind, velocity, &self.settings.control);
        self.watch(now_ns, &mut wish);
        self.max_desired_m_s = self.max_desired_m_s.max(wish.v.abs());
        let before = self.outer.reference_velocity;
        let period_s = self.settings.control.outer_period_s;
        self.reference_rate = [0, 1].map(|i| (velocity[i] - before[i]) / period_s);
        self.outer = OuterTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            pose: self.odometry.centre_of_mass(&self.geometry).to_array(),
            velocity: self.geometry.twist(self.wheel_speed),
            reference: reference.to_array(),
            reference_velocity: velocity,
            error: wish.error,
            desired: [wish.v, wish.w],
            set_point_rad_s: self.set_points(&wish),
            message,
        };
        self.outer
    }

    /// The inner loop: torques for the wheels.
    pub fn inner(&mut self, now_ns: i64, encoders: &Encoders) -> InnerTick {
        self.odometry.update(encoders.counts, &self.geometry);
        self.measure_speed(encoders);
        let limit_nm = self.limits_nm();
        let control = &self.settings.control;
        self.plant_lost = self.settings.clock == Clock::Wall
            && now_ns - encoders.sampled_ns > ns_from_s(control.plant_timeout_s);
        let torque = if self.plant_lost {
            self.loops.reset();
            WheelTorque {
                wanted_nm: [0.0; 2],
                torque_nm: [0.0; 2],
            }
        } else if self.settings.open_loop.enabled {
            self.open_loop(now_ns, limit_nm)
        } else if let (Law::ComputedTorque, Some(dynamics)) = (control.law, &self.geometry.dynamics)
        {
            computed_torque(&self.wish(), dynamics, &self.geometry)
        } else {
            let set_point = self.outer.set_point_rad_s;
            self.loops
                .step(self.wheel_speed, set_point, limit_nm, control)
        };
        self.friction.applied(&torque);
        self.torques_nm = [torque.torque_nm, self.torques_nm[0]];
        InnerTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            outer_ns: self.outer.t_ns,
            wheel_speed_rad_s: self.wheel_speed,
            wanted_nm: torque.wanted_nm,
            limit_nm,
            torque_nm: torque.torque_nm,
            friction: self.believed_friction(),
        }
    }

    /// Takes in the encoders without a tick.
    pub fn see(&mut self, encoders: &Encoders) {
        self.odometry.update(encoders.counts, &self.geometry);
    }

    /// What the robot tells the next one at the outer tick that just ran. Numbering and times of
    /// sending are the sender's business.
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

    /// Goes on where a predecessor that died had come to: its pose of c and its counters.
    pub fn resume(&mut self, pose: [f64; 3], counts: [i64; 2]) {
        self.odometry = Odometry::resumed(Pose::new(pose), counts, &self.geometry);
    }

    /// The counters behind the odometry's pose.
    pub fn counts(&self) -> [i64; 2] {
        self.odometry.counts()
    }

    /// Where the robot believes to be: x (m), y (m), φ (rad) of c.
    pub fn pose(&self) -> [f64; 3] {
        self.odometry.centre_of_mass(&self.geometry).to_array()
    }

    /// The largest desired speed so far, before limiting (m/s).
    pub fn max_desired_speed_m_s(&self) -> f64 {
        self.max_desired_m_s
    }

    /// Whether the follower slows down because it has no fresh position.
    pub fn watchdog_fired(&self) -> bool {
        self.watchdog
    }

    /// Wheel speeds since the last inner tick, by the encoders' own times.
    fn measure_speed(&mut self, encoders: &Encoders) {
        let before = self.inner_encoders.replace(*encoders).unwrap_or(*encoders);
        let elapsed_ns = encoders.sampled_ns - before.sampled_ns;
        if elapsed_ns > 0 {
            self.wheel_speed = turned(before.counts, encoders.counts, &self.geometry)
                .map(|angle| angle / s_from_ns(elapsed_ns));
        }
    }

    /// Whether the encoders are silent, so that there is no torque.
    pub fn plant_lost(&self) -> bool {
        self.plant_lost
    }

    fn integrate_profile(&mut self, now_ns: i64) {
        let mut t_ns = self.profile_ns;
        while t_ns < now_ns {
            let step_ns = PROFILE_STEP_NS.min(now_ns - t_ns);
            let (v, w) = self
                .settings
                .profile
                .at(s_from_ns(t_ns) + 0.5 * s_from_ns(step_ns));
            let step_s = s_from_ns(step_ns);
            self.profile_axle = self.profile_axle.driven(v * step_s, w * step_s);
            t_ns += step_ns;
        }
        self.profile_ns = now_ns;
    }

    /// The reference pose of c, its velocities, and the message that it comes from.
    fn reference(&mut self, now_ns: i64) -> (Pose, [f64; 2], Option<u32>) {
        let (v_profile, w_profile) = self.settings.profile.at(s_from_ns(now_ns));
        let alone = (
            self.profile_axle.ahead(self.geometry.d),
            [v_profile, w_profile],
            None,
        );
        let formation = &self.settings.formation;
        let Some(path) = &mut self.ahead else {
            return alone;
        };
        if now_ns < ns_from_s(formation.start_s) {
            return alone;
        }
        let point = path.behind(formation.spacing_m);
        let v_r = match formation.feedforward {
            Feedforward::Profile => v_profile,
            Feedforward::Message => self.newest.map_or(0.0, |position| position.v_m_s),
        };
        (
            point.pose,
            [v_r, v_r * point.curvature],
            self.newest.map(|p| p.seq),
        )
    }

    /// Without a fresh position for too long the desired speed runs out; it comes back at once.
    fn watch(&mut self, now_ns: i64, wish: &mut Desired) {
        let since = self
            .fresh_ns
            .max(ns_from_s(self.settings.formation.start_s));
        self.watchdog = self.ahead.is_some() && now_ns - since > self.timeout_ns;
        if self.watchdog {
            let control = &self.settings.control;
            let less = control.watchdog_deceleration_m_s2 * control.outer_period_s;
            let before = self.outer.desired[0];
            wish.v = before.signum() * (before.abs() - less).max(0.0);
            wish.w = 0.0;
        }
    }

    fn set_points(&self, wish: &Desired) -> [f64; 2] {
        let set_point = self.geometry.wheel_speeds(wish.v, wish.w);
        let control = &self.settings.control;
        if control.torque_limit != TorqueLimit::Outer {
            return set_point;
        }
        // One encoder count more or less in a tick must not lead beyond the limit.
        let grain_nm = control.k_p * self.geometry.count_rad / control.inner_period_s;
        let limit_nm = self
            .eq11_nm(control.friction)
            .map(|n| (n - grain_nm).max(0.0));
        let drift = self.drift_rad_s();
        self.loops
            .reachable(self.wheel_speed, drift, set_point, limit_nm, control)
    }

    /// How much the measured wheel speeds will change until the next inner tick, by the torques of
    /// the last two (a measured speed is the mean over its tick).
    fn drift_rad_s(&self) -> [f64; 2] {
        let Some(dynamics) = &self.geometry.dynamics else {
            return [0.0; 2];
        };
        let [last, before] = self.torques_nm;
        let mean = [0, 1].map(|i| (last[i] + before[i]) / 2.0);
        rolling_acceleration(mean, dynamics, &self.geometry)
            .map(|alpha| alpha * self.settings.control.inner_period_s)
    }

    /// The limits at the end of the inner loop (N m).
    fn limits_nm(&mut self) -> [f64; 2] {
        let control = &self.settings.control;
        match control.torque_limit {
            TorqueLimit::None | TorqueLimit::Outer => [control.torque_max_nm; 2],
            TorqueLimit::Inner => self.eq11_nm(control.friction),
            TorqueLimit::Adaptive => {
                if let Some(dynamics) = &self.geometry.dynamics {
                    let twist = self.geometry.twist(self.wheel_speed);
                    let normal_n = normal_forces_n(dynamics, &self.geometry, twist);
                    self.friction
                        .feel(self.wheel_speed, normal_n, dynamics, &self.geometry);
                }
                self.eq11_nm(self.friction.friction())
            }
        }
    }

    /// Eq. 11 for both wheels, each with its own N, never above what the motors give (N m).
    fn eq11_nm(&self, friction: f64) -> [f64; 2] {
        let most = self.settings.control.torque_max_nm;
        let Some(dynamics) = &self.geometry.dynamics else {
            return [most; 2];
        };
        let twist = self.geometry.twist(self.wheel_speed);
        normal_forces_n(dynamics, &self.geometry, twist)
            .map(|n| torque_limit_nm(dynamics, &self.geometry, friction, n).min(most))
    }

    fn open_loop(&self, now_ns: i64, limit_nm: [f64; 2]) -> WheelTorque {
        let open_loop = &self.settings.open_loop;
        let on = now_ns < ns_from_s(open_loop.torque_for_s);
        let wanted = if on { open_loop.torque_nm } else { 0.0 };
        WheelTorque {
            wanted_nm: [wanted; 2],
            torque_nm: limit_nm.map(|limit| wanted.clamp(-limit, limit)),
        }
    }

    /// What the dynamics are asked for: the reference's own acceleration, and what brings the speeds
    /// to the desired ones.
    fn wish(&self) -> Wish {
        let control = &self.settings.control;
        let twist = self.geometry.twist(self.wheel_speed);
        let friction =
            Some(self.believed_friction()[0]).filter(|_| control.torque_limit != TorqueLimit::None);
        let mut desired = self.outer.desired;
        if let (Some(friction), Some(dynamics)) = (friction, &self.geometry.dynamics) {
            desired = on_this_floor(desired, friction, dynamics, &self.geometry);
        }
        let rate = if self.watchdog {
            [0.0; 2]
        } else {
            self.reference_rate
        };
        Wish {
            acceleration: [0, 1].map(|i| rate[i] + control.k_v * (desired[i] - twist[i])),
            twist,
            friction,
            torque_max_nm: control.torque_max_nm,
        }
    }

    /// The friction behind the limit and its standard deviation; 0 where nothing is estimated.
    fn believed_friction(&self) -> [f64; 2] {
        match self.settings.control.torque_limit {
            TorqueLimit::None => [0.0; 2],
            TorqueLimit::Inner | TorqueLimit::Outer => [self.settings.control.friction, 0.0],
            TorqueLimit::Adaptive => [self.friction.friction(), self.friction.standard_deviation()],
        }
    }
}

fn find(experiment: &Experiment, index: RobotIndex) -> Result<&RobotSetup, InputError> {
    experiment.robots.get(index as usize).ok_or_else(|| {
        let problem = format!("has no robot {}", index + 1);
        InputError::new(
            "robots.count",
            problem,
            "give as many robots as are asked for",
        )
    })
}

/// How long a follower waits for a fresh position: as long as one takes when all goes well, and
/// the watchdog's time on top (ns).
fn timeout_ns(experiment: &Experiment) -> i64 {
    let settings = &experiment.settings;
    settings.expected_token_round_ns(experiment.longest_trace_ns())
        + ns_from_s(settings.control.watchdog_s)
}
