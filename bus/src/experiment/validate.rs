//! Validation of settings: the first value that no run can have, with a remedy.

use super::settings::{Clock, Distribution, Law, OnDeath, Settings, TorqueLimit};
use crate::error::InputError;
use crate::range::{finite, invalid, not_negative, positive};
use crate::time::ns_from_s;

/// Largest number of robots of a run.
const MAX_ROBOTS: u32 = 10_000;
/// Shortest time after which a silent process counts as hung (s).
const MIN_WATCHDOG_S: f64 = 0.5;
/// Longest duration of a run (s).
const MAX_DURATION_S: f64 = 1e6;

impl Settings {
    /// Checks all values, each by itself and in combination.
    ///
    /// # Errors
    /// The first key whose value no run can have.
    pub fn validate(&self) -> Result<(), InputError> {
        self.validate_run()?;
        positive("formation.spacing_m", self.formation.spacing_m)?;
        not_negative("formation.start_s", self.formation.start_s)?;
        self.validate_profile()?;
        finite("open_loop.torque_nm", self.open_loop.torque_nm)?;
        not_negative("open_loop.torque_for_s", self.open_loop.torque_for_s)?;
        self.validate_numbers()?;
        if self.control.law == Law::ComputedTorque
            && self.control.torque_limit == TorqueLimit::Outer
        {
            let problem = "is outer, which limits the set-points of the PI speed loops";
            let remedy = "give none, inner or adaptive, or leave control.law = \"paper\"";
            return invalid("control.torque_limit", problem, remedy);
        }
        self.sensors.present().validate()?;
        self.validate_links()
    }

    /// Duration, number of robots, clock.
    fn validate_run(&self) -> Result<(), InputError> {
        positive("duration_s", self.duration_s)?;
        if self.duration_s > MAX_DURATION_S {
            return invalid("duration_s", "is longer than 11 days", "give at most 1e6");
        }
        if self.robots.count == 0 || self.robots.count > MAX_ROBOTS {
            let problem = format!("is {}", self.robots.count);
            return invalid("robots.count", problem, format!("give 1 to {MAX_ROBOTS}"));
        }
        positive("watchdog_s", self.watchdog_s)?;
        if self.watchdog_s < MIN_WATCHDOG_S {
            let problem = format!(
                "is {}, shorter than a busy machine may hold up a process",
                self.watchdog_s
            );
            return invalid(
                "watchdog_s",
                problem,
                format!("give at least {MIN_WATCHDOG_S}"),
            );
        }
        if self.on_death != OnDeath::Stop && self.clock == Clock::Virtual {
            let problem = "needs the wall clock: in lockstep every process waits for all others";
            let remedy = "add --clock wall, or leave on_death = \"stop\"";
            return invalid("on_death", problem, remedy);
        }
        Ok(())
    }

    /// Periods, then numbers of 0 or more, then numbers above 0.
    fn validate_numbers(&self) -> Result<(), InputError> {
        let Self {
            control,
            links,
            plant,
            ..
        } = self;
        for (key, value) in [
            ("control.outer_period_s", control.outer_period_s),
            ("control.inner_period_s", control.inner_period_s),
            ("plant.step_s", plant.step_s),
            ("recording.state_period_s", self.recording.state_period_s),
        ] {
            period(key, value)?;
        }
        for (key, value) in [
            ("control.k_x", control.k_x),
            ("control.k_y", control.k_y),
            ("control.k_theta", control.k_theta),
            ("control.k_i", control.k_i),
            ("control.watchdog_s", control.watchdog_s),
            ("links.delay_s", links.delay_s),
            ("links.jitter_s", links.jitter_s),
            ("links.ring_timeout_s", links.ring_timeout_s),
        ] {
            not_negative(key, value)?;
        }
        for (key, value) in [
            ("control.k_p", control.k_p),
            ("control.k_v", control.k_v),
            ("control.torque_max_nm", control.torque_max_nm),
            ("control.friction", control.friction),
            ("control.friction_start", control.friction_start),
            (
                "control.watchdog_deceleration_m_s2",
                control.watchdog_deceleration_m_s2,
            ),
            ("control.plant_timeout_s", control.plant_timeout_s),
            ("plant.command_timeout_s", plant.command_timeout_s),
        ] {
            positive(key, value)?;
        }
        Ok(())
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
        for (key, column) in [
            ("profile.times_s", &profile.times_s),
            ("profile.speeds_m_s", &profile.speeds_m_s),
            ("profile.yaw_rates_rad_s", &profile.yaw_rates_rad_s),
        ] {
            column.iter().try_for_each(|&value| finite(key, value))?;
        }
        Ok(())
    }

    fn validate_links(&self) -> Result<(), InputError> {
        let links = &self.links;
        if !(0.0..1.0).contains(&links.loss) {
            let problem = format!("is {}", links.loss);
            return invalid("links.loss", problem, "give a fraction from 0 to below 1");
        }
        if links.burst != 0.0 && !(1.0..=1e6).contains(&links.burst) {
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

/// Accepts periods from 10 µs to 10 s.
fn period(key: &str, value: f64) -> Result<(), InputError> {
    positive(key, value)?;
    if (10_000..=10_000_000_000).contains(&ns_from_s(value)) {
        return Ok(());
    }
    invalid(key, format!("is {value}"), "give 0.00001 to 10")
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
