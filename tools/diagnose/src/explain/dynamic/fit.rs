//! A model with its noise, fitted: passes of the filter, noise sizes and parameters in turn.

use rayon::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_sim::effects::{Domain, Info, Role};
use slipstream_sim::{Robot, State};

use super::channels::{deviance, levels};
use super::gauss_newton::{Parameter, Problem};
use super::machine::Machine;
use super::noise_sizes::{Effort, QUICK, Search, THOROUGH};
use crate::filter::dynamic::Noise;
use crate::filter::dynamic::flow::Flow;
use crate::filter::dynamic::gains::Pass;
use crate::filter::dynamic::linear::likelihood;
use crate::filter::dynamic::predictor::innovations;
use crate::model::hypothesis::{Hypothesis, come_round, in_force, slides, with};

/// Longest step of the plant (s), and where wheels can slide or gears have play.
const STEP_S: f64 = 5e-3;
const SHORT_STEP_S: f64 = 2e-3;
/// Multiple of the squares of a fit's innovations beyond which a simulation is given up.
const HOPELESS: f64 = 10.0;
/// Share of the smallest probe of a parameter over which differences begin.
const SMALL: f64 = 0.05;
/// What two integrators of one robot of 1.6 kg differ by: force, moment, creep along, about and across;
/// and with torques of wheels in place of creep.
const FLOOR: [f64; 5] = [5e-4, 2e-5, 1e-5, 1e-4, 1e-5];
const FLOOR_OF_WHEELS: [f64; 5] = [5e-4, 5e-5, 5e-5, 5e-5, 3e-4];
const FLOOR_MASS_KG: f64 = 1.6;
/// Where a search for noise begins.
const NOISE: [f64; 5] = [0.05, 0.002, 1e-3, 3e-3, 1e-3];
const NOISE_OF_WHEELS: [f64; 5] = [0.05, 0.002, 3e-3, 3e-3, 1e-3];
const NOISE_TIME_S: f64 = 0.3;

/// A model with effects, and the noise that goes with it.
#[derive(Clone)]
pub(crate) struct Fit {
    pub(crate) hypotheses: Vec<Hypothesis>,
    pub(crate) noise: Noise,
    pub(crate) passes: Vec<Pass>,
    /// Whitened innovations of all runs.
    pub(crate) whitened: Vec<f64>,
    /// −2 ln L up to a constant.
    pub(crate) deviance: f64,
}

/// Whether wheels can slide.
pub(crate) fn may_slide(model: &RobotModel, hypotheses: &[Hypothesis]) -> bool {
    let known = model
        .effects
        .iter()
        .filter_map(|listed| slipstream_sim::effects::find(&listed.effect));
    known.chain(hypotheses.iter().map(|h| h.info)).any(slides)
}

fn has_play(model: &RobotModel, hypotheses: &[Hypothesis]) -> bool {
    with(model, hypotheses)
        .effects
        .iter()
        .any(|listed| listed.effect == "backlash")
}

/// The parameters of `hypotheses` that are fitted, in their order.
pub(crate) fn values(hypotheses: &[Hypothesis]) -> Vec<f64> {
    let smooth = hypotheses.iter().filter(|h| !h.is_threshold());
    smooth.flat_map(|h| h.values.iter().map(|v| v.1)).collect()
}

/// `hypotheses` with these values.
pub(crate) fn valued(hypotheses: &[Hypothesis], values: &[f64]) -> Vec<Hypothesis> {
    let mut values = values.iter();
    let mut out = hypotheses.to_vec();
    for hypothesis in out.iter_mut().filter(|h| !h.is_threshold()) {
        for (own, value) in hypothesis.values.iter_mut().zip(&mut values) {
            own.1 = come_round(hypothesis.info, own.0, *value);
        }
        hypothesis.keep_in_order();
    }
    out
}

pub(super) fn parameters(hypotheses: &[Hypothesis]) -> Vec<Parameter> {
    let smooth = hypotheses.iter().filter(|h| !h.is_threshold());
    let each = smooth.flat_map(|h| h.values.iter().map(move |(name, _)| (h, *name)));
    let of = |(h, name): (&Hypothesis, &str)| {
        let info = h.info.parameter(name);
        let small = SMALL * least_change(h.info, name);
        match info.map(|p| (p.domain, p.role)) {
            Some((Domain::Number { lower, upper, .. }, role)) if role != Role::Direction => {
                Parameter {
                    lower,
                    upper,
                    small,
                }
            }
            _ => Parameter {
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                small,
            },
        }
    };
    each.map(of).collect()
}

/// The smallest change of a parameter among its probes.
pub(super) fn least_change(info: &Info, name: &str) -> f64 {
    let Some(parameter) = info.parameter(name) else {
        return 1.0;
    };
    let Domain::Number { probes, .. } = parameter.domain else {
        return 1.0;
    };
    let nothing = f64::from(u8::from(parameter.role == Role::Factor));
    let changes = probes.iter().map(|probe| (probe - nothing).abs());
    let least = changes
        .filter(|change| *change > 0.0)
        .fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}

impl Machine {
    /// Adds loads: one for each row of each pass of `fit`, in its order.
    pub(crate) fn add_loads(&mut self, fit: &Fit, loads: &[Vec<[f64; 2]>]) {
        let known = std::mem::take(&mut self.loads);
        for (run, (pass, own)) in fit.passes.iter().zip(loads).enumerate() {
            let known = known.get(run).map_or(&[][..], Vec::as_slice);
            let rows = pass.rows.iter().zip(own);
            self.loads.push(
                rows.map(|(row, [along, about])| {
                    let at = known.partition_point(|(until_s, _)| *until_s < row.true_s - 1e-9);
                    let [x, y] = known.get(at).map_or([0.0; 2], |(_, load)| *load);
                    (row.true_s, [along + x, about + y])
                })
                .collect(),
            );
        }
    }

    /// Floor of the noise of a model.
    pub(crate) fn floor(&self, of_wheels: bool) -> [f64; 5] {
        let body = &self.model.robot;
        let mass_kg = body.body_mass_kg.unwrap_or(FLOOR_MASS_KG);
        let scale = mass_kg / FLOOR_MASS_KG;
        let [surge, yaw, third, fourth, across] = if of_wheels { FLOOR_OF_WHEELS } else { FLOOR };
        let creep = if of_wheels { scale } else { 1.0 };
        [
            surge * scale,
            yaw * scale,
            third * creep,
            fourth * creep,
            across,
        ]
    }

    fn first_noise(&self, of_wheels: bool) -> Noise {
        let size = if of_wheels { NOISE_OF_WHEELS } else { NOISE };
        Noise {
            size,
            time_s: [NOISE_TIME_S; 3],
            of_wheels,
        }
    }

    pub(super) fn robot(&self, hypotheses: &[Hypothesis]) -> Option<Robot> {
        let robot = Robot::new(&with(&self.model, hypotheses)).ok()?;
        Some(robot.draft())
    }

    /// The robot in runs of today, and in those from before.
    fn robots(&self, hypotheses: &[Hypothesis]) -> Option<[Robot; 2]> {
        if self.before == 0 {
            let robot = self.robot(hypotheses)?;
            return Some([robot.clone(), robot]);
        }
        let [today, then] = [true, false].map(|today| self.robot(&in_force(hypotheses, today)));
        Some([today?, then?])
    }

    fn step_s(&self, hypotheses: &[Hypothesis]) -> f64 {
        if may_slide(&self.model, hypotheses) || has_play(&self.model, hypotheses) {
            SHORT_STEP_S
        } else {
            STEP_S
        }
    }

    fn flow<'a>(&'a self, robot: &'a Robot, run: usize, step_s: f64, noise: &Noise) -> Flow<'a> {
        Flow {
            robot,
            run: &self.runs[run],
            step_s,
            of_wheels: noise.of_wheels,
            loads: self.loads.get(run).map_or(&[], Vec::as_slice),
        }
    }

    /// −2 ln L of whitened innovations, but for what does not depend on them.
    pub(crate) fn deviance(&self, whitened: &[f64]) -> f64 {
        deviance(&levels(whitened, &self.channels))
    }

    /// Innovations of `hypotheses` at the gains of `fit`.
    pub(crate) fn innovations(&self, fit: &Fit, hypotheses: &[Hypothesis]) -> Option<Vec<f64>> {
        self.watched(fit, hypotheses, |_, _, _, _| ())
    }

    /// The same; `None` where they are hopelessly large.
    pub(crate) fn promising(&self, fit: &Fit, hypotheses: &[Hypothesis]) -> Option<Vec<f64>> {
        let square: f64 = fit.whitened.iter().map(|e| e * e).sum();
        let most = HOPELESS * (square + self.channels.len() as f64);
        self.within(fit, hypotheses, most, |_, _, _, _| ())
    }

    /// The same; `watch` sees run, time, state and disturbances at every row.
    pub(crate) fn watched(
        &self,
        fit: &Fit,
        hypotheses: &[Hypothesis],
        watch: impl FnMut(usize, f64, &State, &[f64; 5]),
    ) -> Option<Vec<f64>> {
        self.within(fit, hypotheses, f64::INFINITY, watch)
    }

    fn within(
        &self,
        fit: &Fit,
        hypotheses: &[Hypothesis],
        most: f64,
        mut watch: impl FnMut(usize, f64, &State, &[f64; 5]),
    ) -> Option<Vec<f64>> {
        let robots = self.robots(hypotheses)?;
        let step_s = self.step_s(hypotheses);
        let mut all = Vec::with_capacity(self.channels.len());
        for (index, pass) in fit.passes.iter().enumerate() {
            let robot = &robots[usize::from(index < self.before)];
            let flow = self.flow(robot, index, step_s, &fit.noise);
            let watch = |t_s: f64, s: &State, d: &[f64; 5]| watch(index, t_s, s, d);
            all.extend(innovations(&flow, &fit.noise, &pass.gains, most, watch)?);
        }
        Some(all)
    }

    /// Filters all runs.
    pub(crate) fn pass(&self, hypotheses: Vec<Hypothesis>, noise: Noise) -> Option<Fit> {
        let robots = self.robots(&hypotheses)?;
        let step_s = self.step_s(&hypotheses);
        let passes: Option<Vec<Pass>> = (0..self.runs.len())
            .into_par_iter()
            .map(|index| {
                let robot = &robots[usize::from(index < self.before)];
                Pass::new(&self.flow(robot, index, step_s, &noise), &noise)
            })
            .collect();
        let mut fit = Fit {
            hypotheses,
            noise,
            passes: passes?,
            whitened: Vec::new(),
            deviance: f64::INFINITY,
        };
        fit.whitened = fit.own_innovations(self);
        fit.deviance = self.deviance(&fit.whitened) + fit.log_determinant();
        fit.deviance.is_finite().then_some(fit)
    }

    /// Noise sizes anew, then a pass with them, while that gains.
    pub(crate) fn with_noise(&self, mut fit: Fit, rounds: usize, effort: Effort) -> Fit {
        for _ in 0..rounds {
            let (noise, _) = self.search(&fit, &fit.noise, effort);
            if noise == fit.noise {
                break;
            }
            let Some(next) = self.passed_between(&fit, noise) else {
                break;
            };
            let gain = fit.deviance - next.deviance;
            if gain < 0.0 {
                break;
            }
            fit = next;
            if gain < 2.0 {
                break;
            }
        }
        fit
    }

    /// A pass with `noise`, or with what lies between it and that of `fit` where the linear promise
    /// does not hold.
    fn passed_between(&self, fit: &Fit, noise: Noise) -> Option<Fit> {
        let next = self.pass(fit.hypotheses.clone(), noise)?;
        if next.deviance <= fit.deviance + 1.0 {
            return Some(next);
        }
        let middle = Noise {
            size: std::array::from_fn(|i| (noise.size[i] * fit.noise.size[i]).sqrt()),
            time_s: std::array::from_fn(|i| (noise.time_s[i] * fit.noise.time_s[i]).sqrt()),
            of_wheels: noise.of_wheels,
        };
        self.pass(fit.hypotheses.clone(), middle)
    }

    fn search(&self, fit: &Fit, from: &Noise, effort: Effort) -> (Noise, f64) {
        let slides = fit.noise.of_wheels;
        let value = |noise: &Noise| {
            let mut whitened = Vec::with_capacity(self.channels.len());
            let mut log_determinant = 0.0;
            for (index, run) in self.runs.iter().enumerate() {
                let own = likelihood(&fit.passes[index], run, noise);
                whitened.extend(own.whitened);
                log_determinant += own.log_determinant;
            }
            let value = self.deviance(&whitened) + log_determinant;
            if value.is_finite() { value } else { f64::MAX }
        };
        let search = Search {
            floor: self.floor(slides),
            of_wheels: slides,
            has_pose: self.has_pose(),
            deviance: &value,
        };
        search.run(from, effort)
    }

    /// The likelihood in sizes and times has several maxima: the search goes also from a short time.
    pub(crate) fn with_best_noise(&self, fit: Fit) -> Fit {
        let own = self.search(&fit, &fit.noise, THOROUGH);
        let mut short = fit.noise;
        let first = self.first_noise(fit.noise.of_wheels);
        for i in 0..2 {
            short.size[i] = first.size[i];
        }
        short.time_s = [0.1; 3];
        let other = self.search(&fit, &short, THOROUGH);
        let best = if own.1 <= other.1 { own.0 } else { other.0 };
        let next = self.passed_between(&fit, best);
        match next {
            Some(next) if next.deviance < fit.deviance => next,
            _ => fit,
        }
    }

    /// The nominal model with what is known to act, its noise fitted.
    pub(crate) fn nominal(&self, known: &[Hypothesis]) -> Option<Fit> {
        let of_wheels = may_slide(&self.model, known);
        let fit = self.pass(known.to_vec(), self.first_noise(of_wheels))?;
        let fit = self.with_noise(fit, 4, THOROUGH);
        let fit = self.with_best_noise(fit);
        Some(if known.is_empty() {
            fit
        } else {
            self.fitted(fit, 2, 6)
        })
    }

    /// The model of `fit` under small noise that acts on the wheels.
    pub(crate) fn rolling_with_wheel_noise(&self, fit: &Fit) -> Option<Fit> {
        self.pass(fit.hypotheses.clone(), self.first_noise(true))
    }

    /// Begins a fit of fewer effects: what they explained becomes noise again.
    pub(crate) fn begun_anew(&self, fit: &Fit, hypotheses: Vec<Hypothesis>) -> Option<Fit> {
        let of_wheels = may_slide(&self.model, &hypotheses);
        let mut noise = self.first_noise(of_wheels);
        if of_wheels == fit.noise.of_wheels {
            noise.size = std::array::from_fn(|i| noise.size[i].max(fit.noise.size[i]));
        }
        let begun = self.pass(hypotheses, noise)?;
        Some(self.with_noise(begun, 2, THOROUGH))
    }

    /// Begins a fit of `hypotheses` at the noise of `fit`, or at small noise of another kind where
    /// wheels can slide only now.
    pub(crate) fn begun(&self, fit: &Fit, hypotheses: Vec<Hypothesis>) -> Option<Fit> {
        let of_wheels = may_slide(&self.model, &hypotheses);
        if of_wheels == fit.noise.of_wheels {
            return self.pass(hypotheses, fit.noise);
        }
        let begun = self.pass(hypotheses, self.first_noise(of_wheels))?;
        Some(self.with_noise(begun, 2, THOROUGH))
    }

    /// Parameters at fixed gains, then gains and noise, in turn.
    pub(crate) fn fitted(&self, fit: Fit, rounds: usize, iterations: usize) -> Fit {
        let mut fit = fit;
        for _ in 0..rounds {
            let before = fit.deviance;
            let Some(next) = self.stepped(&fit, iterations) else {
                break;
            };
            let next = self.with_thresholds(next);
            let next = self.with_noise(next, 1, QUICK);
            if next.deviance > before {
                break;
            }
            fit = next;
            if fit.deviance > before - 1.0 {
                break;
            }
        }
        fit
    }

    /// Parameters by Gauss-Newton at the gains of `fit`, and a pass with them.
    fn stepped(&self, fit: &Fit, iterations: usize) -> Option<Fit> {
        let at = values(&fit.hypotheses);
        let solution = self.solve(fit, &fit.hypotheses, &at, iterations)?;
        self.pass(valued(&fit.hypotheses, &solution.at), fit.noise)
    }

    /// Gauss-Newton at the gains of `fit` on the parameters of `hypotheses`.
    pub(crate) fn solve(
        &self,
        fit: &Fit,
        hypotheses: &[Hypothesis],
        at: &[f64],
        iterations: usize,
    ) -> Option<super::gauss_newton::Solution> {
        self.solve_on(fit, hypotheses, at, iterations, &self.channels)
    }

    /// The same on what belongs to a channel of `channels`.
    pub(crate) fn solve_on(
        &self,
        fit: &Fit,
        hypotheses: &[Hypothesis],
        at: &[f64],
        iterations: usize,
        channels: &[u8],
    ) -> Option<super::gauss_newton::Solution> {
        let parameters = parameters(hypotheses);
        let innovations = |at: &[f64]| self.innovations(fit, &valued(hypotheses, at));
        let problem = Problem {
            parameters: &parameters,
            channels,
            innovations: &innovations,
        };
        problem.fit(at, None, iterations, 0.5)
    }
}

impl Fit {
    /// Whether it has an effect, in whatever numbers.
    pub(crate) fn has(&self, hypothesis: &Hypothesis) -> bool {
        self.hypotheses
            .iter()
            .any(|known| known.is_like(hypothesis))
    }

    /// −2 ln L's part that does not depend on innovations.
    pub(crate) fn log_determinant(&self) -> f64 {
        let gains = self.passes.iter().flat_map(|pass| &pass.gains);
        gains.map(|gain| gain.log_determinant).sum()
    }

    fn own_innovations(&self, machine: &Machine) -> Vec<f64> {
        let mut all = Vec::with_capacity(machine.channels.len());
        for (run, pass) in machine.runs.iter().zip(&self.passes) {
            let first = all.len();
            all.resize(first + 3 * run.rows.len(), 0.0);
            for row in &pass.rows {
                let at = first + 3 * row.row;
                let whitened = pass.gains[row.row].whitened(&row.innovation);
                all[at..at + 3].copy_from_slice(&whitened);
            }
        }
        all
    }
}
