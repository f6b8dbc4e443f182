//! Built-in experiments: the paper's platoon (the default) and single robot, and three platoons on
//! curved paths.

use std::collections::BTreeMap;

use super::hears::Hears;
use super::profile::Profile;
use super::settings::{
    Clock, Control, Distribution, Drive, Feedforward, Formation, Law, LinkSettings, OnDeath,
    OpenLoop, Plant, Protocol, RecordingRates, Robots, SensorSettings, Settings, TorqueLimit,
};

use crate::twist_limits::TwistLimits;

/// Duration of the ramp of the yaw rate at the begin and at the end of a turn (s).
const TURN_RAMP_S: f64 = 0.3;
/// Duration of the acceleration inside a turn (s): so short that the friction that the turn leaves
/// does not suffice.
const TURN_ACCELERATION_S: f64 = 0.2;
/// Speed at the begin of a turn (m/s).
const SLOW_M_S: f64 = 0.4;
/// Speed after the acceleration inside a turn (m/s).
const FAST_M_S: f64 = 0.7;
/// Curvature of the turns (1/m).
const CURVATURE_PER_M: f64 = 2.0;
/// Angle of a turn without a part of constant speed (rad).
const MIN_TURN_RAD: f64 = CURVATURE_PER_M
    * (TURN_RAMP_S * (SLOW_M_S + FAST_M_S) + TURN_ACCELERATION_S * (SLOW_M_S + FAST_M_S))
    / 2.0;

impl Default for Settings {
    fn default() -> Self {
        Self {
            name: "platoon".to_owned(),
            duration_s: 15.0,
            seed: 1,
            clock: Clock::Virtual,
            on_death: OnDeath::Stop,
            watchdog_s: 2.0,
            host_timeout_s: 3.0,
            robots: Robots {
                count: 3,
                model: String::new(),
                start: Vec::new(),
            },
            formation: Formation {
                spacing_m: 0.6096,
                start_s: 3.0,
                feedforward: Feedforward::Message,
            },
            profile: Profile {
                times_s: vec![0.0, 0.5, 5.0, 5.2, 8.0, 12.0],
                speeds_m_s: vec![0.0, 0.2, 0.2, 0.68, 0.68, 0.0],
                yaw_rates_rad_s: vec![0.0; 6],
            },
            open_loop: OpenLoop {
                enabled: false,
                torque_nm: 0.13,
                torque_for_s: 0.5,
            },
            control: Control::default(),
            links: LinkSettings {
                delay_s: 0.0,
                jitter_s: 0.0,
                distribution: Distribution::Normal,
                loss: 0.0,
                burst: 0.0,
                reorder: true,
                trace: String::new(),
                topology: Hears::Predecessor,
                protocol: Protocol::Ring,
                ring_timeout_s: 0.5,
            },
            plant: Plant {
                step_s: 0.001,
                command_timeout_s: 0.1,
            },
            sensors: SensorSettings::default(),
            recording: RecordingRates {
                state_period_s: 0.02,
                trace: true,
            },
            changes: Vec::new(),
            agents: BTreeMap::new(),
            controller: BTreeMap::new(),
        }
    }
}

impl Default for Control {
    fn default() -> Self {
        Self {
            law: Law::Paper,
            drive: Drive::Torque,
            outer_period_s: 0.05,
            inner_period_s: 0.02,
            k_x: 1.0,
            k_y: 15.0,
            k_theta: 6.0,
            k_p: 0.04,
            k_i: 0.16,
            k_v: 10.0,
            torque_max_nm: 0.13,
            torque_limit: TorqueLimit::None,
            friction: 0.24,
            friction_start: 0.5,
            watchdog_s: 1.0,
            watchdog_deceleration_m_s2: 0.5,
            plant_timeout_s: 0.1,
            limits: TwistLimits::NONE,
        }
    }
}

impl Settings {
    /// Section 3 of the paper: one robot in open loop, a torque step on both wheels.
    pub fn single() -> Self {
        let mut settings = Self {
            name: "single".to_owned(),
            duration_s: 2.0,
            ..Self::default()
        };
        settings.robots.count = 1;
        settings.open_loop.enabled = true;
        settings
    }

    /// The platoon along a full circle of radius 0.5 m (not in the paper).
    pub fn circle() -> Self {
        Self::turning("circle", &[std::f64::consts::TAU])
    }

    /// The platoon along a circle to the left, then one to the right, of radius 0.5 m (not in the
    /// paper).
    pub fn figure_eight() -> Self {
        let full = std::f64::consts::TAU;
        Self::turning("figure_eight", &[full, -full])
    }

    /// The platoon shifts to the left by about half of its spacing and drives straight on (not in
    /// the paper).
    pub fn lane_change() -> Self {
        Self::turning("lane_change", &[MIN_TURN_RAD, -MIN_TURN_RAD])
    }

    /// A platoon that turns by each of these angles (rad) and stops gently. It enters each turn
    /// slowly, accelerates inside it beyond the friction limit, and slows down before the next
    /// turn.
    fn turning(name: &str, turns_rad: &[f64]) -> Self {
        // Time (s), speed (m/s), yaw rate (rad/s).
        let mut points = vec![[0.0, 0.0, 0.0], [1.0, SLOW_M_S, 0.0]];
        let mut t_s = 6.0;
        for &angle in turns_rad {
            let curvature = CURVATURE_PER_M.copysign(angle);
            let constant_s = (angle.abs() - MIN_TURN_RAD) / (CURVATURE_PER_M * FAST_M_S);
            for (duration_s, v, turning) in [
                (0.0, SLOW_M_S, false),
                (TURN_RAMP_S, SLOW_M_S, true),
                (TURN_ACCELERATION_S, FAST_M_S, true),
                (constant_s, FAST_M_S, true),
                (TURN_RAMP_S, FAST_M_S, false),
                (0.6, SLOW_M_S, false),
            ] {
                t_s += duration_s;
                let w = if turning { curvature * v } else { 0.0 };
                let before = points.last().map_or(0.0, |point| point[0]);
                if t_s > before {
                    points.push([t_s, v, w]);
                }
            }
            t_s += 0.2;
        }
        points.push([t_s + 1.0, SLOW_M_S, 0.0]);
        points.push([t_s + 3.0, 0.0, 0.0]);
        let column = |i: usize| points.iter().map(|point| point[i]).collect();
        Self {
            name: name.to_owned(),
            duration_s: (t_s + 6.0).ceil(),
            profile: Profile {
                times_s: column(0),
                speeds_m_s: column(1),
                yaw_rates_rad_s: column(2),
            },
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_covers_the_papers_distance() {
        let profile = Settings::default().profile;
        let dt = 1e-3;
        let metres: f64 = (0..15_000)
            .map(|k| profile.at((f64::from(k) + 0.5) * dt).0 * dt)
            .sum();
        // 0.05 + 0.9 + 0.088 + 1.904 + 1.36
        assert!((metres - 4.302).abs() < 1e-9, "{metres}");
        assert_eq!(profile.at(20.0), (0.0, 0.0));
    }

    #[test]
    fn the_yaw_rates_integrate_to_the_turns() {
        let heading = |settings: &Settings| {
            let dt = 1e-3;
            let steps = (settings.duration_s / dt) as i32;
            let rate = |k: i32| settings.profile.at((f64::from(k) + 0.5) * dt).1;
            (0..steps).map(|k| rate(k) * dt).sum::<f64>()
        };
        assert!((heading(&Settings::circle()) - std::f64::consts::TAU).abs() < 1e-3);
        assert!(heading(&Settings::figure_eight()).abs() < 1e-3);
        assert!(heading(&Settings::lane_change()).abs() < 1e-3);
        for settings in [
            Settings::circle(),
            Settings::figure_eight(),
            Settings::lane_change(),
        ] {
            assert_eq!(settings.validate(), Ok(()), "{}", settings.name);
            assert_eq!(settings.profile.at(settings.duration_s), (0.0, 0.0));
        }
    }
}
