//! One robot that is watched: its rows, its filters, and what they say of each onset.

use nalgebra::{DMatrix, DVector};
use slipstream_bus::{EffectSpec, RobotModel};
use slipstream_recording::recording::Robot;

use super::bank::{Bank, ONSET_STEP_S, Onset};
use super::calibration::{Calibration, Course, course};
use super::filters::{Filters, Prepared};
use super::hypotheses::{Hypotheses, Hypothesis};
use super::statistic::{Known, Tested, test};
use crate::answer::Finding;
use crate::data::feed::{Feed, Habits, Oddity};
use crate::select::criterion::TIE_NATS;

/// Least time since an onset (s): what shows within less is a row or two.
const LEAST_S: f64 = 1.0;
/// A robot wanders within a run by this share of the deviation between recordings.
const WITHIN_RUN: f64 = 0.25;
/// Onsets within this of the best lie in its 95 % interval (nats).
const INTERVAL_NATS: f64 = 1.92;
/// Onsets older than this (s) are sparse, and looked at every eighth of their age.
pub(super) const YOUNG_S: f64 = 4.0;
/// Precision (s²/rad²) with which a bias of a gyro stays as it was before an onset.
const BIAS: f64 = 1.0 / (1e-3 * 1e-3);

/// What was found: since when (s), and what.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) onset_s: f64,
    pub(super) hypothesis: usize,
    pub(super) tested: Tested,
    /// The same from onsets that fit nearly as well, this one among them.
    pub(super) same: Vec<Tested>,
    /// Effects that fit as well.
    pub(super) alike: Vec<&'static str>,
}

/// One robot.
pub(super) struct Watched {
    pub(super) name: String,
    /// The model by which rows are read, and the one with everything that the baseline showed.
    pub(super) model: RobotModel,
    pub(super) improved: RobotModel,
    pub(super) feed: Feed,
    filters: Filters,
    bank: Bank,
    pub(super) hypotheses: Hypotheses,
    calibration: Calibration,
    habits: Habits,
    /// Where parameters were when the bank began.
    known: Known,
    bias: Option<usize>,
    /// How far parameters are from those of the baseline by what was confirmed.
    shift: Vec<f64>,
    /// What of that the wheels have, as effects.
    besides: Vec<EffectSpec>,
    next_s: f64,
    /// What a factor has to reach (nats).
    least: f64,
}

impl Watched {
    /// A robot like that of the baseline, whose runs, cut into pieces, are `runs`; `None` where these say nothing.
    pub(super) fn new(name: &str, baseline: Prepared, runs: &[Vec<Robot>]) -> Option<Self> {
        let Prepared {
            model,
            improved,
            mut filters,
            sources,
            hypotheses,
            bias,
            habits,
        } = baseline;
        let shift = vec![0.0; hypotheses.wide.len()];
        let mut bank = Bank::new(shift.len(), sources);
        let courses: Vec<Course> = runs
            .iter()
            .map(|pieces| {
                let mut feed = Feed::new(habits);
                let mut pieces = pieces.iter();
                course(&mut filters, &mut bank, |filters, bank| {
                    feed.take(pieces.next()?, &model);
                    filters.hear(&mut feed, bank);
                    Some(feed.now_s)
                })
            })
            .collect();
        let calibration = Calibration::new(&courses, &hypotheses)?;
        let mut own = Self {
            name: name.to_owned(),
            model,
            improved,
            feed: Feed::new(habits),
            filters,
            bank,
            known: calibration.known.clone(),
            hypotheses,
            calibration,
            habits,
            bias,
            shift,
            besides: Vec::new(),
            next_s: 0.0,
            least: f64::INFINITY,
        };
        own.widen(runs);
        own.again();
        Some(own)
    }

    /// Begins anew: nothing was heard.
    pub(super) fn again(&mut self) {
        self.feed = Feed::new(self.habits);
        if self.shift.iter().any(|own| *own != 0.0) {
            self.shift.fill(0.0);
            self.besides.clear();
            self.filters.move_to(&self.shift, &self.besides);
        }
        self.filters.restart();
        self.bank.clear();
        self.next_s = 0.0;
        self.known = between(&self.calibration.known, &self.hypotheses.repeats, 1.0);
    }

    /// Over everything that is watched, one false alarm in so many looks is let pass.
    pub(super) fn expect(&mut self, looks: f64) {
        self.least = (looks * self.hypotheses.all.len().max(1) as f64).ln();
    }

    /// What the baseline itself would be called is none.
    fn widen(&mut self, runs: &[Vec<Robot>]) {
        let mut most = vec![0.0_f64; self.hypotheses.all.len()];
        self.expect(FALSE_ALARM_LOOKS);
        for pieces in runs {
            self.feed = Feed::new(self.habits);
            self.restart(self.calibration.known.clone());
            self.filters.restart();
            for piece in pieces {
                self.feed.take(piece, &self.model);
                self.filters.hear(&mut self.feed, &mut self.bank);
                if !self.is_due() {
                    continue;
                }
                for (_, hypothesis, tested) in self.tests() {
                    most[hypothesis] = most[hypothesis].max(tested.factor / self.least);
                }
                self.open();
            }
        }
        for (hypothesis, times) in most.into_iter().enumerate() {
            if times > 1.0 {
                self.calibration.widen(hypothesis, times);
            }
        }
    }

    /// Hears a piece; what was odd about its rows.
    pub(super) fn hear(&mut self, piece: &Robot) -> Vec<Oddity> {
        let odd = self.feed.take(piece, &self.model);
        if self.bank.onsets.is_empty() && self.feed.now_s.is_finite() {
            self.bank.open(0.0);
        }
        self.filters.hear(&mut self.feed, &mut self.bank);
        odd
    }

    /// The last stamp, counted from the first one (s).
    pub(super) fn now_s(&self) -> f64 {
        self.feed.now_s
    }

    /// Whether it is time for a look.
    pub(super) fn is_due(&self) -> bool {
        self.feed.now_s >= self.next_s
    }

    /// From now on something may have changed.
    pub(super) fn open(&mut self) {
        self.bank.open(self.feed.now_s);
        self.next_s = self.feed.now_s + ONSET_STEP_S;
    }

    /// Nothing changed since now, and the parameters are known so.
    fn restart(&mut self, known: Known) {
        self.bank.clear();
        self.known = known;
        self.bank.open(if self.feed.now_s.is_finite() {
            self.feed.now_s
        } else {
            0.0
        });
    }

    /// What changed is what is from now on: as a diagnosis says, or else as the rows since the onset do.
    pub(super) fn absorb(&mut self, onset_s: f64, finding: Option<&Finding>) {
        if finding.is_some_and(|own| self.follow(own)) {
            self.filters.restart();
            let known = &self.calibration.known;
            let within = WITHIN_RUN * WITHIN_RUN;
            self.restart(between(known, &self.hypotheses.repeats, within));
            return;
        }
        let mut onsets = self.bank.onsets.iter();
        let own = onsets
            .find(|own| own.t_s >= onset_s)
            .or(self.bank.onsets.front());
        let wide = DMatrix::from_diagonal(&DVector::from_column_slice(&self.hypotheses.wide));
        let known = own.and_then(|own| {
            let wide = Known {
                mean: self.known.mean.clone(),
                covariance: wide,
            };
            wide.with(&own.sum, self.calibration.share())
        });
        self.restart(known.unwrap_or_else(|| self.known.clone()));
    }

    /// Takes over what a diagnosis found, if it is among what may change.
    fn follow(&mut self, finding: &Finding) -> bool {
        let same = self
            .hypotheses
            .all
            .iter()
            .filter(|own| own.effect == finding.effect);
        let Some(whole) = same.max_by_key(|own| own.len()) else {
            return false;
        };
        let Some(moved) = whole.moved(&self.improved, finding) else {
            return false;
        };
        let mut shift = self.shift.clone();
        let mut of_wheels = false;
        for (place, own) in shift.iter_mut().enumerate() {
            if whole.directions.row(place).iter().any(|own| *own != 0.0) {
                *own = moved[place];
                of_wheels |= self.filters.is_of_wheels(place);
            }
        }
        let mut besides = self.besides.clone();
        if of_wheels {
            besides.retain(|own| own.effect != finding.effect);
            besides.push(spec(finding));
        }
        if !self.filters.move_to(&shift, &besides) {
            self.filters.move_to(&self.shift, &self.besides);
            return false;
        }
        (self.shift, self.besides) = (shift, besides);
        true
    }

    /// Where parameters were before an onset.
    fn before(&self, onset: &Onset, is_first: bool) -> Known {
        if is_first {
            return self.known.clone();
        }
        let known = self.known.with(&onset.before, self.calibration.share());
        let known = known.unwrap_or_else(|| self.known.clone());
        between(&known, &self.hypotheses.repeats, WITHIN_RUN * WITHIN_RUN)
    }

    /// What a hypothesis, with its number, is worth since an onset before which parameters were `known`.
    fn test(
        &self,
        (number, own): (usize, &Hypothesis),
        onset: &Onset,
        known: &Known,
    ) -> Option<Tested> {
        let dispersion = self.calibration.of(number, self.feed.now_s - onset.t_s);
        let nuisance = self.bias.map(|bias| (bias, BIAS));
        test(own, &onset.sum, known, dispersion, nuisance)
    }

    /// All tests of onsets that are due: the onset (s), the number of the hypothesis, and what it is worth.
    fn tests(&self) -> Vec<(f64, usize, Tested)> {
        let now_s = self.feed.now_s;
        let mut all = Vec::new();
        for (number, onset) in self.bank.onsets.iter().enumerate() {
            let age_s = now_s - onset.t_s;
            let looks_in = ((now_s / ONSET_STEP_S) as u64) % ((age_s / YOUNG_S).max(1.0) as u64);
            if age_s < LEAST_S || looks_in != 0 {
                continue;
            }
            let known = self.before(onset, number == 0);
            for (hypothesis, own) in self.hypotheses.all.iter().enumerate() {
                if let Some(tested) = self.test((hypothesis, own), onset, &known) {
                    all.push((onset.t_s, hypothesis, tested));
                }
            }
        }
        all
    }

    /// What changed, if anything did.
    pub(super) fn look(&self) -> Option<Found> {
        let all = self.tests();
        let scored = all.into_iter().map(|(onset_s, hypothesis, tested)| {
            let factor = tested.factor - self.hypotheses.all[hypothesis].cost;
            (onset_s, hypothesis, tested, factor)
        });
        let scored: Vec<(f64, usize, Tested, f64)> = scored.collect();
        let seen = scored.iter().filter(|own| own.3 > self.least);
        let best = seen.max_by(|a, b| a.3.total_cmp(&b.3))?;
        let (onset_s, hypothesis, ref tested, factor) = *best;
        let effect = self.hypotheses.all[hypothesis].effect;
        let alike = scored.iter().filter(|own| own.3 > factor - TIE_NATS);
        let mut alike: Vec<&'static str> = alike
            .map(|own| self.hypotheses.all[own.1].effect)
            .filter(|own| *own != effect)
            .collect();
        alike.sort_unstable();
        alike.dedup();
        let same = scored
            .iter()
            .filter(|own| own.1 == hypothesis && own.3 > factor - INTERVAL_NATS);
        let same: Vec<Tested> = same.map(|own| own.2.clone()).collect();
        Some(Found {
            onset_s,
            hypothesis,
            tested: tested.clone(),
            same,
            alike,
        })
    }

    /// The smallest size of each number of each hypothesis that rows since the first onset at or behind `onset_s` would show.
    pub(super) fn smallest(&self, onset_s: f64) -> Vec<Smallest> {
        let mut onsets = self.bank.onsets.iter().enumerate();
        let Some((number, onset)) = onsets.find(|(_, own)| own.t_s >= onset_s) else {
            return Vec::new();
        };
        let known = self.before(onset, number == 0);
        let each = self.hypotheses.all.iter().enumerate();
        let each = each.filter_map(|(hypothesis, own)| {
            let tested = self.test((hypothesis, own), onset, &known)?;
            let sizes = tested.smallest(&own.plausible, self.least + own.cost)?;
            Some((own, sizes))
        });
        let values = each.flat_map(|(own, sizes)| {
            let alike = own.len() == 1 && own.values.len() > 1;
            own.values.iter().filter_map(move |value| {
                let mut weights = value.weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
                let (place, weight) = weights.next()?;
                (weights.next().is_none()).then(|| Smallest {
                    effect: own.effect,
                    parameter: value.name,
                    both: alike,
                    size: weight.abs() * sizes[place],
                })
            })
        });
        values.collect()
    }

    /// The hypothesis of what was found.
    pub(super) fn hypothesis(&self, found: &Found) -> &Hypothesis {
        &self.hypotheses.all[found.hypothesis]
    }
}

/// What a diagnosis found, as a model lists it.
fn spec(finding: &Finding) -> EffectSpec {
    let numbers = finding.parameters.iter();
    let numbers = numbers.filter_map(|own| Some((own.name.as_str(), own.estimate?)));
    EffectSpec::new(&finding.effect, &numbers.collect::<Vec<_>>())
}

/// The smallest change that rows show: of a factor, its logarithm.
#[derive(Debug, Clone)]
pub struct Smallest {
    /// The effect.
    pub effect: &'static str,
    /// Its parameter.
    pub parameter: &'static str,
    /// Both wheels change alike.
    pub both: bool,
    /// The size.
    pub size: f64,
}

/// Looks within ten hours.
pub(super) const FALSE_ALARM_LOOKS: f64 = FALSE_ALARM_S / ONSET_STEP_S;
/// One false alarm is let pass in so long (s).
pub(super) const FALSE_ALARM_S: f64 = 10.0 * 3600.0;

/// Known to this share of the variances among recordings, besides.
fn between(known: &Known, repeats: &[f64], share: f64) -> Known {
    let repeats = DVector::from_iterator(repeats.len(), repeats.iter().map(|own| own * share));
    Known {
        mean: known.mean.clone(),
        covariance: &known.covariance + DMatrix::from_diagonal(&repeats),
    }
}
