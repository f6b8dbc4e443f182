//! What a machine's answer says beside its findings: warnings, courses, outliers and noise.

use super::machine::Machine;
use super::task::Task;
use crate::answer::{Outliers, ProcessNoise, Warning};
use crate::data::reference::POSE_STEP_S;
use crate::explain::bench::ORDINARY;
use crate::explain::claim::Claim;
use crate::explain::links::Course;
use crate::judge::QUANTITIES;
use crate::model::view::View;

/// What two simulators differ by, in metres or radians; a smaller part is none.
const NOTHING: f64 = 1e-6;

impl Machine<'_> {
    /// What is taken for a constant and differs between the halves of the recordings.
    pub(super) fn not_constant(&self, task: &Task<'_>, claims: &[Claim]) -> Vec<Warning> {
        let values = claims.iter().flat_map(|claim| {
            let own = claim.values.iter();
            own.filter_map(move |value| Some((claim, value, value.halves?)))
        });
        let each = values.map(|(claim, value, halves)| {
            let nominal = claim.nominal(self.model, value.name);
            let [first, second] = halves.map(|change| value.applied(nominal, change));
            let effect = claim.effect.replace('_', " ");
            let what = format!(
                "{effect}, {}: {first:.4} in the first half, {second:.4} in the second; it is not constant, and its \
                 interval holds both",
                value.name
            );
            let remedy = "diagnose the halves by themselves with --exclude-time, and look what else changed";
            self.warning(task, "not_constant", &what, remedy)
        });
        each.collect()
    }

    /// What fits best and is no physics.
    pub(super) fn implausible(&self, task: &Task<'_>, claim: &Claim) -> Warning {
        let run = claim.runs.as_ref().and_then(|runs| runs.first());
        let of = run.map_or(String::new(), |run| {
            let robot = self.robots[self.machine.runs[*run].robot];
            format!(" in run {}", robot.name)
        });
        let values = claim.values.iter();
        let values: Vec<String> = values
            .map(|value| {
                let nominal = claim.nominal(self.model, value.name);
                format!("{} {:.3}", value.name, value.estimate(nominal))
            })
            .collect();
        let statement = format!(
            "what would fit best{of} is {} with {}, which no robot has: wheels and reference hardly \
             follow each other",
            claim.effect.replace('_', " "),
            values.join(", "),
        );
        let remedy =
            "look whether the wheels slip all the time, and whether both streams share a clock";
        self.warning(task, "implausible", &statement, remedy)
    }

    pub(super) fn courses(&self, fitted: &[f64], deviations: &[[f64; QUANTITIES]]) -> Vec<Course> {
        let runs = self.machine.runs.iter().enumerate();
        let with_pose = runs.filter(|(_, run)| run.pose.is_some());
        with_pose
            .map(|(i, _)| {
                let deviation = [deviations[i][2], deviations[i][3], deviations[i][4]];
                let points = self.machine.course(i, fitted);
                Course::of(self.name.to_owned(), points, deviation)
            })
            .collect()
    }

    pub(super) fn outliers(&self, fitted: &[f64]) -> Vec<Outliers> {
        let view = View {
            machine: &self.machine,
            robust: true,
        };
        let mut outliers: Vec<Outliers> = Vec::new();
        for (stream, times_s) in view.extraordinary(fitted, ORDINARY) {
            if !times_s.is_empty() {
                outliers.push(Outliers {
                    robot: self.name.to_owned(),
                    stream,
                    count: times_s.len(),
                    times_s,
                });
            }
        }
        outliers
    }

    pub(super) fn process_noise(&self, fitted: &[f64]) -> Vec<ProcessNoise> {
        if !self.machine.has_pose() && !self.machine.has_gyro() {
            return Vec::new();
        }
        let [speed, turn] = self.machine.process_noise(fitted);
        let all = [("speed", speed, "m/s"), ("turn_rate", turn, "rad/s")];
        all.into_iter()
            .filter(|(_, size, _)| *size > NOTHING)
            .map(|(acts_on, size, unit)| ProcessNoise {
                robot: self.name.to_owned(),
                acts_on,
                size,
                unit,
                correlation_time_s: POSE_STEP_S,
            })
            .collect()
    }
}
