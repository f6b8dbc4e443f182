//! Agent: the controller of one robot with what surrounds it, in two loops: odometry, reference, watchdog,
//! torque limits.
//!
//! It has no I/O, clock or threads: the same inputs give the same outputs, bit for bit.

mod reference;
mod slip_limit;
mod watchdog;

use std::cell::Cell;

use slipstream_bus::experiment::{Clock, Drive, Experiment, Settings, Topology, TorqueLimit};
use slipstream_bus::message::{Actuation, Encoders, Extra, Position, RobotIndex};
use slipstream_bus::record::{InnerTick, OuterTick};
use slipstream_bus::time::{ns_from_s, s_from_ns};
use slipstream_bus::{InputError, RobotSetup};

use self::reference::{ReferenceGenerator, References};
use self::slip_limit::{SlipLimit, eq11_nm};
use self::watchdog::Watchdog;
use crate::controller::{Controller, ControllerError, DesiredTwist, Heard, InnerInput, OuterInput};
use crate::geometry::Geometry;
use crate::kanayama::tracking_error;
use crate::odometry::{Odometry, wheel_rotation};
use crate::pose::Pose;
use crate::speed_loop::SpeedLoops;
use crate::traction::rolling_acceleration;
use crate::wheel_torques::WheelTorques;

/// The agent of one robot.
///
/// [`Self::outer`] and [`Self::inner`] run one tick of a loop. The caller decides when they are due
/// ([`Settings::schedule`]) and delivers the positions of the robots that are heard ([`Self::receive`]).
#[derive(Debug, Clone)]
pub struct Agent<C> {
    robot: RobotIndex,
    settings: Settings,
    controller: C,
    geometry: Geometry,
    odometry: Odometry,
    /// The robot whose path this one follows.
    predecessor: Option<RobotIndex>,
    /// Whether somebody leads it, so that a watchdog watches.
    follows: bool,
    reference: ReferenceGenerator,
    /// The newest message of every robot that was heard, in their order.
    heard: Vec<Heard>,
    watchdog: Watchdog,
    loops: SpeedLoops,
    slip_limit: SlipLimit,
    plant_lost: bool,
    /// The last outer tick.
    outer: OuterTick,
    /// What the controller adds to the robot's messages.
    extra: Extra,
    /// Encoders at the last inner tick.
    inner_encoders: Option<Encoders>,
    wheel_speed: [f64; 2],
    /// Torques commanded at the last inner tick and at the one before (N m).
    torques_nm: [[f64; 2]; 2],
    max_desired_m_s: f64,
}

impl<C: Controller> Agent<C> {
    /// The agent of robot `index` of an experiment.
    ///
    /// # Errors
    /// The experiment has no such robot, or its model lacks what the torque limit needs.
    pub fn new(
        experiment: &Experiment,
        index: RobotIndex,
        controller: C,
    ) -> Result<Self, InputError> {
        let settings = experiment.settings.clone();
        let setup = find(experiment, index)?;
        let geometry = Geometry::new(&setup.model)?;
        check_dynamics(setup, &settings, &geometry)?;
        let start = Pose::new(setup.pose);
        let topology = Topology::new(experiment);
        let ahead = index.checked_sub(1);
        // In open loop nobody sends, but every robot keeps its place in the platoon.
        let predecessor = match settings.open_loop.enabled {
            true => ahead,
            false => topology.predecessor(index),
        };
        let path_start = match predecessor {
            Some(predecessor) => Some(Pose::new(find(experiment, predecessor)?.pose)),
            None => None,
        };
        let hears = topology.hears(index);
        Ok(Self {
            robot: index,
            controller,
            odometry: Odometry::new(start, &geometry),
            predecessor,
            follows: predecessor.is_some() || (index > 0 && !hears.is_empty()),
            reference: ReferenceGenerator::new(start, path_start, geometry.d),
            heard: Vec::with_capacity(hears.len()),
            watchdog: Watchdog::new(experiment),
            loops: SpeedLoops::default(),
            slip_limit: SlipLimit::new(&settings.control, &geometry),
            plant_lost: false,
            outer: OuterTick::default(),
            extra: Extra::default(),
            inner_encoders: None,
            wheel_speed: [0.0; 2],
            torques_nm: [[0.0; 2]; 2],
            max_desired_m_s: 0.0,
            geometry,
            settings,
        })
    }

    /// Receives a position of a robot that is heard, newer than all of this robot before, at the outer tick
    /// `now_ns`.
    pub fn receive(&mut self, position: &Position, now_ns: i64) {
        let heard = Heard {
            position: *position,
            taken_s: s_from_ns(now_ns),
            fresh: true,
        };
        let place = self
            .heard
            .binary_search_by_key(&position.from, |own| own.position.from);
        match place {
            Ok(place) => self.heard[place] = heard,
            Err(place) => self.heard.insert(place, heard),
        }
        if self.predecessor == Some(position.from) {
            self.reference.receive(position);
        }
        if self.predecessor.is_none_or(|own| own == position.from) {
            self.watchdog.reset(now_ns);
        }
    }

    /// One tick of the outer loop: odometry, reference, the controller's desired velocities, set-points of the
    /// wheel speeds.
    ///
    /// # Errors
    /// The controller cannot go on, or gives what is no number.
    pub fn outer(
        &mut self,
        now_ns: i64,
        encoders: &Encoders,
    ) -> Result<OuterTick, ControllerError> {
        self.odometry.update(encoders.counts, &self.geometry);
        let References { reference, profile } = self.reference.at(now_ns, &self.settings);
        let reference_axle = reference.pose.ahead(-self.geometry.d);
        let error = tracking_error(self.odometry.axle(), reference_axle);
        let (pose, velocity) = (self.pose(), self.geometry.twist(self.wheel_speed));
        let input = OuterInput {
            t_s: s_from_ns(now_ns),
            period_s: self.settings.control.outer_period_s,
            pose,
            velocity,
            reference: reference.pose.to_array(),
            reference_velocity: reference.velocity,
            error,
            profile: profile.pose.to_array(),
            profile_velocity: profile.velocity,
            coordinates: now_ns >= ns_from_s(self.settings.formation.start_s),
            heard: &self.heard,
        };
        let mut desired = desired(&mut self.controller, &input)?;
        self.extra = extra(&self.controller)?;
        for own in &mut self.heard {
            own.fresh = false;
        }
        let (control, last_v) = (&self.settings.control, self.outer.desired[0]);
        self.watchdog
            .check(now_ns, self.follows, last_v, control, &mut desired);
        self.max_desired_m_s = self.max_desired_m_s.max(desired.v.abs());
        let desired = self.within_limits(desired);
        self.outer = OuterTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            pose,
            velocity,
            reference: reference.pose.to_array(),
            reference_velocity: reference.velocity,
            error,
            desired: [desired.v, desired.w],
            set_point_rad_s: self.set_points(&desired),
            message: reference.message,
        };
        Ok(self.outer)
    }

    /// One tick of the inner loop: wheel speeds, torque limits, the controller's torques.
    ///
    /// # Errors
    /// The controller cannot go on, or gives what is no number.
    pub fn inner(
        &mut self,
        now_ns: i64,
        encoders: &Encoders,
    ) -> Result<InnerTick, ControllerError> {
        self.odometry.update(encoders.counts, &self.geometry);
        self.measure_speed(encoders);
        let control = &self.settings.control;
        let limit_nm = self
            .slip_limit
            .inner_nm(self.wheel_speed, control, &self.geometry);
        self.plant_lost = self.settings.clock == Clock::Wall
            && now_ns - encoders.sampled_ns > ns_from_s(control.plant_timeout_s);
        let torques = self.torques(now_ns, limit_nm)?;
        self.slip_limit.store_torques(&torques);
        self.torques_nm = [torques.torque_nm, self.torques_nm[0]];
        Ok(InnerTick {
            t_ns: now_ns,
            sampled_ns: encoders.sampled_ns,
            robot: self.robot,
            outer_ns: self.outer.t_ns,
            wheel_speed_rad_s: self.wheel_speed,
            wanted_nm: torques.wanted_nm,
            limit_nm,
            torque_nm: torques.torque_nm,
            friction: self.slip_limit.friction(&self.settings.control),
        })
    }

    /// What the drives are told after an inner tick: its torques, or the twist of the outer tick before; a twist of 0 if the
    /// robot is not heard.
    pub fn actuation(&self, tick: &InnerTick) -> Actuation {
        match self.settings.control.drive {
            Drive::Torque => Actuation::Torque(tick.torque_nm),
            Drive::Twist if self.plant_lost => Actuation::Twist([0.0; 2]),
            Drive::Twist => Actuation::Twist(self.outer.desired),
        }
    }

    /// Updates the odometry without a tick of a loop.
    pub fn update_odometry(&mut self, encoders: &Encoders) {
        self.odometry.update(encoders.counts, &self.geometry);
    }

    /// The position message for those that hear the robot, as of the last outer tick. The sender adds `seq`,
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
            extra: self.extra,
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

    /// The desired twist within `control.limits`.
    fn within_limits(&self, desired: DesiredTwist) -> DesiredTwist {
        let control = &self.settings.control;
        let wanted = [desired.v, desired.w];
        let last = self.outer.desired;
        let [v, w] = control.limits.cut(wanted, last, control.outer_period_s);
        DesiredTwist { v, w }
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

    /// The torques of the controller, or of the open loop; none if the plant is lost or the robot is told twists.
    fn torques(
        &mut self,
        now_ns: i64,
        limit_nm: [f64; 2],
    ) -> Result<WheelTorques, ControllerError> {
        if self.plant_lost || self.settings.control.drive == Drive::Twist {
            self.loops.reset();
            return Ok(WheelTorques::ZERO);
        }
        if self.settings.open_loop.enabled {
            return Ok(self.open_loop(now_ns, limit_nm));
        }
        let control = &self.settings.control;
        let friction = self.slip_limit.friction(control)[0];
        let input = InnerInput {
            t_s: s_from_ns(now_ns),
            period_s: control.inner_period_s,
            wheel_speed_rad_s: self.wheel_speed,
            velocity: self.geometry.twist(self.wheel_speed),
            desired: self.outer.desired,
            set_point_rad_s: self.outer.set_point_rad_s,
            limit_nm,
            friction: (control.torque_limit != TorqueLimit::None).then_some(friction),
            brakes: self.watchdog.fired(),
            control,
            loops: &self.loops,
            stepped: Cell::new(None),
        };
        let WheelTorques {
            wanted_nm,
            torque_nm,
        } = self.controller.inner(&input)?;
        if let Some(stepped) = input.stepped.take() {
            self.loops = stepped;
        }
        if !wanted_nm
            .iter()
            .chain(&torque_nm)
            .all(|own| own.is_finite())
        {
            let [right, left] = torque_nm;
            return Err(format!("it gave torques of {right} and {left} N m").into());
        }
        let max_nm = control.torque_max_nm;
        Ok(WheelTorques {
            wanted_nm,
            torque_nm: torque_nm.map(|torque| torque.clamp(-max_nm, max_nm)),
        })
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
}

/// What the controller desires.
fn desired(
    controller: &mut impl Controller,
    input: &OuterInput<'_>,
) -> Result<DesiredTwist, ControllerError> {
    let desired = controller.outer(input)?;
    let DesiredTwist { v, w } = desired;
    match v.is_finite() && w.is_finite() {
        true => Ok(desired),
        false => Err(format!("it gave v = {v} m/s, w = {w} rad/s").into()),
    }
}

/// What the controller adds to the robot's messages.
fn extra(controller: &impl Controller) -> Result<Extra, ControllerError> {
    let extra = controller.message();
    match extra.numbers().iter().find(|own| !own.is_finite()) {
        None => Ok(extra),
        Some(number) => Err(format!("its message has the number {number}").into()),
    }
}

fn find(experiment: &Experiment, index: RobotIndex) -> Result<&RobotSetup, InputError> {
    experiment.robots.get(index as usize).ok_or_else(|| {
        let problem = format!("has no robot {}", index + 1);
        InputError::new("robots.count", problem, "increase the number of robots")
    })
}

/// Torque limits need masses and inertias.
fn check_dynamics(
    setup: &RobotSetup,
    settings: &Settings,
    geometry: &Geometry,
) -> Result<(), InputError> {
    let limit = settings.control.torque_limit;
    if geometry.dynamics.is_some() || limit == TorqueLimit::None {
        return Ok(());
    }
    let name = &setup.name;
    let problem = format!("needs masses and lengths that the model of {name} lacks");
    let remedy = "give them in its robot.toml, or set control.torque_limit = \"none\"";
    Err(InputError::new("control.torque_limit", problem, remedy))
}
