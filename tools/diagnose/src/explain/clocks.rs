//! Latencies: their intervals, and those of single runs where each has a clock of its own.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::claim::{Claim, Value};
use super::naming::Naming;
use super::several_maxima::widen;
use crate::estimate::term::Link;
use crate::model::from_wheels::GYRO_LATENCY;
use crate::model::run::Run;
use crate::model::streams::read;
use crate::model::table::Key;
use crate::select::criterion::FALSE_ALARM;

/// Parameters that are clocks.
const CLOCKS: [&str; 2] = ["latency_s", "delay_s"];
/// Clocks of runs differ when the probability of their spread without a difference is below this; and by which
/// nobody would call it one (s).
const RUNS_DIFFER: f64 = 1e-3;
const LATE_S: f64 = 0.01;

impl Naming<'_> {
    /// The interval of a clock, whose likelihood has more than one maximum.
    pub(super) fn clock(&self, value: &mut Value, weights: &[(usize, f64)]) {
        if !CLOCKS.contains(&value.name) {
            return;
        }
        let squares: f64 = weights.iter().map(|(_, weight)| weight * weight).sum();
        let nats = self.found.criterion.half_width().powi(2) / 2.0;
        self.with_objective(|objective| {
            widen(value, nats, |beside| {
                let moved = weights.iter().map(|(i, w)| (*i, w * beside / squares));
                objective(&moved.collect::<Vec<_>>())
            });
        });
    }

    /// Middle of the run of a robot (s).
    fn middle_s(&self, robot: Option<i64>) -> f64 {
        let reference = self.streams.reference;
        let first = reference.before.robots as i64;
        let own = |run: &&Run| Some(run.robot as i64 - first) == robot;
        let run = reference.runs.iter().find(own);
        run.map_or(0.0, |run| {
            f64::midpoint(run.blocks.span_s[0], run.blocks.span_s[1])
        })
    }

    /// The latency that all runs share, where each has a clock of its own and they do not differ: parameters of runs,
    /// with their shares in it.
    fn late_in_all(&self, claims: &mut Vec<Claim>, shares: Vec<(usize, f64)>) {
        let table = &self.found.table;
        let Some(machine) = table.find(&Key::of("late gyro", None)) else {
            return;
        };
        let mut weights = vec![(machine, 1.0)];
        for (index, share) in &shares {
            let robot = table.keys[*index].robot;
            weights.push((*index, *share));
            let rate = table.find(&Key::of("run rate", robot));
            weights.extend(rate.map(|rate| (rate, share * self.middle_s(robot))));
        }
        let mut terms = table.terms.iter();
        let Some(term) = terms.find(|term| term.parameters == [machine]) else {
            return;
        };
        let known = self.known(&weights, term);
        let z = known.change / known.deviation.max(f64::MIN_POSITIVE);
        let p_value = self.found.criterion.p_value(z * z, 1);
        if p_value > FALSE_ALARM {
            return;
        }
        for shown in &term.shown {
            let mut value = self.value(&shown.values[0], known);
            self.clock(&mut value, &weights);
            claims.retain(|claim| !claim.toggles.contains(&machine));
            let mut claim = Claim {
                effect: shown.effect,
                values: vec![value],
                word: None,
                runs: None,
                toggles: weights.iter().map(|(index, _)| *index).collect(),
                gain: z * z / 2.0,
                p_value,
                confused: shown.confused.clone(),
                law: None,
            };
            self.mirror(&mut claim, shown);
            claims.push(claim);
        }
    }

    /// Latencies of single runs where they differ.
    pub(super) fn late_runs(&self, claims: &mut Vec<Claim>) {
        let found = self.found;
        let keys = found.table.keys.iter().enumerate();
        let late = keys.filter(|(_, key)| key.name == "run late");
        let late: Vec<(usize, i64)> = late
            .filter_map(|(index, key)| Some((index, key.robot.filter(|own| *own >= 0)?)))
            .collect();
        let selected = &found.selected;
        let read = read(&found.nominal, &found.table.weights, &selected.fit.at);
        let known: Vec<(f64, f64)> = late
            .iter()
            .map(|(index, _)| {
                // a clock that runs fast is later at the end than in the beginning: on the average of the run
                let robot = found.table.keys[*index].robot;
                let rate = found.table.find(&Key::of("run rate", robot));
                let middle_s = self.middle_s(robot);
                let late = [(*index, 1.0)]
                    .into_iter()
                    .chain(rate.map(|rate| (rate, middle_s)));
                let late: Vec<(usize, f64)> = late.collect();
                let change = late
                    .iter()
                    .map(|(i, w)| w * selected.fit.at[*i])
                    .sum::<f64>();
                let deviation = selected.deviation(&late);
                (read[GYRO_LATENCY] + change, deviation.hypot(LATE_S))
            })
            .collect();
        if known.len() < 2 {
            return;
        }
        let weights: f64 = known.iter().map(|(_, s)| s.powi(-2)).sum();
        let mean = known.iter().map(|(x, s)| x / s / s).sum::<f64>() / weights;
        let q: f64 = known.iter().map(|(x, s)| ((x - mean) / s).powi(2)).sum();
        let chance = ChiSquared::new(known.len() as f64 - 1.0).map_or(1.0, |chi2| chi2.sf(q));
        if chance > RUNS_DIFFER {
            let shares = known.iter().map(|(_, s)| s.powi(-2) / weights);
            let shares = late.iter().map(|(index, _)| *index).zip(shares);
            self.late_in_all(claims, shares.collect());
            return;
        }
        let of_clock = ["imu_latency", "wheels_latency"];
        let shared = claims
            .iter()
            .filter(|claim| of_clock.contains(&claim.effect));
        let shared: Vec<usize> = shared.flat_map(|claim| claim.toggles.clone()).collect();
        claims.retain(|claim| !of_clock.contains(&claim.effect));
        for ((index, robot), (change, deviation)) in late.into_iter().zip(known) {
            if found
                .criterion
                .alone()
                .p_value((change / deviation).powi(2), 1)
                > FALSE_ALARM
            {
                continue;
            }
            let reference = self.streams.reference;
            let first = reference.before.robots as i64;
            let run = reference
                .runs
                .iter()
                .position(|run| run.robot as i64 - first == robot);
            let rate = found.table.find(&Key::of("run rate", Some(robot)));
            let (effect, other, sign) = if change < 0.0 {
                ("wheels_latency", "imu_latency", -1.0)
            } else {
                ("imu_latency", "wheels_latency", 1.0)
            };
            let half = found.criterion.half_width() * deviation;
            let mut value = Value::new("latency_s", Link::Identity, change, half);
            self.clock(&mut value, &[(index, 1.0)]);
            value.change *= sign;
            if sign < 0.0 {
                value.half.reverse();
            }
            claims.push(Claim {
                effect,
                values: vec![value],
                word: None,
                runs: run.map(|run| vec![run]),
                toggles: shared.iter().copied().chain([index]).chain(rate).collect(),
                gain: q / 2.0,
                p_value: chance,
                confused: vec![other],
                law: None,
            });
        }
    }
}
