//! Validation of settings: the first value that no run can have, with a remedy.

use super::parameters::EVERY_ROBOT;
use super::settings::{Clock, Control, Distribution, Drive, Law, OnDeath, Settings, TorqueLimit};
use super::topology;
use crate::error::InputError;
use crate::message::robot_name;
use crate::range::{self, invalid, within};

/// Largest number of robots of a run.
const MAX_ROBOTS: u32 = 10_000;

impl Settings {
    /// Checks all values, each by itself and in combination.
    ///
    /// # Errors
    /// The first key whose value no run can have.
    pub fn validate(&self) -> Result<(), InputError> {
        self.validate_run()?;
        self.validate_numbers()?;
        self.validate_profile()?;
        if self.control.law == Law::ComputedTorque
            && self.control.torque_limit == TorqueLimit::Outer
        {
            let problem = "is outer, which limits the set-points of the PI speed loops";
            let remedy = "give none, inner or adaptive, or leave control.law = \"paper\"";
            return invalid("control.torque_limit", problem, remedy);
        }
        self.validate_drive()?;
        self.sensors.present().validate()?;
        self.validate_links()?;
        topology::validate(self)?;
        self.changes_in_time()?;
        self.validate_agents()
    }

    /// What only torques have, where robots are told twists.
    fn validate_drive(&self) -> Result<(), InputError> {
        let control = &self.control;
        if control.drive == Drive::Torque {
            return Ok(());
        }
        let needs_torques = [
            ("open_loop.enabled", self.open_loop.enabled),
            (
                "control.torque_limit",
                control.torque_limit != TorqueLimit::None,
            ),
            ("control.law", control.law == Law::ComputedTorque),
        ];
        match needs_torques.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((key, _)) => {
                let problem = "is about torques, and the robots are told twists";
                invalid(
                    key,
                    problem,
                    "leave it out, or give control.drive = \"torque\"",
                )
            }
        }
    }

    /// Names of robots in `[agents]` and `[controller]`.
    fn validate_agents(&self) -> Result<(), InputError> {
        let robots = self.robots.count;
        let is_robot = |name: &str| (0..robots).any(|robot| robot_name(robot) == name);
        let named = |table: &str, name: &str| match name == EVERY_ROBOT || is_robot(name) {
            true => Ok(()),
            false => {
                let remedy = format!("give r1 to {}, or * for all", robot_name(robots - 1));
                invalid(
                    &format!("{table}.{name}"),
                    "names no robot of the run",
                    remedy,
                )
            }
        };
        for name in self.agents.keys() {
            named("agents", name)?;
        }
        for name in self.controller.keys() {
            named("controller", name)?;
            let has_program = |robot| {
                let own = name == EVERY_ROBOT || robot_name(robot) == *name;
                own && self.program(robot).is_some()
            };
            if !(0..robots).any(has_program) {
                let problem = "is for a program, and no such robot has one";
                let remedy = "give it one (--agent NAME=PROGRAM); keys of the built-in controller are control.*";
                return invalid(&format!("controller.{name}"), problem, remedy);
            }
        }
        Ok(())
    }

    /// Duration, number of robots, clock.
    fn validate_run(&self) -> Result<(), InputError> {
        within("duration_s", self.duration_s, range::DURATION_S)?;
        if self.robots.count == 0 || self.robots.count > MAX_ROBOTS {
            let problem = format!("is {}", self.robots.count);
            return invalid("robots.count", problem, format!("give 1 to {MAX_ROBOTS}"));
        }
        for pose in &self.robots.start {
            let values = pose.iter();
            values
                .copied()
                .try_for_each(|value| within("robots.start", value, range::OFFSET_M))?;
        }
        within("watchdog_s", self.watchdog_s, range::WATCHDOG_S)?;
        within("host_timeout_s", self.host_timeout_s, range::HOST_TIMEOUT_S)?;
        if self.on_death != OnDeath::Stop && self.clock == Clock::Virtual {
            let problem = "needs the wall clock: in lockstep every process waits for all others";
            let remedy = "add --clock wall, or leave on_death = \"stop\"";
            return invalid("on_death", problem, remedy);
        }
        Ok(())
    }

    /// Numbers that stand by themselves.
    fn validate_numbers(&self) -> Result<(), InputError> {
        let Self {
            formation,
            open_loop,
            links,
            plant,
            recording,
            ..
        } = self;
        for (key, value, range) in [
            ("formation.spacing_m", formation.spacing_m, range::LENGTH_M),
            ("formation.start_s", formation.start_s, range::TIME_S),
            ("open_loop.torque_nm", open_loop.torque_nm, range::TORQUE_NM),
            (
                "open_loop.torque_for_s",
                open_loop.torque_for_s,
                range::TIME_S,
            ),
            ("links.delay_s", links.delay_s, range::DELAY_S),
            ("links.jitter_s", links.jitter_s, range::DELAY_S),
            ("links.ring_timeout_s", links.ring_timeout_s, range::DELAY_S),
            ("plant.step_s", plant.step_s, range::PERIOD_S),
            (
                "plant.command_timeout_s",
                plant.command_timeout_s,
                range::TIMEOUT_S,
            ),
            (
                "recording.state_period_s",
                recording.state_period_s,
                range::PERIOD_S,
            ),
        ] {
            within(key, value, range)?;
        }
        self.control.validate()
    }

    fn validate_profile(&self) -> Result<(), InputError> {
        let profile = &self.profile;
        let points = profile.times_s.len();
        if profile.speeds_m_s.len() != points || profile.yaw_rates_rad_s.len() != points {
            return invalid(
                "profile",
                "has columns of different lengths",
                "give as many speeds_m_s and yaw_rates_rad_s as times_s",
            );
        }
        if profile.times_s.windows(2).any(|pair| pair[0] >= pair[1]) {
            return invalid(
                "profile.times_s",
                "do not increase",
                "give increasing times",
            );
        }
        for (key, column, range) in [
            ("profile.times_s", &profile.times_s, range::TIME_S),
            ("profile.speeds_m_s", &profile.speeds_m_s, range::SPEED_M_S),
            (
                "profile.yaw_rates_rad_s",
                &profile.yaw_rates_rad_s,
                range::YAW_RATE_RAD_S,
            ),
        ] {
            column
                .iter()
                .try_for_each(|&value| within(key, value, range))?;
        }
        Ok(())
    }

    fn validate_links(&self) -> Result<(), InputError> {
        let links = &self.links;
        if !(0.0..1.0).contains(&links.loss) {
            let problem = format!("is {}", links.loss);
            return invalid("links.loss", problem, "give a fraction from 0 to below 1");
        }
        if links.burst != 0.0 && within("links.burst", links.burst, range::BURST).is_err() {
            let problem = format!("is {}", links.burst);
            let remedy = "give the mean length of a loss burst, 1 or more, or 0 for none";
            return invalid("links.burst", problem, remedy);
        }
        // Loss fraction and mean burst length determine the mean number of messages between two
        // bursts, which is at least 1.
        if links.burst != 0.0 && links.loss / (1.0 - links.loss) > links.burst {
            let problem = format!("is too small for a loss of {}", links.loss);
            return invalid("links.burst", problem, "give more, or a smaller links.loss");
        }
        if links.distribution == Distribution::Lognormal
            && links.jitter_s > 0.0
            && links.delay_s == 0.0
        {
            let problem = "is 0: a lognormal delay needs a mean";
            return invalid("links.delay_s", problem, "give a delay above 0");
        }
        Ok(())
    }
}

impl Control {
    fn validate(&self) -> Result<(), InputError> {
        for (key, value, range) in [
            ("outer_period_s", self.outer_period_s, range::PERIOD_S),
            ("inner_period_s", self.inner_period_s, range::PERIOD_S),
            ("k_x", self.k_x, range::GAIN_OR_NONE),
            ("k_y", self.k_y, range::GAIN_OR_NONE),
            ("k_theta", self.k_theta, range::GAIN_OR_NONE),
            ("k_i", self.k_i, range::GAIN_OR_NONE),
            ("k_p", self.k_p, range::GAIN),
            ("k_v", self.k_v, range::GAIN),
            ("torque_max_nm", self.torque_max_nm, range::MOTOR_TORQUE_NM),
            ("friction", self.friction, range::FRICTION),
            ("friction_start", self.friction_start, range::FRICTION),
            ("watchdog_s", self.watchdog_s, range::TIME_S),
            (
                "watchdog_deceleration_m_s2",
                self.watchdog_deceleration_m_s2,
                range::ACCELERATION_M_S2,
            ),
            ("plant_timeout_s", self.plant_timeout_s, range::TIMEOUT_S),
        ] {
            within(&format!("control.{key}"), value, range)?;
        }
        self.limits.validate("control.limits")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_value_names_its_key() {
        type Change = fn(&mut Settings);
        let cases: [(&str, Change); 11] = [
            ("robots.count", |s| s.robots.count = 0),
            ("duration_s", |s| s.duration_s = f64::NAN),
            ("links.delay_s", |s| s.links.delay_s = -0.1),
            ("links.loss", |s| s.links.loss = 1.0),
            ("links.burst", |s| s.links.burst = 0.5),
            ("plant.step_s", |s| s.plant.step_s = 1e-9),
            ("control.torque_limit", |s| {
                s.control.law = Law::ComputedTorque;
                s.control.torque_limit = TorqueLimit::Outer;
            }),
            ("on_death", |s| s.on_death = OnDeath::Continue),
            ("profile", |s| s.profile.speeds_m_s.clear()),
            ("profile.times_s", |s| s.profile.times_s[1] = 0.0),
            ("links.burst", |s| {
                s.links.loss = 0.9;
                s.links.burst = 2.0;
            }),
        ];
        assert_eq!(Settings::default().validate(), Ok(()));
        assert_eq!(Settings::single().validate(), Ok(()));
        for (key, change) in cases {
            let mut settings = Settings::default();
            change(&mut settings);
            assert_eq!(settings.validate().unwrap_err().place, key);
        }
    }
}
