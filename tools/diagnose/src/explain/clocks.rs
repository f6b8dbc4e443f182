//! Latencies: their intervals, and those of single runs where each has a clock of its own.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::claim::{Claim, Value};
use super::naming::Naming;
use super::several_maxima::widen;
use crate::estimate::term::Link;
use crate::model::run::Run;
use crate::model::streams::read;
use crate::model::table::Key;
use crate::model::wheel_parameters::GYRO_LATENCY;
use crate::select::criterion::FALSE_ALARM;

/// Parameters that are clocks.
const CLOCKS: [&str; 2] = ["latency_s", "delay_s"];
/// Clocks of runs differ when the probability of their spread without a difference is below this; and by which
/// nobody would call it one (s).
const RUNS_DIFFER: f64 = 1e-3;
const LATE_S: f64 = 0.01;

/// The latency of a run with a clock of its own: its parameter, the robot's number among those that are diagnosed.
struct ClockOfRun {
    index: usize,
    robot: i64,
    latency_s: f64,
    deviation_s: f64,
}

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

    /// Latencies of the runs that have a clock of their own.
    fn clocks_of_runs(&self) -> Vec<ClockOfRun> {
        let (table, selected) = (&self.found.table, &self.found.selected);
        let read = read(&self.found.nominal, &table.weights, &selected.fit.at);
        let keys = table.keys.iter().enumerate();
        let late = keys.filter(|(_, key)| key.name == "run late");
        late.filter_map(|(index, key)| {
            let robot = key.robot.filter(|own| *own >= 0)?;
            // a clock that runs fast is later at the end than in the beginning: on the average of the run
            let rate = table.find(&Key::of("run rate", key.robot));
            let mut weights = vec![(index, 1.0)];
            weights.extend(rate.map(|rate| (rate, self.middle_s(key.robot))));
            let all = weights.iter();
            let change: f64 = all.map(|(i, w)| w * selected.fit.at[*i]).sum();
            Some(ClockOfRun {
                index,
                robot,
                latency_s: read[GYRO_LATENCY] + change,
                deviation_s: selected.deviation(&weights).hypot(LATE_S),
            })
        })
        .collect()
    }

    /// Latencies of single runs where they differ.
    pub(super) fn late_runs(&self, claims: &mut Vec<Claim>) {
        let clocks = self.clocks_of_runs();
        if clocks.len() < 2 {
            return;
        }
        let weight = |own: &ClockOfRun| own.deviation_s.powi(-2);
        let weights: f64 = clocks.iter().map(weight).sum();
        let shares = clocks.iter().map(|own| weight(own) / weights);
        let shares: Vec<f64> = shares.collect();
        let both = clocks.iter().zip(&shares);
        let mean: f64 = both.map(|(own, share)| share * own.latency_s).sum();
        let q: f64 = clocks
            .iter()
            .map(|own| weight(own) * (own.latency_s - mean).powi(2))
            .sum();
        let chance = ChiSquared::new(clocks.len() as f64 - 1.0).map_or(1.0, |chi2| chi2.sf(q));
        if chance > RUNS_DIFFER {
            let indices = clocks.iter().map(|own| own.index);
            self.late_in_all(claims, indices.zip(shares).collect());
            return;
        }
        let of_clock = |claim: &Claim| ["imu_latency", "wheels_latency"].contains(&claim.effect);
        let shared = claims.iter().filter(|claim| of_clock(claim));
        let shared: Vec<usize> = shared.flat_map(|claim| claim.toggles.clone()).collect();
        claims.retain(|claim| !of_clock(claim));
        let alone = self.found.criterion.alone();
        let clear = clocks.iter().filter(|own| {
            alone.p_value((own.latency_s / own.deviation_s).powi(2), 1) <= FALSE_ALARM
        });
        claims.extend(clear.map(|own| self.late_run(own, &shared, [q, chance])));
    }

    /// The claim of a run whose latency differs from that of others, with the statistic of their differences and its
    /// probability; `shared` are parameters of the latency that all have.
    fn late_run(&self, own: &ClockOfRun, shared: &[usize], [q, chance]: [f64; 2]) -> Claim {
        let reference = self.streams.reference;
        let first = reference.before.robots as i64;
        let mut runs = reference.runs.iter();
        let run = runs.position(|run| run.robot as i64 - first == own.robot);
        let rate = self.found.table.find(&Key::of("run rate", Some(own.robot)));
        let half = self.found.criterion.half_width() * own.deviation_s;
        let mut value = Value::new("latency_s", Link::Identity, own.latency_s, half);
        self.clock(&mut value, &[(own.index, 1.0)]);
        let mut effects = ["imu_latency", "wheels_latency"];
        if own.latency_s < 0.0 {
            effects.reverse();
            value.negate();
        }
        let toggles = shared.iter().copied().chain([own.index]).chain(rate);
        Claim {
            effect: effects[0],
            values: vec![value],
            word: None,
            runs: run.map(|run| vec![run]),
            toggles: toggles.collect(),
            gain: q / 2.0,
            p_value: chance,
            confused: vec![effects[1]],
            law: None,
        }
    }
}
