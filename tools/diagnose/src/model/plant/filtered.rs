//! The runs of a machine as the filter hears them under a model and its noise.

use rayon::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_sim::effects::{Domain, Info, Role};
use slipstream_sim::{Robot, State};

use super::channels::{deviance, levels};
use super::machine::Machine;
use crate::filter::dynamic::Noise;
use crate::filter::dynamic::flow::Flow;
use crate::filter::dynamic::gains::Pass;
use crate::filter::dynamic::predictor::innovations;
use crate::model::hypothesis::{Hypothesis, in_force, slides, with};

/// Longest steps of the plant (s): of wheels that roll, and of wheels that slide or gears that are apart.
pub(crate) const STEPS_S: [f64; 2] = [5e-3, 2e-3];
/// Multiple of the squares of a fit's innovations beyond which a simulation is given up.
const HOPELESS: f64 = 10.0;
/// What two integrators of one robot of 1.6 kg differ by: force, moment, creep along, about and across;
/// and with torques of wheels in place of creep.
const FLOOR: [f64; 5] = [5e-4, 2e-5, 1e-5, 1e-4, 1e-5];
const FLOOR_OF_WHEELS: [f64; 5] = [5e-4, 5e-5, 5e-5, 5e-5, 3e-4];
const FLOOR_MASS_KG: f64 = 1.6;
/// Multiple of its floor below which a disturbance is none, and mean square of innovations that is
/// noise.
const NEGLIGIBLE_DISTURBANCE: f64 = 1.5;
const QUIET_LEVEL: f64 = 1.15;

/// A model with effects, and the noise that goes with it.
#[derive(Clone)]
pub(crate) struct Filtered {
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

/// The parameters of `hypotheses` that are fitted, in their order.
pub(crate) fn values(hypotheses: &[Hypothesis]) -> Vec<f64> {
    let smooth = hypotheses.iter().filter(|h| !h.is_threshold());
    smooth.flat_map(|h| h.values.iter().map(|v| v.1)).collect()
}

/// The smallest change of a parameter among its probes.
pub(crate) fn least_change(info: &Info, name: &str) -> f64 {
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

/// The robot of a model with `hypotheses`, for simulations by the thousand; `None` where there is none.
pub(crate) fn robot(model: &RobotModel, hypotheses: &[Hypothesis]) -> Option<Robot> {
    let robot = Robot::new(&with(model, hypotheses)).ok()?;
    Some(robot.draft())
}

impl Machine {
    /// Adds loads: one for each row of each pass of `fit`, in its order.
    pub(crate) fn add_loads(&mut self, fit: &Filtered, loads: &[Vec<[f64; 2]>]) {
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

    /// The body's mass over that of the robot for which floors are listed.
    pub(super) fn mass_share(&self) -> f64 {
        let own = self.model.robot.body_mass_kg;
        own.unwrap_or(FLOOR_MASS_KG) / FLOOR_MASS_KG
    }

    /// Floor of the noise of a model.
    pub(crate) fn floor(&self, of_wheels: bool) -> [f64; 5] {
        let scale = self.mass_share();
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

    pub(crate) fn robot(&self, hypotheses: &[Hypothesis]) -> Option<Robot> {
        robot(&self.model, hypotheses)
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

    fn flow<'a>(&'a self, robot: &'a Robot, run: usize, noise: &Noise) -> Flow<'a> {
        Flow {
            robot,
            run: &self.runs[run],
            step_s: STEPS_S,
            of_wheels: noise.of_wheels,
            loads: self.loads.get(run).map_or(&[], Vec::as_slice),
        }
    }

    /// Whether no disturbance is left above what integrators differ by, and every channel is at its
    /// noise.
    pub(crate) fn is_silent(&self, fit: &Filtered) -> bool {
        let floor = self.floor(fit.noise.of_wheels);
        let mut told = self.disturbances(fit.noise.of_wheels);
        let quiet = told.all(|i| fit.noise.size[i] < NEGLIGIBLE_DISTURBANCE * floor[i]);
        let levels = levels(&fit.whitened, &self.channels);
        quiet && levels.iter().all(|[mean, _]| *mean < QUIET_LEVEL)
    }

    /// Numbers of the disturbances that its runs tell: without a place, none across and no creep. Where wheels may slide both
    /// have one torque.
    pub(crate) fn disturbances(&self, of_wheels: bool) -> impl Iterator<Item = usize> {
        let has_pose = self.has_pose();
        let told = move |i: &usize| has_pose || *i < 2 || of_wheels && *i == 2;
        (0..5).filter(move |i| told(i) && !(of_wheels && *i == 3))
    }

    /// −2 ln L of whitened innovations, but for what does not depend on them.
    pub(crate) fn deviance(&self, whitened: &[f64]) -> f64 {
        deviance(&levels(whitened, &self.channels))
    }

    /// Innovations of `hypotheses` at the gains of `fit`.
    pub(crate) fn innovations(
        &self,
        fit: &Filtered,
        hypotheses: &[Hypothesis],
    ) -> Option<Vec<f64>> {
        self.watched(fit, hypotheses, |_, _, _, _| ())
    }

    /// The same; `None` where they are hopelessly large.
    pub(crate) fn bounded_innovations(
        &self,
        fit: &Filtered,
        hypotheses: &[Hypothesis],
    ) -> Option<Vec<f64>> {
        let square: f64 = fit.whitened.iter().map(|e| e * e).sum();
        let most = HOPELESS * (square + self.channels.len() as f64);
        self.within(fit, hypotheses, most, |_, _, _, _| ())
    }

    /// The same; `watch` sees run, time, state and disturbances at every row.
    pub(crate) fn watched(
        &self,
        fit: &Filtered,
        hypotheses: &[Hypothesis],
        watch: impl FnMut(usize, f64, &State, &[f64; 5]),
    ) -> Option<Vec<f64>> {
        self.within(fit, hypotheses, f64::INFINITY, watch)
    }

    fn within(
        &self,
        fit: &Filtered,
        hypotheses: &[Hypothesis],
        most: f64,
        mut watch: impl FnMut(usize, f64, &State, &[f64; 5]),
    ) -> Option<Vec<f64>> {
        let robots = self.robots(hypotheses)?;
        let mut all = Vec::with_capacity(self.channels.len());
        for (index, pass) in fit.passes.iter().enumerate() {
            let robot = &robots[usize::from(index < self.before)];
            let flow = self.flow(robot, index, &fit.noise);
            let watch = |t_s: f64, s: &State, d: &[f64; 5]| watch(index, t_s, s, d);
            all.extend(innovations(&flow, &fit.noise, &pass.gains, most, watch)?);
        }
        Some(all)
    }

    /// Filters all runs.
    pub(crate) fn pass(&self, hypotheses: Vec<Hypothesis>, noise: Noise) -> Option<Filtered> {
        let robots = self.robots(&hypotheses)?;
        let passes: Option<Vec<Pass>> = (0..self.runs.len())
            .into_par_iter()
            .map(|index| {
                let robot = &robots[usize::from(index < self.before)];
                Pass::new(&self.flow(robot, index, &noise), &noise)
            })
            .collect();
        let mut fit = Filtered {
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
}

impl Filtered {
    /// Its effects and one more.
    pub(crate) fn beside(&self, own: &Hypothesis) -> Vec<Hypothesis> {
        let mut all = self.hypotheses.clone();
        all.push(own.clone());
        all
    }

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
