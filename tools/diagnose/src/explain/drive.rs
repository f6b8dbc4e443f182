//! What a drive does with its commands: a fit with every term, from several starts, then backward
//! elimination.

use slipstream_bus::RobotModel;

use super::drive_terms::DEAD_ZONE_SHARE;
use super::drive_terms::terms_of;
use super::open_loop::drive_error;
use super::term::{
    CLOCK_TERM, DELAY_TERM, GAIN_TERM, LAG_TERM, RATE_NATS, SATURATION_TERM, USE_SHARE, ZONE_TERM,
};
use super::thresholds::{Thresholds, levels};
use crate::estimate::blocks;
use crate::estimate::scoring::{FULL, Fit, Problem, SearchLimits};
use crate::model::command_to_wheels::{CommandToWheels, Plain};
use crate::model::drive::{
    DEAD_BAND, DEAD_ZONE, DELAY, DRIVE, GAIN, GAIN_ASYMMETRY, LAG, SATURATION, SLOW_SHARE,
    SLOW_TIME,
};
use crate::select::criterion::Criterion;
use crate::select::elimination::{Elimination, Selected, Shared, Term};

/// The first fits need not be finished.
const ROUGH: SearchLimits = SearchLimits {
    iterations: 15,
    tolerance_nats: 0.5,
};
/// Delays from which the search starts (s).
const DELAYS_S: [f64; 9] = [0.0, 0.01, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3];
/// Lag from which it starts (s).
const LAGS_S: [f64; 2] = [0.02, 0.15];
/// Slow share of runs from before that have none.
const LEAST_SLOW: f64 = 1e-3;
/// Commands above this share of the largest are one speed.
const ONE_SPEED: f64 = 0.98;
/// Slow share from which it starts.
const SLOW_START: f64 = 0.05;
/// What was found of a drive.
pub(crate) struct DriveFit {
    pub(crate) after: Selected,
    pub(crate) nominal: Vec<f64>,
    pub(crate) criterion: Criterion,
    /// Ends of the interval in which a dead band cannot be told apart (rad/s).
    pub(crate) band_rad_s: [f64; 2],
    /// The fit beside runs from before, of which this is today's part.
    pub(crate) joint: Option<Box<DriveFit>>,
}

/// What a drive shared from before on is fitted with whatever changed.
fn shared(drive: &CommandToWheels, nominal: &[f64]) -> Vec<usize> {
    if !drive.before.any() {
        return Vec::new();
    }
    let always = [DELAY, GAIN, GAIN_ASYMMETRY, SLOW_SHARE, SLOW_TIME];
    let all = (0..DRIVE).filter(|i| *i != DEAD_BAND);
    let shared = all.map(|i| (i, CommandToWheels::shared(i)));
    let had = shared.filter(|(i, at)| always.contains(i) || nominal[*at] != 0.0);
    had.map(|(_, at)| at).collect()
}

struct Search<'a> {
    drive: &'a CommandToWheels,
    problem: Problem<'a>,
    /// The same without outliers.
    plain: Problem<'a>,
    nominal: Vec<f64>,
    /// What is shared with runs from before.
    shared: Vec<usize>,
    noise: Vec<usize>,
}

impl DriveFit {
    /// Fits a drive; `None` where the data do not allow it.
    pub(crate) fn new(
        drive: &CommandToWheels,
        model: &RobotModel,
        excluded: &[String],
        before: Option<&DriveFit>,
    ) -> Option<Self> {
        let mut nominal = drive.nominal(model);
        let shared = shared(drive, &nominal);
        if let Some(before) = before {
            let known = &before.after.fit.at;
            let base = CommandToWheels::shared(0);
            nominal[base..base + DRIVE].copy_from_slice(&known[..DRIVE]);
            nominal[DRIVE..base].copy_from_slice(&known[DRIVE..base]);
            let slow = &mut nominal[CommandToWheels::shared(SLOW_SHARE)];
            if *slow == 0.0 {
                // at 0 it has no derivative by its time
                *slow = LEAST_SLOW;
            }
        }
        let plain = Plain(drive);
        let search = Search {
            drive,
            problem: drive.problem(drive, &nominal),
            plain: drive.problem(&plain, &nominal),
            nominal,
            shared,
            noise: drive.noise(),
        };
        search.run(excluded)
    }
}

impl Search<'_> {
    fn run(self, excluded: &[String]) -> Option<DriveFit> {
        let mut terms = terms_of(self.drive, excluded);
        let (full, band_rad_s) = self.full(&mut terms);
        let useful = |with: &Fit, without: &Fit| {
            drive_error(self.drive, &with.at)
                < (1.0 - USE_SHARE) * drive_error(self.drive, &without.at)
        };
        let mut elimination = self.elimination(&terms, &useful);
        let after = elimination.settled(full, &mut terms)?;
        let after = elimination.rivals(after, [DELAY_TERM, LAG_TERM], &terms)?;
        let before = &self.drive.before;
        let runs = self.drive.runs.iter().take(before.runs);
        let first = blocks::total(runs.map(|run| run.blocks));
        let after = elimination.halved(after, before.is_paired(), first);
        let after = self.with_one_speed(after);
        let criterion = elimination.criterion;
        Some(DriveFit {
            after,
            nominal: self.nominal,
            criterion,
            band_rad_s,
            joint: None,
        })
    }

    /// At one commanded speed a loss of a constant size is a gain.
    fn with_one_speed(&self, mut after: Selected) -> Selected {
        let today = self.drive.runs.iter().skip(self.drive.before.runs);
        let levels = levels(today.map(|run| &run.commands));
        let ends = levels.first().zip(levels.last());
        if ends.is_none_or(|(least, most)| *least < ONE_SPEED * most) {
            return after;
        }
        let both = [[GAIN_TERM, ZONE_TERM], [ZONE_TERM, GAIN_TERM]];
        let kept = |own: &[&str; 2]| own.map(|name| after.kept(name).is_some()) == [true, false];
        let alike: Vec<[&'static str; 2]> = both.into_iter().filter(kept).collect();
        after.alike.extend(alike);
        after
    }

    fn elimination<'b>(
        &'b self,
        terms: &[Term],
        useful: &'b dyn Fn(&Fit, &Fit) -> bool,
    ) -> Elimination<'b> {
        Elimination {
            shared: self.drive.before.any().then(|| Shared {
                first: CommandToWheels::shared(0),
                count: DRIVE,
            }),
            problem: &self.problem,
            neutral: &self.nominal,
            always: self.shared.clone(),
            noise: &self.noise,
            criterion: Criterion::of(self.problem.likelihood, terms.len()),
            useful,
        }
    }

    /// The noise sizes of the nominal model: the better of two maxima.
    fn noise_alone(&self, problem: &Problem<'_>) -> Fit {
        let mut quick = self.nominal.clone();
        for (index, shift) in self.noise.iter().zip([-1.5, 1.5, 0.0, -1.5, 1.5]) {
            quick[*index] += shift;
        }
        let one = problem.fit(&self.nominal, &self.noise, FULL);
        let other = problem.fit(&quick, &self.noise, FULL);
        if other.objective > one.objective {
            other
        } else {
            one
        }
    }

    fn free(&self, names: &[&str], terms: &[Term]) -> Vec<usize> {
        let own = terms
            .iter()
            .filter(|t| names.contains(&t.name) && !t.by_profile);
        let physics = own.flat_map(|t| t.parameters.iter().copied());
        physics.chain(self.noise.iter().copied()).collect()
    }

    /// The fit with all of `terms`, those taken out that are not there even so; and the interval of the
    /// dead band.
    fn full(&self, terms: &mut Vec<Term>) -> (Fit, [f64; 2]) {
        let first = self.first(terms);
        let stamped = self.as_stamped(&first, terms);
        let first = match stamped {
            Some(other) if other.objective > first.objective => other,
            _ => first,
        };
        let names: Vec<&str> = terms
            .iter()
            .map(|t| t.name)
            .filter(|name| ![SATURATION_TERM, CLOCK_TERM].contains(name))
            .collect();
        let mut at = first.at.clone();
        if at[DEAD_ZONE] == 0.0 {
            at[DEAD_ZONE] = DEAD_ZONE_SHARE * self.drive.largest_rad_s;
        }
        if !self.drive.before.any() {
            at[SLOW_SHARE] = SLOW_START;
        }
        let mut best = self.problem.fit(&at, &self.free(&names, terms), FULL);
        if !self.shared.is_empty() {
            let free = [&self.shared, best.free.as_slice()].concat();
            best = self.problem.fit(&best.at, &free, FULL);
        }
        let thresholds = Thresholds {
            problem: &self.problem,
            first: 0,
            top_rad_s: self.drive.largest_rad_s,
            levels_rad_s: levels(self.drive.runs.iter().map(|run| &run.commands)),
            known: self.drive.before.any().then(|| {
                [SATURATION, DEAD_BAND].map(|i| self.nominal[CommandToWheels::shared(i)] != 0.0)
            }),
        };
        best = thresholds.saturated(best, terms);
        let (mut best, band_rad_s) = thresholds.banded(best, terms);
        let own = self.free(&[CLOCK_TERM], terms);
        let mut free: Vec<usize> = best.free.clone();
        free.retain(|i| !own.contains(i));
        free.extend(own);
        let rated = self.problem.fit(&best.at, &free, FULL);
        if rated.objective - best.objective > RATE_NATS {
            best = rated;
        } else {
            terms.retain(|t| t.name != CLOCK_TERM);
        }
        (best, band_rad_s)
    }

    /// Delay and gain from a delay that changed as the stamps of rows did that two recordings of one course
    /// have in common.
    fn as_stamped(&self, first: &Fit, terms: &[Term]) -> Option<Fit> {
        let before = &self.drive.before;
        let mut at = before.is_paired().then(|| self.nominal.clone())?;
        at[DELAY] += before.stamped[0][0];
        let free = self.free(&[DELAY_TERM, GAIN_TERM], terms);
        let fit = self.problem.fit(&at, &free, FULL);
        Some(self.problem.fit(&fit.at, &first.free, FULL))
    }

    /// Delay, lag and gain: the better of the search among outliers and of the one that begins without.
    /// Whether a row is an outlier is asked of the model that fits best, not of the nominal one.
    fn first(&self, terms: &[Term]) -> Fit {
        let own = self.response(&self.problem, terms);
        let plain = self.response(&self.plain, terms);
        let grown = self.problem.fit(&plain.at, &own.free, FULL);
        if grown.objective > own.objective {
            grown
        } else {
            own
        }
    }

    /// Delay, lag and gain from several starts.
    fn response(&self, problem: &Problem<'_>, terms: &[Term]) -> Fit {
        let free = self.free(&[DELAY_TERM, LAG_TERM, GAIN_TERM], terms);
        let mut before = self.noise_alone(problem);
        if !self.drive.before.any() && has_term(terms, GAIN_TERM) {
            before.at[GAIN] += self.drive.crude_gain;
        }
        let gained = problem.fit(&before.at, &self.free(&[GAIN_TERM], terms), ROUGH);
        let has = |name: &str| has_term(terms, name);
        let (mut starts, mut fits) = (Vec::new(), vec![gained.clone()]);
        let delays_s: &[f64] = if has(DELAY_TERM) { &DELAYS_S } else { &[0.0] };
        let lags_s: &[f64] = if has(LAG_TERM) { &LAGS_S } else { &[0.0] };
        for delay_s in delays_s {
            for lag_s in lags_s {
                let mut at = gained.at.clone();
                at[DELAY] += delay_s;
                at[LAG] += lag_s;
                starts.push((problem.objective(&at, &free), at));
            }
        }
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        fits.extend(
            starts
                .iter()
                .take(3)
                .map(|(_, at)| problem.fit(at, &free, ROUGH)),
        );
        let best = fits
            .into_iter()
            .max_by(|a, b| a.objective.total_cmp(&b.objective));
        best.unwrap_or(gained)
    }
}

fn has_term(terms: &[Term], name: &str) -> bool {
    terms.iter().any(|term| term.name == name)
}
