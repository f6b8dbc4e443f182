//! From the terms that are needed to effects of the catalogue.

use std::f64::consts::{FRAC_PI_2, PI};

use super::claim::{Claim, Law, Value};
use super::fitted::Fitted;
use super::search::{Searched, problem};
use crate::estimate::term::{self, Attribution, Link, Search, Term};
use crate::filter::motion_law::table_of;
use crate::model::streams::{Joint, ROBUST, Streams};
use crate::model::wheel_parameters::LAW_FIRST;
use crate::select::criterion::FALSE_ALARM;
use crate::select::selected::Kept;

/// Half of the chi-square of one parameter at 95 %: dead bands within it fit as well (nats).
const ALIKE_NATS: f64 = 1.92;
/// Dead bands at most that are tried to each side for an interval.
const BANDS: usize = 60;
/// Factor from which on a wheel is no longer of another size, but encoders count otherwise.
const MISCOUNT_FACTOR: f64 = 1.8;
/// Tyres of one robot change by less between two recordings (logarithm of a factor).
pub(crate) const TYRES: f64 = 0.03;

/// A number and its standard deviation.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub(super) change: f64,
    pub(super) deviation: f64,
    /// By how much it is larger in the second half, where the halves differ.
    difference: Option<f64>,
}

/// What was found, to be named.
pub(crate) struct Naming<'a> {
    pub(crate) found: &'a Searched,
    pub(crate) streams: Streams<'a>,
    /// Whether it is what changed since other recordings.
    pub(crate) compares: bool,
}

impl Naming<'_> {
    /// What the model leaves out, what gains most first.
    pub(crate) fn claims(&self) -> Vec<Claim> {
        let kept = self.found.selected.kept.iter();
        let mut claims: Vec<Claim> = kept.flat_map(|kept| self.of_term(kept)).collect();
        self.turning(&mut claims);
        self.late_runs(&mut claims);
        self.downhill(&mut claims);
        one_gain(&mut claims);
        if self.streams.reference.by_heading {
            claims.iter_mut().for_each(by_heading);
        }
        claims.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        claims
    }

    /// A slope goes down to the front or to the back of a robot that is told voltages.
    fn downhill(&self, claims: &mut [Claim]) {
        let fitted = Fitted {
            streams: self.streams,
            found: self.found,
        };
        let Some([from, to]) = fitted.grades() else {
            return;
        };
        let slopes = claims.iter_mut().filter(|own| own.effect == "floor_slope");
        for claim in slopes {
            let downhill = |grade: f64| if grade < 0.0 { PI } else { 0.0 };
            let value = &mut claim.values[0];
            value.halves = None;
            value.change = to.abs() - from.abs();
            let turned = downhill(to) - downhill(from);
            // wheels do not see what of a slope lies across the robot
            let own = Value::new("downhill_rad", Link::Identity, turned, FRAC_PI_2);
            claim.values.push(own);
        }
    }

    /// To a gyro alone a common factor of both wheels and the track are one: where the wheels differ, it is theirs.
    fn turning(&self, claims: &mut Vec<Claim>) {
        let place = |effect: &str| claims.iter().position(|claim| claim.effect == effect);
        let both = place("wheel_radius").zip(place("track_width"));
        let (Some((radius, track)), false) = (both, self.streams.reference.has_pose()) else {
            return;
        };
        let own = claims[track].clone();
        for value in &mut claims[radius].values {
            value.change -= own.values[0].change;
            value.halves = None;
            value.half = [value.half[0].hypot(own.values[0].half[0]); 2];
        }
        claims[radius].toggles.extend(&own.toggles);
        claims.remove(track);
    }

    pub(super) fn known(&self, weights: &[(usize, f64)], term: &Term) -> Known {
        let selected = &self.found.selected;
        let change = weights.iter().map(|(i, w)| w * selected.fit.at[*i]).sum();
        let difference = selected.difference(weights);
        Known {
            change,
            deviation: selected.deviation(weights) * term.inflation,
            difference: difference.map(|[own, _]| own),
        }
    }

    pub(super) fn value(&self, own: &term::Value, known: Known) -> Value {
        let half = self.found.criterion.half_width() * known.deviation;
        let halves = known
            .difference
            .map(|d| [known.change - d / 2.0, known.change + d / 2.0]);
        Value {
            halves,
            ..Value::new(own.name, own.link, known.change, half)
        }
    }

    /// Probability of a number at least as far from 0 by chance.
    fn p_value(&self, known: Known) -> f64 {
        let z = known.change / known.deviation.max(f64::MIN_POSITIVE);
        self.found.criterion.alone().p_value(z * z, 1)
    }

    fn of_term(&self, kept: &Kept) -> Vec<Claim> {
        let term = &kept.term;
        let clear = |shown: &Attribution| {
            let values = shown.values.iter();
            let all = values.map(|value| self.p_value(self.known(&value.weights, term)));
            all.fold(1.0, f64::min)
        };
        let each: Vec<f64> = term.shown.iter().map(clear).collect();
        // a term that is needed is at least the clearest of its effects
        let least = each.iter().copied().fold(1.0, f64::min).max(FALSE_ALARM);
        let own = term.shown.iter().zip(each);
        let own = own.filter(|(_, p)| term.shown.len() == 1 || *p <= least);
        own.map(|(shown, _)| self.claim(shown, kept)).collect()
    }

    fn claim(&self, shown: &Attribution, kept: &Kept) -> Claim {
        let term = &kept.term;
        let wald = kept.wald / (term.inflation * term.inflation);
        let tried = self.found.criterion.tried as f64;
        let p_value = if term.is_profiled() {
            (tried * (-kept.gain).exp()).min(1.0)
        } else {
            self.found.criterion.p_value(wald, term.parameters.len())
        };
        let values = shown.values.iter().map(|own| {
            let mut known = self.known(&own.weights, term);
            if term.name == "lag" {
                // only its size is meant
                let nominal = self.nominal(&own.weights);
                known.change = (known.change + nominal).abs() - nominal;
            }
            let mut value = self.value(own, known);
            self.clock(&mut value, &own.weights);
            value
        });
        let mut claim = Claim {
            effect: shown.effect,
            values: values.collect(),
            word: shown.word,
            runs: shown.run.map(|run| vec![run]),
            toggles: shown.parameters.clone(),
            gain: kept.gain,
            p_value,
            confused: shown.confused.clone(),
            law: None,
        };
        claim.confused.extend(self.alike(term));
        self.mirror(&mut claim, shown);
        self.miscounted(&mut claim);
        self.slipped(&mut claim, shown, term);
        if shown.effect == "unknown" {
            claim.law = self.law(term);
        }
        if term.is_profiled() {
            self.profile(&mut claim, term);
        }
        if let Some(run) = shown.run {
            self.of_run(&mut claim, run, shown);
        }
        claim
    }

    /// The effects of terms that fit as well in the place of one.
    fn alike(&self, term: &Term) -> Vec<&'static str> {
        let found = self.found;
        let own = found
            .selected
            .alike
            .iter()
            .filter(|[own, _]| *own == term.name);
        let others = own.filter_map(|[_, other]| {
            let mut terms = found.table.terms.iter();
            terms.find(|term| term.name == *other)
        });
        let effects = others
            .flat_map(|other| &other.shown)
            .map(|shown| shown.effect);
        let mut effects: Vec<&'static str> = effects.collect();
        effects.sort_unstable();
        effects.dedup();
        effects.retain(|effect| term.shown.iter().all(|own| own.effect != *effect));
        effects
    }

    /// What the model has of a number already.
    fn nominal(&self, weights: &[(usize, f64)]) -> f64 {
        let of = |index: usize| {
            let own = self.found.table.weights[index].first();
            own.map_or(0.0, |(read, _)| self.found.nominal[*read])
        };
        weights
            .iter()
            .map(|(index, weight)| weight * of(*index))
            .sum()
    }

    /// A stream that is stamped before it was measured is the less likely of two.
    pub(super) fn mirror(&self, claim: &mut Claim, shown: &Attribution) {
        let (Some((effect, sign)), [own]) = (shown.mirror, shown.values.as_slice()) else {
            return;
        };
        let total = claim.values[0].change + self.nominal(&own.weights);
        if total >= 0.0 {
            return;
        }
        if sign < 0.0 {
            claim.values[0].negate();
        }
        claim.effect = effect;
        claim.confused.retain(|own| *own != effect);
        if sign < 0.0 {
            claim.confused.push(shown.effect);
        }
    }

    /// Wheels whose size is far from the model's, with no command that tells them from encoders: no wheel is
    /// that much larger than its data, encoders and gears are.
    fn miscounted(&self, claim: &mut Claim) {
        let far = claim
            .values
            .iter()
            .any(|own| own.change.abs() > MISCOUNT_FACTOR.ln());
        let commanded = self.streams.drive.is_some() || self.streams.reference.is_commanded();
        if claim.effect != "wheel_radius" || commanded || !far {
            return;
        }
        claim.effect = "encoder_scale";
        claim.values.iter_mut().for_each(Value::negate);
        claim.confused = vec!["wheel_radius"];
    }

    /// A scale that changed by more than tyres do since other recordings is that of the floor, which takes a share of
    /// the way.
    fn slipped(&self, claim: &mut Claim, shown: &Attribution, term: &Term) {
        let compares = self.compares && self.streams.reference.has_pose();
        let weights = shown.values.first().map(|own| own.weights.as_slice());
        let (true, "wheel_radius", Some([(common, _), (difference, _)])) =
            (compares, claim.effect, weights)
        else {
            return;
        };
        let known = self.known(&[(*common, 1.0)], term);
        if known.change.abs() < TYRES {
            return;
        }
        let ratio = term::Value {
            name: "ratio",
            link: Link::LogLoss,
            weights: vec![(*common, 1.0)],
        };
        claim.effect = "slip_ratio";
        claim.values = vec![self.value(&ratio, known)];
        claim.confused.retain(|own| *own != "slip_ratio");
        claim.confused.push("wheel_radius");
        let known = self.known(&[(*difference, 1.0)], term);
        self.slip_differs(claim, known);
    }

    /// Of a slip, what differs between right and left, where that is clear.
    fn slip_differs(&self, claim: &mut Claim, known: Known) {
        if self.p_value(known) < FALSE_ALARM {
            let factor = -claim.values[0].change.exp();
            let change = factor * 2.0 * (known.change / 2.0).sinh();
            let half = (factor * self.found.criterion.half_width() * known.deviation).abs();
            let own = Value::new("asymmetry", Link::Identity, change, half);
            claim.values.push(own);
        }
    }

    /// What `of` says of the log-likelihood as a function of changes of single parameters beside the fit.
    pub(super) fn with_objective<T>(
        &self,
        of: impl FnOnce(&dyn Fn(&[(usize, f64)]) -> f64) -> T,
    ) -> T {
        let found = self.found;
        let joint = Joint::new(self.streams, &found.nominal, &found.table.weights, ROBUST);
        let problem = problem(&joint, &found.table);
        let fit = &found.selected.fit;
        of(&|changes| {
            let mut at = fit.at.clone();
            changes.iter().for_each(|(index, by)| at[*index] += by);
            problem.objective(&at, &fit.free)
        })
    }

    /// The interval in which a dead band fits as well.
    fn profile(&self, claim: &mut Claim, term: &Term) {
        let (Search::Profiled(values), [value]) = (&term.search, claim.values.as_mut_slice())
        else {
            return;
        };
        let found = value.change;
        let [low, high] = self.with_objective(|objective| {
            let worth = |change: f64| objective(&[(term.parameters[0], change - found)]);
            let place = values.partition_point(|own| *own < found - 1e-12);
            let best = worth(found);
            let fits = |place: &usize| worth(values[*place]) > best - ALIKE_NATS;
            let above = (place + 1..values.len())
                .take(BANDS)
                .take_while(fits)
                .last();
            let below = (0..place).rev().take(BANDS).take_while(fits).last();
            [below.unwrap_or(place), above.unwrap_or(place)]
        });
        let at = |place: usize| values[place.min(values.len() - 1)];
        // a dead band lies anywhere between two commands
        let edge = |a: usize, b: usize| (at(a) - at(b)).abs() / 2.0;
        let below = value.change - at(low) + edge(low, low.saturating_sub(1));
        let above = at(high) - value.change + edge(high, high + 1);
        value.half = [below, above];
    }

    /// What the catalogue does not have: a speed or a turn rate that follows the turn rate, or the speed.
    fn law(&self, term: &Term) -> Option<Law> {
        let moved = |index: &usize| &self.found.table.weights[*index];
        let (first, _) = term
            .parameters
            .first()
            .and_then(|index| moved(index).first())?;
        let table = table_of(first.checked_sub(LAW_FIRST)?)?;
        let knots = self.streams.reference.knots[table.over];
        let fit = &self.found.selected.fit;
        // values are linear in the parameters: the weights of each
        let parts = term.parameters.iter().map(|index| {
            let mut one = vec![0.0; table.count];
            for (read, weight) in moved(index) {
                one[read - LAW_FIRST - table.first] += weight;
            }
            knots.values(&one).to_vec()
        });
        let parts: Vec<Vec<f64>> = parts.collect();
        let value = |knot: usize| {
            let own = term.parameters.iter().zip(&parts);
            own.map(|(index, part)| fit.at[*index] * part[knot]).sum()
        };
        let half = (0..knots.places().len()).map(|value| {
            let own = term.parameters.iter().copied();
            let weights: Vec<(usize, f64)> =
                own.zip(parts.iter().map(|part| part[value])).collect();
            self.found.criterion.half_width() * self.known(&weights, term).deviation
        });
        Some(Law {
            table: *table,
            knots: knots.places(),
            values: (0..knots.places().len()).map(value).collect(),
            half: half.collect(),
        })
    }

    /// What a run was from the nominal model before; and of slip, right against left.
    fn of_run(&self, claim: &mut Claim, run: usize, shown: &Attribution) {
        let place = usize::from(shown.effect == "track_width");
        let offsets = self.streams.reference.offsets.get(run);
        claim.values[0].before = offsets.map_or(0.0, |own| own[place]);
        if claim.effect != "slip_ratio" {
            if self.streams.reference.runs.len() == 1 {
                claim.runs = None;
            }
            return;
        }
        let found = self.found;
        let geometry = found.selected.kept("geometry").map(|kept| &kept.term);
        let keys = found.table.keys.iter();
        let index = keys
            .clone()
            .position(|key| key.name == "radius" && key.number == 1);
        let (Some(term), Some(index)) = (geometry, index) else {
            return;
        };
        claim.toggles.push(index);
        self.slip_differs(claim, self.known(&[(index, 1.0)], term));
    }
}

/// What both motors share and what they differ by are one gain.
fn one_gain(claims: &mut Vec<Claim>) {
    let mut places = (0..claims.len()).filter(|i| claims[*i].effect == "motor_gain");
    let (Some(first), Some(second)) = (places.next(), places.next()) else {
        return;
    };
    let other = claims.remove(second);
    let own = &mut claims[first];
    for (value, other) in own.values.iter_mut().zip(&other.values) {
        value.change += other.change;
        value.half = [0, 1].map(|i| value.half[i].hypot(other.half[i]));
        value.halves = None;
    }
    own.toggles.extend(&other.toggles);
    own.gain += other.gain;
    own.p_value = own.p_value.min(other.p_value);
}

/// A gyro that is the heading of poses.
fn by_heading(claim: &mut Claim) {
    let renamed = |effect: &'static str| match effect {
        "imu_latency" => "pose_latency",
        other => other,
    };
    claim.effect = renamed(claim.effect);
    for own in &mut claim.confused {
        *own = renamed(own);
    }
    if let Some((_, word)) = &mut claim.word
        && *word == "imu"
    {
        *word = "pose";
    }
}
