//! Built-in experiments: the paper's platoon (the default) and single robot, and three with turns.

use super::settings::{
    Clock, Control, Distribution, Feedforward, Formation, Law, LinkSettings, OnDeath, OpenLoop,
    Plant, Profile, Protocol, RecordingRates, Robots, SensorSettings, Settings, TorqueLimit,
};

/// A turn of the built-in experiments takes 0.3 s to begin and to end. Inside it the robots go from
/// the slower speed to the faster one in 0.2 s: more than the floor carries beside the turn.
const TURN_RAMP_S: f64 = 0.3;
const TURN_STEP_S: f64 = 0.2;
const SLOWER_M_S: f64 = 0.4;
const FASTER_M_S: f64 = 0.7;
/// Curvature of the turns (1/m).
const CURVATURE_PER_M: f64 = 2.0;
/// A turn that ends as soon as it can turns by this (rad).
const LEAST_TURN_RAD: f64 = CURVATURE_PER_M
    * (TURN_RAMP_S * (SLOWER_M_S + FASTER_M_S) + TURN_STEP_S * (SLOWER_M_S + FASTER_M_S))
    / 2.0;

impl Default for Settings {
    fn default() -> Self {
        Self {
            name: "platoon".to_owned(),
            duration_s: 15.0,
            seed: 1,
            clock: Clock::Virtual,
            on_death: OnDeath::Stop,
            robots: Robots {
                count: 3,
                model: String::new(),
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
        }
    }
}

impl Default for Control {
    fn default() -> Self {
        Self {
            law: Law::Paper,
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
        }
    }
}

impl Settings {
    /// Section 3 of the paper: one robot, a torque step on both wheels.
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

    /// Beyond the paper: the platoon along a full circle of radius 0.5 m.
    pub fn circle() -> Self {
        Self::turning("circle", &[std::f64::consts::TAU])
    }

    /// Beyond the paper: a circle to the left, then one to the right, of radius 0.5 m.
    pub fn figure_eight() -> Self {
        let full = std::f64::consts::TAU;
        Self::turning("figure_eight", &[full, -full])
    }

    /// Beyond the paper: about half a robot spacing to the left and straight on.
    pub fn lane_change() -> Self {
        Self::turning("lane_change", &[LEAST_TURN_RAD, -LEAST_TURN_RAD])
    }

    /// A platoon that turns by these angles (rad) one after the other and stops softly. It enters each
    /// turn slowly, accelerates inside it harder than the floor carries, and is slow again before
    /// the next.
    fn turning(name: &str, turns: &[f64]) -> Self {
        let mut points = vec![[0.0, 0.0, 0.0], [1.0, SLOWER_M_S, 0.0]];
        let mut t_s = 6.0;
        for &angle in turns {
            let curvature = CURVATURE_PER_M.copysign(angle);
            let held_s = (angle.abs() - LEAST_TURN_RAD) / (CURVATURE_PER_M * FASTER_M_S);
            for (length_s, v, turning) in [
                (0.0, SLOWER_M_S, false),
                (TURN_RAMP_S, SLOWER_M_S, true),
                (TURN_STEP_S, FASTER_M_S, true),
                (held_s, FASTER_M_S, true),
                (TURN_RAMP_S, FASTER_M_S, false),
                (0.6, SLOWER_M_S, false),
            ] {
                t_s += length_s;
                let w = if turning { curvature * v } else { 0.0 };
                let before = points.last().map_or(0.0, |point| point[0]);
                if t_s > before {
                    points.push([t_s, v, w]);
                }
            }
            t_s += 0.2;
        }
        points.push([t_s + 1.0, SLOWER_M_S, 0.0]);
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
    use super::super::settings::{Experiment, RobotSetup};
    use super::*;
    use crate::robot::RobotModel;

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
    fn turns_end_where_they_should() {
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

    #[test]
    fn the_description_survives_the_way_to_the_processes() {
        let experiment = Experiment {
            settings: Settings::single(),
            robots: vec![RobotSetup {
                name: "r1".into(),
                model: RobotModel::paper_with_slip(),
                pose: [0.0; 3],
            }],
            half_round_trips_ns: vec![Some(1), None],
        };
        let bytes = postcard::to_allocvec(&experiment).unwrap();
        assert_eq!(
            postcard::from_bytes::<Experiment>(&bytes).unwrap(),
            experiment
        );
    }
}
