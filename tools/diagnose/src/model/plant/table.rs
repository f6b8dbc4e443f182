//! Effects of the catalogue as parameters of a likelihood, 0 where an effect does nothing.

use slipstream_sim::effects::{Role, When};

use super::machine::Machine;
use super::noise;
use super::number::{Link, Number};
use crate::data::track::Track;
use crate::estimate::scoring::Problem;
use crate::estimate::term::{Acts, Attribution, Search, Term};
use crate::estimate::{Likelihood, Prior};
use crate::model::hypothesis::{Hypothesis, all_sizes, kinds, momentary_and_placed, threshold};

/// Standard deviation of the size of an effect, in the smallest sizes that the catalogue expects: next to
/// nothing is known of it.
const DEVIATION: f64 = 100.0;
/// Longest step of an iteration, in the same unit.
const LONGEST: f64 = 20.0;
/// The same of the log of a noise size.
const LONGEST_NOISE: f64 = 2.0;
/// Deviation, as a share of the smallest expected size, by which an effect is what integrators differ by.
const TINY: f64 = 0.005;
/// Small noise, over what integrators differ by.
const SMALL: f64 = 5.0;
/// Prior log-odds (nats) against encoders that count wrong: wheels of another radius are the first suspect. Against a
/// patch: where it covers all of a way, the whole floor is.
const COUNTS_WRONG: f64 = 6.0;
const PATCH: f64 = 4.0;
/// Kinetic friction from which on no wheel is said to slip: rubber on a clean floor has 1.
const NO_SLIP_FRICTION: f64 = 1.2;
/// Smallest and largest play that is tried (rad).
const PLAYS_RAD: [f64; 2] = [0.002, 0.15];
/// Factor between two plays that are tried.
const PLAYS_APART: f64 = 1.35;
/// Share of all commanded sizes that a threshold swallows at most.
const SWALLOWED: f64 = 0.95;

/// One effect, in whatever numbers.
#[derive(Debug, Clone)]
pub(crate) struct Kind {
    own: Hypothesis,
    numbers: Vec<Number>,
    /// Place of its first parameter.
    first: usize,
    /// The kind that it changes in runs of today.
    base: Option<usize>,
    /// It acts in runs from before, and is fitted in any case.
    known: bool,
    /// Numbers from which a search begins.
    starts: Vec<Hypothesis>,
}

impl Kind {
    fn places(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.numbers.len()
    }
}

/// Parameters of effects and noise, and the terms that may be needed.
pub(crate) struct Table {
    kinds: Vec<Kind>,
    pub(crate) terms: Vec<Term>,
    /// Place of the first noise parameter.
    noise: usize,
    /// Noise parameters that the runs tell of, and those of them that are sizes.
    pub(crate) told: Vec<usize>,
    pub(crate) sizes: Vec<usize>,
    /// Parameters of what is known to act.
    pub(crate) always: Vec<usize>,
    /// Where a fit of what is known begins.
    pub(crate) start: Vec<f64>,
    pub(crate) priors: Vec<Prior>,
    pub(crate) longest: Vec<f64>,
    pub(crate) twins: Vec<Option<usize>>,
    /// What the model has of each, below which it may not fall.
    pub(crate) nominal: Vec<f64>,
}

impl Table {
    /// A table of what may be lacking (`all`, with the values from which each begins) beside what is `known`.
    pub(crate) fn new(machine: &Machine, all: &[Hypothesis], known: &[Hypothesis]) -> Self {
        let mut table = Self {
            kinds: Vec::new(),
            terms: Vec::new(),
            noise: 0,
            told: Vec::new(),
            sizes: Vec::new(),
            always: Vec::new(),
            start: Vec::new(),
            priors: Vec::new(),
            longest: Vec::new(),
            twins: Vec::new(),
            nominal: Vec::new(),
        };
        for own in known {
            table.add_known(machine, own);
        }
        for starts in kinds(all) {
            if machine.tells(starts[0]) {
                table.add(machine, &starts);
            }
        }
        for own in momentary_and_placed() {
            if machine.has_pose() && machine.tries(own.info.id) {
                table.add(machine, &[&own]);
            }
        }
        table.add_noise(machine);
        table
    }

    fn push(
        &mut self,
        machine: &Machine,
        own: &Hypothesis,
        base: Option<usize>,
        known: bool,
    ) -> usize {
        let numbers = own.values.iter();
        let numbers = numbers.map(|(name, _)| Number::new(own, name, machine));
        let numbers: Vec<Number> = numbers.collect();
        let first = self.priors.len();
        for (place, number) in numbers.iter().enumerate() {
            let twin = base.map(|base| self.kinds[base].first + place);
            self.priors.push(Prior {
                mean: 0.0,
                deviation: DEVIATION,
                has_tails: false,
            });
            self.longest.push(LONGEST);
            self.twins.push(twin);
            let grips = if slides_by(own, number) {
                -1.0 / NO_SLIP_FRICTION
            } else {
                0.0
            };
            let nominal = number.nothing.max(0.0) + grips;
            self.nominal.push(match base {
                Some(base) => self.nominal[self.kinds[base].first + place],
                None => nominal / number.unit,
            });
            self.start.push(if known {
                number.at(own.values[place].1)
            } else {
                0.0
            });
        }
        self.kinds.push(Kind {
            own: own.clone(),
            numbers,
            first,
            base,
            known,
            starts: Vec::new(),
        });
        self.kinds.len() - 1
    }

    fn add_known(&mut self, machine: &Machine, own: &Hypothesis) {
        let kind = self.push(machine, own, None, true);
        if !own.is_threshold() {
            self.always.extend(self.kinds[kind].places());
        }
    }

    /// One kind, with the values from which it begins.
    fn add(&mut self, machine: &Machine, starts: &[&Hypothesis]) {
        let own = starts[0];
        let mut base = None;
        if own.since {
            base = self.kinds.iter().position(|kind| kind.own.is_of(own));
            // what changed may as well have been there before
            let before = Hypothesis {
                since: false,
                ..own.clone()
            };
            base = base.or_else(|| Some(self.push(machine, &before, None, false)));
        }
        let kind = self.push(machine, own, base, false);
        self.kinds[kind].starts = starts.iter().map(|own| (*own).clone()).collect();
        let kind = &self.kinds[kind];
        let search = self.search(machine, kind);
        let count = kind.numbers.len();
        let sizes = |number: &Number| {
            number.link != Link::Angle
                && number.bounds[0] >= 0.0
                && own
                    .info
                    .parameter(number.name)
                    .is_some_and(|p| p.role == Role::Size || p.role == Role::Limit)
        };
        self.terms.push(Term {
            name: name(own),
            parameters: kind.places().collect(),
            resolution: vec![TINY * TINY; count],
            repeatability: vec![0.0; count],
            inflation: 1.0,
            cost: cost(own.info.id),
            positive: kind.numbers.iter().all(sizes),
            rare: search == Search::Located,
            search,
            usual: false,
            kinked: false,
            needs_relevance: false,
            acts: Acts::default(),
            shown: vec![Attribution {
                effect: own.info.id,
                word: own.text,
                run: None,
                values: Vec::new(),
                parameters: kind.places().collect(),
                confused: Vec::new(),
                mirror: None,
            }],
        });
    }

    /// How a kind is searched.
    fn search(&self, machine: &Machine, kind: &Kind) -> Search {
        let own = &kind.own;
        let base = kind.base.map(|base| &self.kinds[base]);
        if own.is_threshold() {
            let before = base.map_or(0.0, |base| self.start[base.first]);
            let all = thresholds(machine).into_iter();
            let numbers = kind.numbers.iter().take(1);
            return Search::Profiled(
                numbers
                    .flat_map(|number| all.clone().map(|own| number.at(own) - before))
                    .collect(),
            );
        }
        if own.is_local() || own.is_abrupt() {
            return Search::Located;
        }
        if own.replaces.is_some() || base.is_some_and(|base| base.known) {
            return Search::Smooth(Vec::new());
        }
        let at = |own: &Hypothesis| {
            let pairs = kind.numbers.iter().zip(&own.values);
            pairs
                .map(|(number, (_, value))| number.at(*value))
                .collect()
        };
        let plays = if own.has_play() {
            plays(own)
        } else {
            Vec::new()
        };
        Search::Smooth(kind.starts.iter().chain(&plays).map(at).collect())
    }

    fn add_noise(&mut self, machine: &Machine) {
        self.noise = self.priors.len();
        for prior in machine.noise_priors() {
            self.priors.push(prior);
            self.longest.push(LONGEST_NOISE);
            self.twins.push(None);
            self.nominal.push(0.0);
            self.start.push(0.0);
        }
        self.told = machine
            .told_noise()
            .map(|index| self.noise + index)
            .collect();
        let is_size = |index: &&usize| **index < self.noise + noise::SIZES;
        self.sizes = self.told.iter().filter(is_size).copied().collect();
    }

    /// The noise parameters of `at`.
    pub(crate) fn of_noise<'a>(&self, at: &'a [f64]) -> &'a [f64] {
        &at[self.noise..]
    }

    /// Whether a parameter is one of noise.
    pub(crate) fn is_noise(&self, index: usize) -> bool {
        index >= self.noise
    }

    /// Whether the likelihood may have a kink where this parameter is: a derivative by it is a mean over what
    /// is known of it.
    pub(crate) fn is_abrupt(&self, index: usize) -> bool {
        let mut kinds = self.kinds.iter();
        let own = kinds.find(|kind| kind.places().contains(&index));
        own.is_some_and(|kind| kind.own.info.acts != When::Always)
    }

    /// Effects that act at `at`, each with the kind that it is.
    fn acting<'a>(&'a self, at: &'a [f64]) -> impl Iterator<Item = &'a Kind> {
        let acts = |kind: &&Kind| kind.known || kind.places().any(|index| at[index] != 0.0);
        self.kinds.iter().filter(acts)
    }

    /// Effects that act at `at`.
    pub(crate) fn hypotheses(&self, at: &[f64]) -> Vec<Hypothesis> {
        let of = |kind: &Kind| {
            let mut own = kind.own.clone();
            for (place, (number, (_, value))) in
                kind.numbers.iter().zip(&mut own.values).enumerate()
            {
                let base = kind
                    .base
                    .map_or(0.0, |base| at[self.kinds[base].first + place]);
                *value = number.value(own.info, base + at[kind.first + place]);
            }
            own.keep_in_order();
            own
        };
        self.acting(at).map(of).collect()
    }

    /// The numbers of all of [`Table::hypotheses`] as parameters with their weights; none of a threshold.
    pub(crate) fn weights(&self, at: &[f64]) -> Vec<Vec<(usize, f64)>> {
        let hypotheses = self.hypotheses(at);
        let of = |(kind, own): (&Kind, Hypothesis)| {
            if own.is_threshold() {
                return Vec::new();
            }
            let numbers = kind.numbers.iter().zip(&own.values).enumerate();
            let numbers = numbers.map(|(place, (number, (_, value)))| {
                let slope = number.slope(*value);
                let base = kind
                    .base
                    .map(|base| (self.kinds[base].first + place, slope));
                std::iter::once((kind.first + place, slope))
                    .chain(base)
                    .collect()
            });
            numbers.collect()
        };
        self.acting(at).zip(hypotheses).flat_map(of).collect()
    }

    /// Parameters of the effects that act at `at`, but for thresholds.
    pub(crate) fn acting_parameters(&self, at: &[f64]) -> Vec<usize> {
        let smooth = self.acting(at).filter(|kind| !kind.own.is_threshold());
        smooth.flat_map(Kind::places).collect()
    }

    /// The term of an effect that acts.
    pub(crate) fn term_of(&self, own: &Hypothesis) -> Option<&Term> {
        self.terms.iter().find(|term| term.name == name(own))
    }

    /// The problem of fitting a likelihood with the priors of the table.
    pub(crate) fn problem<'a>(&self, likelihood: &'a dyn Likelihood) -> Problem<'a> {
        Problem {
            likelihood,
            priors: self.priors.clone(),
            longest: self.longest.clone(),
            sizes: self.sizes.clone(),
        }
    }

    /// Numbers from which a search for a term begins.
    pub(crate) fn starts(&self, term: &Term) -> &[Hypothesis] {
        let first = term.parameters.first();
        let own = self.kinds.iter().find(|kind| Some(&kind.first) == first);
        own.map_or(&[], |kind| &kind.starts)
    }

    /// `at` with the noise that is expected before anything is known.
    pub(crate) fn with_expected_noise(&self, at: &[f64]) -> Vec<f64> {
        let mut out = at.to_vec();
        out[self.noise..].fill(0.0);
        out
    }

    /// `at` with noise that is small: some times what integrators differ by, for as long as is expected.
    pub(crate) fn with_small_noise(&self, at: &[f64]) -> Vec<f64> {
        let mut out = self.with_expected_noise(at);
        for index in &self.sizes {
            out[*index] = self.priors[*index].mean + SMALL.ln();
        }
        out
    }

    /// `at` with the numbers of an effect.
    pub(crate) fn with(&self, at: &[f64], own: &Hypothesis) -> Vec<f64> {
        let mut out = at.to_vec();
        if let Some(kind) = self.kinds.iter().find(|kind| kind.own.is_like(own)) {
            for (index, (number, (_, value))) in
                kind.places().zip(kind.numbers.iter().zip(&own.values))
            {
                out[index] = number.at(*value);
            }
        }
        out
    }
}

/// Whether wheels slide by a number of an effect that the model does not list.
fn slides_by(own: &Hypothesis, number: &Number) -> bool {
    own.is_abrupt() && number.link == Link::Inverse
}

/// Prior log-odds (nats) against an effect, beside those that fit as well.
fn cost(id: &str) -> f64 {
    match id {
        "encoder_scale" => COUNTS_WRONG,
        "friction_patch" => PATCH,
        _ => 0.0,
    }
}

/// Name of the term of an effect.
fn name(own: &Hypothesis) -> &'static str {
    match own.text {
        Some(("stream", "wheels")) => "clock_drift of wheels",
        Some(("stream", "pose")) => "clock_drift of pose",
        Some(("stream", "imu")) => "clock_drift of imu",
        _ => own.info.id,
    }
}

/// Thresholds between the sizes that are commanded, and one above all.
fn thresholds(machine: &Machine) -> Vec<f64> {
    let of = |track: &Track| all_sizes(track, &machine.model);
    let mut sizes: Vec<f64> = machine.tracks.iter().flat_map(of).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let most = (SWALLOWED * sizes.len() as f64) as usize;
    let places = (1..most).chain([sizes.len()]);
    places.map(|place| threshold(&sizes, place)).collect()
}

/// Sizes of a play from small to large: what lies between two of them is found from the nearer one.
fn plays(start: &Hypothesis) -> Vec<Hypothesis> {
    let [least, most] = PLAYS_RAD;
    let sizes = std::iter::successors(Some(least), |size| Some(size * PLAYS_APART));
    let of = |size| {
        let mut own = start.clone();
        own.set(start.values[0].0, size);
        own
    };
    sizes.take_while(|size| *size < most).map(of).collect()
}
