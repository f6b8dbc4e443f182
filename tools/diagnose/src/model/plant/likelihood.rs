//! The likelihood of the runs of a robot whose masses are known.
//!
//! Derivatives by what acts on the robot are differences of simulations at the gains of a pass; those by noise
//! are differences of the filter that is linear about it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::channels::{levels, precisions};
use super::filtered::{Filtered, may_slide};
use super::machine::Machine;
use super::table::Table;
use crate::estimate::blocks::{self, Blocks};
use crate::estimate::information::empty;
use crate::estimate::term::Term;
use crate::estimate::{BlockScore, Likelihood, Near};
use crate::filter::dynamic::Noise;
use crate::filter::dynamic::linear::likelihood;

/// Passes that are kept: a fit asks for the value of parameters and then for their score.
const KEPT: usize = 8;
/// Change of a parameter by which a simulation is differentiated, in the smallest expected size.
const STEP: f64 = 0.05;
/// The same where the likelihood has kinks, in standard deviations; and how far it may go.
const STEP_SHARE: f64 = 0.3;
const STEPS: [f64; 2] = [1e-4, 0.5];
/// Change of the log of a noise size.
const NOISE_STEP: f64 = 1e-3;
/// Numbers of a row: whitened innovation, and the lower half of what whitens a change of its covariance.
const WIDTH: usize = 9;

/// The likelihood of the runs of a machine, on the parameters of a table.
pub(crate) struct Plant<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) table: &'a Table,
    blocks: Vec<Blocks>,
    /// Block of each row.
    block_of: Vec<usize>,
    kept: Mutex<VecDeque<Kept>>,
}

type Kept = (Vec<f64>, Option<Arc<Filtered>>);

/// Derivatives by one parameter.
struct DerivativeColumn {
    /// Of the log-likelihood of each block.
    score: Vec<f64>,
    /// Whitened, row after row: [`WIDTH`] numbers each, three where only the innovation moves.
    whitened: Vec<f64>,
    width: usize,
}

impl<'a> Plant<'a> {
    pub(crate) fn new(machine: &'a Machine, table: &'a Table) -> Self {
        let blocks = machine.blocks();
        let rows = machine.stamps.iter().step_by(3);
        let of = |(stamp_s, run): &(f64, usize)| blocks[*run].first + blocks[*run].of(*stamp_s);
        Self {
            block_of: rows.map(of).collect(),
            machine,
            table,
            blocks,
            kept: Mutex::default(),
        }
    }

    /// The filter at these parameters; `None` where no robot has them, or it does not hold it.
    pub(crate) fn filtered(&self, at: &[f64]) -> Option<Arc<Filtered>> {
        let known = |kept: &VecDeque<Kept>| {
            let mut all = kept.iter();
            all.find(|(own, _)| own == at)
                .map(|(_, filtered)| filtered.clone())
        };
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = known(&lock()) {
            return own;
        }
        let hypotheses = self.table.hypotheses(at);
        let of_wheels = may_slide(&self.machine.model, &hypotheses);
        let noise = self.noise(at, of_wheels);
        let filtered = self.machine.pass(hypotheses, noise).map(Arc::new);
        let mut kept = lock();
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back((at.to_vec(), filtered.clone()));
        filtered
    }

    pub(crate) fn noise(&self, at: &[f64], of_wheels: bool) -> Noise {
        self.machine.noise(self.table.of_noise(at), of_wheels)
    }

    /// Log-likelihood of each block, of innovations that were whitened by the gains of `base`.
    fn by_block(&self, base: &Filtered, whitened: &[f64]) -> Vec<f64> {
        let levels = levels(whitened, &self.machine.channels).map(|[mean, _]| mean.max(1.0));
        let mut out = vec![0.0; self.blocks()];
        let rows = whitened.chunks(3).zip(self.machine.channels.chunks(3));
        for ((row, channels), block) in rows.zip(&self.block_of) {
            for (e, channel) in row.iter().zip(channels) {
                if let Some(level) = levels.get(usize::from(*channel)) {
                    out[*block] -= 0.5 * (e * e / level + level.ln());
                }
            }
        }
        let gains = base.passes.iter().flat_map(|pass| &pass.gains);
        for (gain, block) in gains.zip(&self.block_of) {
            out[*block] -= 0.5 * gain.log_determinant;
        }
        out
    }

    /// Log-likelihood of each block at the gains of `base`.
    fn at_gains(&self, base: &Filtered, at: &[f64]) -> Vec<f64> {
        match self
            .machine
            .bounded_innovations(base, &self.table.hypotheses(at))
        {
            Some(e) => self.by_block(base, &e),
            None => self.impossible(),
        }
    }

    /// The log-likelihood where no robot has such parameters.
    fn impossible(&self) -> Vec<f64> {
        vec![f64::NEG_INFINITY; self.blocks()]
    }

    /// By a parameter of an effect, at the gains of `base`; `here` are the innovations at `at`.
    fn by_effect(
        &self,
        base: &Filtered,
        here: &[f64],
        at: &[f64],
        index: usize,
    ) -> DerivativeColumn {
        let precisions = precisions(here, &self.machine.channels);
        let slopes = |step: f64| {
            let moved = |step: f64| {
                let mut moved = at.to_vec();
                moved[index] += step;
                self.machine
                    .innovations(base, &self.table.hypotheses(&moved))
            };
            // away from where no robot has it, or where it changes nothing
            let (e, step) = match moved(step) {
                Some(e) if e != here => (e, step),
                _ => (moved(-step)?, -step),
            };
            let pairs = e.iter().zip(here).zip(&precisions);
            let slopes = pairs.map(|((after, before), p)| (after - before) / step * p.sqrt());
            Some(slopes.collect::<Vec<f64>>())
        };
        let mut whitened = slopes(STEP);
        if self.table.is_abrupt(index)
            && let Some(own) = &whitened
        {
            let square: f64 = own.iter().map(|x| x * x).sum();
            let [least, most] = STEPS;
            let deviation = square.max(1e-300).sqrt().recip();
            whitened = slopes((STEP_SHARE * deviation).clamp(least, most)).or(whitened);
        }
        let whitened = whitened.unwrap_or_else(|| vec![0.0; here.len()]);
        let mut score = vec![0.0; self.blocks()];
        let rows = whitened.chunks(3).zip(here.chunks(3));
        for (((slope, e), p), block) in rows.zip(precisions.chunks(3)).zip(&self.block_of) {
            score[*block] -= (0..3).map(|i| slope[i] * e[i] * p[i].sqrt()).sum::<f64>();
        }
        DerivativeColumn {
            score,
            whitened,
            width: 3,
        }
    }

    /// Score and information of each block, of these derivatives.
    fn summed(&self, columns: &[DerivativeColumn]) -> Vec<BlockScore> {
        let mut out = empty(self.blocks(), columns.len());
        for (i, column) in columns.iter().enumerate() {
            for (block, own) in out.iter_mut().zip(&column.score) {
                block.gradient[i] = *own;
            }
        }
        for (row, block) in self.block_of.iter().enumerate() {
            let own = &mut out[*block].information;
            for (i, a) in columns.iter().enumerate() {
                let x = &a.whitened[a.width * row..a.width * (row + 1)];
                for (k, b) in columns.iter().enumerate().take(i + 1) {
                    let y = &b.whitened[b.width * row..b.width * (row + 1)];
                    own[(i, k)] += x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
                }
            }
        }
        for block in &mut out {
            block.information.fill_upper_triangle_with_lower_triangle();
        }
        out
    }

    /// By a noise parameter.
    fn by_noise(&self, base: &Filtered, at: &[f64], index: usize) -> DerivativeColumn {
        let precisions = precisions(&base.whitened, &self.machine.channels);
        let mut moved = at.to_vec();
        moved[index] += NOISE_STEP;
        let noise = self.noise(&moved, base.noise.of_wheels);
        let mut score = vec![0.0; self.blocks()];
        let mut whitened = Vec::with_capacity(3 * base.whitened.len());
        let mut place = 0;
        if noise == base.noise {
            whitened.resize(3 * base.whitened.len(), 0.0);
            return DerivativeColumn {
                score,
                whitened,
                width: WIDTH,
            };
        }
        for (run, pass) in self.machine.runs.iter().zip(&base.passes) {
            let other = likelihood(pass, run, &noise);
            for (row, gain) in pass.gains.iter().enumerate() {
                let own = &base.whitened[3 * place..3 * place + 3];
                let p = &precisions[3 * place..3 * place + 3];
                let e = &other.whitened[3 * row..3 * row + 3];
                let moved: f64 = (0..3).map(|i| (e[i] * e[i] - own[i] * own[i]) * p[i]).sum();
                let after = other.log_determinants[row];
                let change = moved + after - gain.log_determinant;
                score[self.block_of[place]] -= 0.5 * change / NOISE_STEP;
                let numbers = relative(&gain.whitening, &other.whitening[row], e, own);
                for (i, number) in numbers.iter().enumerate() {
                    let p = if i < 3 {
                        p[i].sqrt()
                    } else {
                        f64::from(u8::from(p.iter().any(|p| *p > 0.0)))
                    };
                    whitened.push(number / NOISE_STEP * p);
                }
                place += 1;
            }
        }
        DerivativeColumn {
            score,
            whitened,
            width: WIDTH,
        }
    }
}

/// Change of an innovation, whitened by the gains of before, and the lower half of L⁻¹ (S' − S) L⁻ᵀ / √2, what
/// stands beside the diagonal √2 times. `before` and `after` are inverse Cholesky factors.
fn relative(before: &[[f64; 3]; 3], after: &[[f64; 3]; 3], e: &[f64], own: &[f64]) -> [f64; WIDTH] {
    use std::f64::consts::FRAC_1_SQRT_2;
    // L⁻¹ L', lower triangular, from before = L⁻¹ and after = L'⁻¹
    let mut m = [[0.0; 3]; 3];
    for i in 0..3 {
        for k in (0..=i).rev() {
            let known: f64 = (k + 1..=i).map(|j| m[i][j] * after[j][k]).sum();
            m[i][k] = if after[k][k] == 0.0 {
                f64::from(u8::from(i == k))
            } else {
                (before[i][k] - known) / after[k][k]
            };
        }
    }
    let mut out = [0.0; WIDTH];
    for i in 0..3 {
        out[i] = (0..=i).map(|k| m[i][k] * e[k]).sum::<f64>() - own[i];
    }
    let mut place = 3;
    for i in 0..3 {
        for k in 0..=i {
            let s: f64 = (0..=k).map(|j| m[i][j] * m[k][j]).sum();
            out[place] = if i == k { (s - 1.0) * FRAC_1_SQRT_2 } else { s };
            place += 1;
        }
    }
    out
}

impl Likelihood for Plant<'_> {
    fn blocks(&self) -> usize {
        blocks::total(self.blocks.iter().copied())
    }

    fn run_of(&self) -> Vec<usize> {
        blocks::run_of(self.blocks.iter().copied())
    }

    fn is_shared(&self, _: usize) -> bool {
        true
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        match self.filtered(at) {
            Some(own) => self.by_block(&own, &own.whitened),
            None => self.impossible(),
        }
    }

    fn near<'a>(&'a self, at: &[f64]) -> Near<'a> {
        let base = self.filtered(at);
        Box::new(move |other| match &base {
            Some(base) => self.at_gains(base, other),
            None => self.impossible(),
        })
    }

    fn located(&self, term: &Term, at: &[f64], rival: &[f64]) -> Vec<Vec<f64>> {
        self.places(term, at, rival)
    }

    fn refined(&self, term: &Term, at: &[f64]) -> Option<Vec<f64>> {
        let own = self.table.starts(term).first()?;
        own.is_placed()
            .then(|| self.at_its_gains(self.refined_patch(at)))
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let Some(base) = self.filtered(at) else {
            return empty(self.blocks(), free.len());
        };
        let columns = free.par_iter().map(|index| {
            if self.table.is_noise(*index) {
                self.by_noise(&base, at, *index)
            } else {
                self.by_effect(&base, &base.whitened, at, *index)
            }
        });
        self.summed(&columns.collect::<Vec<DerivativeColumn>>())
    }
}

/// The likelihood at the gains of one pass, on what acts on the robot alone: where wheels slide, gains depend on it in
/// ways that no derivative tells.
pub(crate) struct AtGains<'a> {
    pub(crate) plant: &'a Plant<'a>,
    pub(crate) base: &'a Filtered,
}

impl Likelihood for AtGains<'_> {
    fn blocks(&self) -> usize {
        self.plant.blocks()
    }

    fn run_of(&self) -> Vec<usize> {
        self.plant.run_of()
    }

    fn is_shared(&self, _: usize) -> bool {
        true
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        self.plant.at_gains(self.base, at)
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let own = self.plant.table.hypotheses(at);
        let Some(here) = self.plant.machine.bounded_innovations(self.base, &own) else {
            return empty(self.blocks(), free.len());
        };
        let columns = free.par_iter();
        let columns = columns.map(|index| self.plant.by_effect(self.base, &here, at, *index));
        self.plant
            .summed(&columns.collect::<Vec<DerivativeColumn>>())
    }
}

impl Machine {
    /// The blocks of each run.
    pub(crate) fn blocks(&self) -> Vec<Blocks> {
        let mut all: Vec<Blocks> = Vec::new();
        for run in &self.runs {
            let stamps = run.rows.iter().map(|row| row.stamp_s);
            let from_s = stamps.clone().fold(f64::INFINITY, f64::min);
            let to_s = stamps.fold(f64::NEG_INFINITY, f64::max);
            let first = all.last().map_or(0, Blocks::end);
            all.push(Blocks::new([from_s, to_s], first));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::estimate::scoring::summed;
    use crate::model::hypothesis;
    use crate::predict::fixture;

    #[test]
    fn the_score_is_the_slope_of_the_value() {
        let truth = RobotModel::default().with("viscous_drag", &[("coefficient", 0.3)]);
        let track = fixture::driven(&truth, 8.0, fixture::gentle);
        let tracks = [track.clone()];
        let machine = Machine::new(vec![track], RobotModel::default(), &[]);
        let all = hypothesis::all(&machine.model, &tracks, &[]);
        let table = Table::new(&machine, &all, &[]);
        let plant = Plant::new(&machine, &table);
        let term = |name: &str| table.terms.iter().find(|term| term.name == name).unwrap();
        let drag = term("viscous_drag").parameters[0];
        let mut at = table.start.clone();
        at[drag] = 1.0;
        let free = [drag, table.told[0], table.told[1]];
        let value = |at: &[f64]| plant.value(at).iter().sum::<f64>();
        let (gradient, information) = summed(&plant.score(&at, &free), free.len());
        for (place, index) in free.iter().enumerate() {
            let moved = |by: f64| {
                let mut moved = at.clone();
                moved[*index] += by;
                value(&moved)
            };
            let slope = (moved(1e-3) - moved(-1e-3)) / 2e-3;
            // the filter is linear about its pass, and its gains do not move with what acts on the robot
            let scale = slope.abs().max(information[(place, place)].sqrt());
            assert!(
                (gradient[place] - slope).abs() < 0.05 * scale,
                "{index} {} {slope}",
                gradient[place]
            );
        }
    }

    #[test]
    fn an_effect_keeps_its_numbers_through_the_table() {
        let model = RobotModel::default();
        let track = fixture::driven(&model, 4.0, fixture::gentle);
        let tracks = [track.clone()];
        let machine = Machine::new(vec![track], model, &[]);
        let all = hypothesis::all(&machine.model, &tracks, &[]);
        let table = Table::new(&machine, &all, &[]);
        assert!(table.hypotheses(&table.start).is_empty());
        for own in all.iter().filter(|own| own.info.id != "encoder_scale") {
            let at = table.with(&table.start, own);
            let back = table.hypotheses(&at);
            let unchanged = back.is_empty();
            for ((name, value), (_, same)) in own
                .values
                .iter()
                .zip(back.iter().flat_map(|own| &own.values))
            {
                let off = (value - same).abs();
                assert!(
                    off < 1e-9 * value.abs().max(1.0),
                    "{} {name}: {value} {same}",
                    own.info.id
                );
            }
            let nothing = own
                .values
                .iter()
                .all(|(name, value)| *value == own.nothing(&machine.model, name));
            assert_eq!(unchanged, nothing, "{}", own.info.id);
        }
    }
}
