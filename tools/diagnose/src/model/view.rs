//! The likelihood of what a machine's references say of its wheels: pose and gyro of every run.

use rayon::prelude::*;
use slipstream_sim::Scalar;

use super::comparison;
use super::from_wheels::{FromWheels, Reference};
use super::run::Run;
use super::wheel_parameters::{
    DRIVE_FIRST, GYRO_LATENCY, GYRO_RATE, LAW_FIRST, MACHINE, OFFSET_X, POSE_RATE, RUN_BIAS,
    RUN_NOISE_FIRST, RUN_POSE_LATE, RUN_RATE, RUN_TRACK, TRACK, TURNS_FIRST, drive_parameters,
    gyro_parameters, pose_parameters,
};
use crate::estimate::blocks;
use crate::estimate::cluster::LEAST_RUNS;
use crate::estimate::information::{Dual, Rows, empty};
use crate::estimate::pairs::{self, Share, Side};
use crate::estimate::whitened::Whitened;
use crate::estimate::{BlockScore, Likelihood};
use crate::filter::Innovation;
use crate::filter::wheels_to_pose;

/// Its likelihood, with or without outliers.
pub(crate) struct View<'a> {
    pub(crate) machine: &'a FromWheels,
    /// Whether rows may be outliers. Without, the likelihood has one smooth maximum: a start.
    pub(crate) robust: bool,
}

impl View<'_> {
    /// Runs one filter of one run with the run's local parameters.
    fn filter<S: Scalar>(
        &self,
        reference: Reference,
        run: &Run,
        local: &[S],
        sink: &mut dyn FnMut(Innovation<S>),
    ) {
        match reference {
            Reference::Pose => {
                if let Some(pose) = &run.pose {
                    let filter = self.machine.pose_filter(run, &pose.series, self.robust);
                    run.wheels.turned(drive_parameters(local), |wheels| {
                        filter.run(wheels, &pose_parameters(local), sink);
                    });
                }
            }
            Reference::Gyro => {
                if let Some(gyro) = &run.gyro {
                    let filter = self.machine.gyro_filter(&gyro.series, self.robust);
                    run.wheels.turned(drive_parameters(local), |wheels| {
                        filter.run(wheels, &gyro_parameters(local), sink);
                    });
                }
            }
        }
    }

    /// Log-likelihood of one reference of one run.
    pub(crate) fn value_of(&self, reference: Reference, run: usize, at: &[f64]) -> f64 {
        let mut sum = 0.0;
        let mut sink = |row: Innovation<f64>| sum += row.weight * row.log_likelihood;
        self.innovations(reference, run, at, &mut sink);
        sum
    }

    /// Runs the filter of one reference of one run.
    pub(crate) fn innovations(
        &self,
        reference: Reference,
        run: usize,
        at: &[f64],
        sink: &mut dyn FnMut(Innovation<f64>),
    ) {
        let local = self.machine.local(run, at);
        self.filter(reference, &self.machine.runs[run], &local, sink);
    }

    /// Stamps (s, of the run) of the rows of one reference in one run whose probability of being ordinary is
    /// below `least`.
    pub(crate) fn extraordinary_of(
        &self,
        reference: Reference,
        run: usize,
        at: &[f64],
        least: f64,
    ) -> Vec<f64> {
        let mut times_s = Vec::new();
        self.innovations(reference, run, at, &mut |row: Innovation<f64>| {
            if row.ordinary < least {
                times_s.push(row.time_s);
            }
        });
        times_s.sort_by(f64::total_cmp);
        times_s.dedup();
        times_s
    }

    /// Stamps (s) of the rows of each stream whose probability of being ordinary is below `least`.
    pub(crate) fn extraordinary(&self, at: &[f64], least: f64) -> [(&'static str, Vec<f64>); 2] {
        Reference::ALL.map(|reference| {
            let mut times_s = Vec::new();
            for (i, run) in self.machine.runs.iter().enumerate() {
                let own = self.extraordinary_of(reference, i, at, least);
                times_s.extend(own.into_iter().map(|t_s| t_s + run.origin_s));
            }
            times_s.sort_by(f64::total_cmp);
            times_s.dedup();
            let name = match reference {
                Reference::Pose => "pose",
                Reference::Gyro => "imu",
            };
            (name, times_s)
        })
    }
}

impl Reference {
    /// Whether the filter of this reference reads a local parameter.
    fn reads(self, local: usize, commanded: bool) -> bool {
        if (DRIVE_FIRST..LAW_FIRST).contains(&local) {
            return commanded;
        }
        let geometry = local <= TRACK || (MACHINE..=MACHINE + RUN_TRACK).contains(&local);
        if (LAW_FIRST..MACHINE).contains(&local) {
            return self == Self::Pose || local >= TURNS_FIRST;
        }
        let pose_noise =
            MACHINE + RUN_NOISE_FIRST..MACHINE + RUN_NOISE_FIRST + wheels_to_pose::NOISE;
        geometry
            || match self {
                Self::Pose => {
                    (OFFSET_X..=POSE_RATE).contains(&local)
                        || local == MACHINE + RUN_POSE_LATE
                        || pose_noise.contains(&local)
                }
                Self::Gyro => {
                    local == GYRO_LATENCY
                        || local == GYRO_RATE
                        || (MACHINE + RUN_BIAS..=MACHINE + RUN_RATE).contains(&local)
                        || local >= pose_noise.end
                }
            }
    }
}

impl Likelihood for View<'_> {
    fn blocks(&self) -> usize {
        blocks::total(self.machine.runs.iter().map(|run| run.blocks))
    }

    fn run_of(&self) -> Vec<usize> {
        blocks::run_of(self.machine.runs.iter().map(|run| run.blocks))
    }

    fn clusters(&self) -> Option<&[usize]> {
        self.machine.before.clusters.as_deref()
    }

    fn is_shared(&self, parameter: usize) -> bool {
        let machine = self.machine;
        let of_all = parameter < MACHINE || parameter >= machine.shared(0);
        of_all && machine.before.shows_spread(machine.runs.len(), LEAST_RUNS)
    }

    fn apart(&self, at: &[f64]) -> f64 {
        let machine = self.machine;
        let shares = machine.shares().map(|own| at[machine.share(own)]);
        let shares = shares.map(|logit| Share::new(logit).value);
        shares.reduce(f64::max).unwrap_or(1.0)
    }

    fn loosen(&self, at: &mut [f64]) {
        for own in self.machine.shares() {
            at[self.machine.share(own)] = 0.0;
        }
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        let machine = self.machine;
        let keep = machine.before.is_paired();
        let runs = machine.runs.par_iter().enumerate().map(|(i, run)| {
            let local = machine.local(i, at);
            let mut rows = [Vec::new(), Vec::new()];
            let each = Reference::ALL.par_iter().zip(&mut rows);
            let each = each.map(|(reference, rows)| {
                let mut own = vec![0.0; run.blocks.count];
                self.filter(*reference, run, &local, &mut |row: Innovation<f64>| {
                    let block = run.blocks.of(row.time_s);
                    own[block] += row.weight * row.log_likelihood;
                    if keep {
                        rows.push(Whitened::new(&row, run.blocks.first + block));
                    }
                });
                own
            });
            let each: Vec<Vec<f64>> = each.collect();
            let values: Vec<f64> = each[0].iter().zip(&each[1]).map(|(a, b)| a + b).collect();
            (values, rows)
        });
        let runs: Vec<(Vec<f64>, [Vec<Whitened>; 2])> = runs.collect();
        let mut all: Vec<f64> = runs
            .iter()
            .flat_map(|(values, _)| values)
            .copied()
            .collect();
        for reference in machine.shares() {
            let share = Share::new(at[machine.share(reference)]);
            let rows = |run: usize| &runs[run].1[reference as usize];
            for run in 0..machine.before.runs {
                for (block, gain) in pairs::gains(rows(run), rows(machine.before.runs + run), share)
                {
                    all[block] += gain;
                }
            }
        }
        all
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let machine = self.machine;
        let keep = machine.before.is_paired();
        let mut blocks = empty(Likelihood::blocks(self), free.len());
        let all = machine.runs.par_iter().enumerate();
        let all = all.flat_map(|run| Reference::ALL.par_iter().map(move |r| (run, *r)));
        let all = all.map(|((i, run), reference)| {
            let places = machine.places(i).into_iter();
            let read = places.filter(|(l, _)| reference.reads(*l, run.wheels.is_commanded()));
            let (local, to) = comparison::lanes(read, free);
            let filter = |p: &[Dual], sink: &mut dyn FnMut(Innovation<Dual>)| {
                self.filter(reference, run, p, sink);
            };
            let block = |t_s: f64| run.blocks.first + run.blocks.of(t_s);
            let local = Rows::new(&machine.local(i, at), &local, keep, filter, block);
            (local, to)
        });
        let all: Vec<(Rows, Vec<(usize, usize)>)> = all.collect();
        for (rows, to) in &all {
            rows.add_to(&mut blocks, to);
        }
        for reference in machine.shares() {
            let index = machine.share(reference);
            let place = free.iter().position(|own| *own == index);
            let side = |run: usize| {
                let (rows, to) = &all[Reference::ALL.len() * run + reference as usize];
                Side { rows, to }
            };
            for run in 0..machine.before.runs {
                let both = [side(run), side(machine.before.runs + run)];
                pairs::add_to(&mut blocks, both, Share::new(at[index]), place);
            }
        }
        blocks
    }
}
