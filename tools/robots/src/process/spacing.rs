//! Spacing errors of real robots, by the poses that are measured.

use slipstream_bus::Experiment;
use slipstream_bus::time::s_from_ns;
use slipstream_sim::run::{SPACING_FROM_S, Spacing};

/// Spacing errors by the poses of the robots.
pub(super) struct Spacings {
    spacing_m: f64,
    period_ns: i64,
    due_ns: i64,
    paths: Vec<Option<Spacing>>,
    /// Largest error of each robot so far (m).
    pub(super) largest_m: Vec<Option<f64>>,
}

impl Spacings {
    pub(super) fn new(experiment: &Experiment) -> Self {
        let robots = experiment.robots.len();
        Self {
            spacing_m: experiment.settings.formation.spacing_m,
            period_ns: experiment.settings.schedule().outer_ns,
            due_ns: 0,
            paths: vec![None; robots],
            largest_m: vec![None; robots],
        }
    }

    /// Whether it is to be measured: once in every outer period.
    pub(super) fn is_due(&self, now_ns: i64) -> bool {
        now_ns >= self.due_ns
    }

    /// Measures by the last poses.
    pub(super) fn measure(&mut self, now_ns: i64, poses: &[Option<[f64; 3]>]) {
        self.due_ns = now_ns + self.period_ns;
        for i in 1..poses.len() {
            let (Some(ahead), Some(own)) = (poses[i - 1], poses[i]) else {
                continue;
            };
            let path = self.paths[i].get_or_insert_with(|| Spacing::new(ahead));
            path.extend(ahead);
            if s_from_ns(now_ns) >= SPACING_FROM_S {
                let error_m = (path.distance(own) - self.spacing_m).abs();
                let largest = self.largest_m[i].get_or_insert(0.0);
                *largest = largest.max(error_m);
            }
        }
    }

    pub(super) fn largest(&self) -> f64 {
        self.largest_m
            .iter()
            .flatten()
            .fold(0.0, |all, own| own.max(all))
    }
}
