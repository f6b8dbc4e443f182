//! Judges the keys of an experiment: the first value that no run can have, with its remedy.

use crate::error::InputError;
use crate::experiment::{Clock, Distribution, Law, OnDeath, Settings, TorqueLimit};
use crate::time::ns_from_s;

/// Robots that one run can have: the done counter of the barrier has 16 bits.
const MOST_ROBOTS: u32 = 10_000;

impl Settings {
    /// Judges every value, one by one and together.
    ///
    /// # Errors
    /// The first key whose value no run can have.
    pub fn validate(&self) -> Result<(), InputError> {
        let Self {
            control,
            links,
            plant,
            ..
        } = self;
        positive("duration_s", self.duration_s)?;
        if self.duration_s > 1e6 {
            return wrong("duration_s", "is longer than 11 days", "give at most 1e6");
        }
        if self.robots.count == 0 || self.robots.count > MOST_ROBOTS {
            let problem = format!("is {}", self.robots.count);
            return wrong("robots.count", problem, format!("give 1 to {MOST_ROBOTS}"));
        }
        if self.on_death != OnDeath::Stop && self.clock == Clock::Virtual {
            let problem = "needs the wall clock: in lockstep everybody waits for everybody";
            return wrong(
                "on_death",
                problem,
                "add --clock wall, or leave on_death = \"stop\"",
            );
        }
        positive("formation.spacing_m", self.formation.spacing_m)?;
        not_negative("formation.start_s", self.formation.start_s)?;
        self.validate_profile()?;
        finite("open_loop.torque_nm", self.open_loop.torque_nm)?;
        not_negative("open_loop.torque_for_s", self.open_loop.torque_for_s)?;
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
        if control.law == Law::ComputedTorque && control.torque_limit == TorqueLimit::Outer {
            let problem = "is outer, which limits the set-points of the paper's wheel loops";
            let remedy = "give none, inner or adaptive, or leave control.law = \"paper\"";
            return wrong("control.torque_limit", problem, remedy);
        }
        self.sensors.present().validate()?;
        self.validate_links()
    }

    fn validate_profile(&self) -> Result<(), InputError> {
        let profile = &self.profile;
        let points = profile.times_s.len();
        if profile.speeds_m_s.len() != points || profile.yaw_rates_rad_s.len() != points {
            return wrong(
                "profile",
                "has columns of different lengths",
                "give as many speeds_m_s and yaw_rates_rad_s as times_s",
            );
        }
        if profile.times_s.windows(2).any(|pair| pair[0] >= pair[1]) {
            return wrong("profile.times_s", "does not rise", "give rising times");
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
            return wrong("links.loss", problem, "give a share from 0 to below 1");
        }
        if links.burst != 0.0 && !(1.0..=1e6).contains(&links.burst) {
            let problem = format!("is {}", links.burst);
            let remedy = "give the mean length of a run of losses, 1 or more, or 0 for none";
            return wrong("links.burst", problem, remedy);
        }
        // A share of losses and a mean run length leave a mean run of good messages; it cannot be
        // shorter than one.
        if links.burst != 0.0 && links.loss / (1.0 - links.loss) > links.burst {
            let problem = format!("is too short for a loss of {}", links.loss);
            return wrong("links.burst", problem, "give more, or a smaller links.loss");
        }
        if links.distribution == Distribution::Lognormal
            && links.jitter_s > 0.0
            && links.delay_s == 0.0
        {
            let problem = "is 0: a lognormal delay needs a mean";
            return wrong("links.delay_s", problem, "give a delay above 0");
        }
        Ok(())
    }
}

fn wrong<T>(
    key: &str,
    problem: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<T, InputError> {
    Err(InputError::new(key, problem, remedy))
}

fn finite(key: &str, value: f64) -> Result<(), InputError> {
    if value.is_finite() {
        return Ok(());
    }
    wrong(key, format!("is {value}"), "give a finite number")
}

fn not_negative(key: &str, value: f64) -> Result<(), InputError> {
    finite(key, value)?;
    if value >= 0.0 {
        return Ok(());
    }
    wrong(key, format!("is {value}"), "give 0 or more")
}

fn positive(key: &str, value: f64) -> Result<(), InputError> {
    not_negative(key, value)?;
    if value > 0.0 {
        return Ok(());
    }
    wrong(key, "is 0", "give a number above 0")
}

fn period(key: &str, value: f64) -> Result<(), InputError> {
    positive(key, value)?;
    if (10_000..=10_000_000_000).contains(&ns_from_s(value)) {
        return Ok(());
    }
    wrong(key, format!("is {value}"), "give 0.00001 to 10")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_run_can_have_names_its_key() {
        type Spoil = fn(&mut Settings);
        let cases: [(&str, Spoil); 11] = [
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
        for (key, spoil) in cases {
            let mut settings = Settings::default();
            spoil(&mut settings);
            assert_eq!(settings.validate().unwrap_err().place, key);
        }
    }
}
