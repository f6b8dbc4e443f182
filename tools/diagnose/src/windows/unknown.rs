//! Something that the catalogue does not hold: on what it acts, which variable it follows, and what
//! it looks like.

use rayon::prelude::*;

use crate::windows::around::around;
use crate::windows::bench::{Bench, Node, every_other};
use crate::windows::drivers::Driver;
use crate::windows::force::{self, Answers, CHARGE, Missing};
use crate::windows::law::Law;
use crate::windows::passing::passing;
use crate::windows::pay::HELD_OUT;
use crate::windows::refine::refined;
use crate::windows::sampled::Sampled;
use crate::windows::swell;
use crate::windows::wander::{Judge, Wander};
use crate::windows::window::PULSE_S;

/// Δ(−2 ln L) that a missing force has to bring, and for each of its numbers more.
pub(crate) const PAY: [f64; 2] = [50.0, 2.0];
/// Of forces that follow a variable, those whose remainder is looked at closely.
const SEARCHED: usize = 4;
/// How many times as much a force that comes and goes has to bring as one that follows a variable.
const SAYS: f64 = 2.0;
/// Share of the largest force from which on it counts as at work.
const AT_WORK: f64 = 0.5;

/// What was found beyond the catalogue.
#[derive(Clone)]
pub(crate) struct Unknown {
    pub(crate) missing: Missing,
    /// It as a law, where it holds as one.
    law: Option<Holds>,
    /// When the force is large (s).
    pub(crate) intervals_s: Vec<[f64; 2]>,
    /// What it looks like, for a person.
    pub(crate) shape: String,
    /// ln L that it brings beside forces without pattern, to first order.
    pub(crate) gain: f64,
}

/// A missing force as a law.
#[derive(Clone)]
struct Holds {
    /// The same with the numbers that every other window asks for, from the first and from the second
    /// on.
    halves: [Missing; 2],
    /// −2 ln L under it.
    deviance: f64,
}

impl Unknown {
    /// Whether it predicts, as a law.
    pub(crate) fn predicts(&self) -> bool {
        self.law.is_some()
    }

    /// The force as a law, with the numbers that one half of the windows asks for or all. `None` where
    /// it does not hold as one.
    pub(crate) fn law(&self, bench: &Bench, half: Option<usize>) -> Option<Law> {
        let halves = &self.law.as_ref()?.halves;
        let missing = half.map_or(&self.missing, |half| &halves[half]);
        Some(Law::new(bench, missing.clone()))
    }

    /// The same with no claim that it predicts.
    pub(crate) fn without_law(&self) -> Self {
        Self {
            law: None,
            ..self.clone()
        }
    }
}

/// What is beyond the catalogue beside a node.
pub(crate) struct Beyond {
    /// Forces without pattern, were there nothing else.
    pub(crate) wander: Wander,
    /// ln L that these bring, to first order.
    pub(crate) gain: f64,
    /// A force with a pattern, if it is likelier.
    pub(crate) unknown: Option<Unknown>,
    /// −2 ln L of the likelier of both with a charge for each number.
    pub(crate) score: f64,
}

impl Beyond {
    /// −2 ln L under the force as a law, with a charge for each of its numbers; `None` where it is none.
    pub(crate) fn leads(&self) -> Option<f64> {
        let unknown = self.unknown.as_ref()?;
        Some(unknown.missing.charged(unknown.law.as_ref()?.deviance))
    }

    /// Whether there are forces, but none that follows more than the time.
    pub(crate) fn is_of_moments(&self) -> bool {
        let unknown = self.unknown.as_ref();
        unknown.is_none_or(|unknown| unknown.missing.driver.is_of_moments())
    }
}

/// What is beyond the catalogue beside `node`.
pub(crate) fn beside(bench: &Bench, node: &Node) -> Option<Beyond> {
    let (seen, judge) = around(bench, node, Judge::new(bench, node)?)?;
    let (begun, node) = (node, &seen);
    let wander = judge.alone()?;
    let samples = force::samples(&judge.answers);
    let forces = judge.forces(&wander.level)?;
    let mut drivers = Driver::all(&samples);
    if !bench.lacks_motion() {
        drivers.extend(swell::driver(&samples, &forces));
    }
    let missing = force::missing(bench, node, &judge.answers, &samples, &drivers);
    let mut likely = shortlist(missing);
    if !bench.knows_noise() {
        // no level says what is noise, but it does not repeat
        likely
            .retain(|m| force::held_out_gain(bench, node, &judge.answers, &samples, m) > HELD_OUT);
    }
    let followed = followed(bench, &judge, &samples, &likely, &wander);
    // a force that follows a variable says more than when it acted
    let gain = followed.as_ref().map_or(0.0, |followed| followed.gain);
    let passing = passing(bench, &judge, &samples, &forces, &wander);
    let found = passing
        .filter(|passing| passing.gain > SAYS * gain)
        .or(followed);
    let score = found.as_ref().map_or(wander.deviance, |found| found.score);
    Some(Beyond {
        gain: judge.gain(&wander)?,
        wander,
        unknown: found.map(|found| {
            let around = (node, &judge.answers[..], &samples[..], &forces[..]);
            let (missing, law) = led(bench, begun, around, found.missing);
            describe(bench, &samples, missing, law, found.gain / 2.0)
        }),
        score: score + CHARGE * node.fit.values.len() as f64,
    })
}

/// A node around forces, how its measurements answer, the motion there, and the forces piece by piece.
type Around<'a> = (
    &'a Node,
    &'a [Answers],
    &'a [Vec<Sampled>],
    &'a [Vec<[f64; 2]>],
);

/// A missing force with numbers that lead where measurements were, and it as a law, where it holds as
/// one beside a node: one that follows no more than the time predicts nothing.
fn led(
    bench: &Bench,
    node: &Node,
    (seen, answers, samples, forces): Around,
    missing: Missing,
) -> (Missing, Option<Holds>) {
    if missing.driver.is_of_moments() {
        return (missing, None);
    }
    let like = force::like(bench, samples, forces, &missing);
    let [first, second] = force::halves(bench, seen, answers, samples, &missing);
    let halves = [(0, first), (1, second)].map(|(fold, half)| {
        let (samples, forces) = (every_other(samples, fold), every_other(forces, fold));
        let like = force::like(bench, &samples, &forces, &missing);
        vec![half, like]
    });
    let begun = [missing, like];
    match holds(bench, node, &begun, &halves, f64::INFINITY) {
        Some((missing, law)) => (missing, Some(law)),
        None => {
            let [missing, _] = begun;
            (missing, None)
        }
    }
}

/// A missing force as a law beside a node, begun from these numbers and, of every other window, from
/// those. `None` where it leads no nearer than is `asked` (−2 ln L).
fn holds(
    bench: &Bench,
    node: &Node,
    begun: &[Missing],
    halves: &[Vec<Missing>; 2],
    asked: f64,
) -> Option<(Missing, Holds)> {
    let whole = refined(bench, node, begun).filter(|whole| whole.deviance < asked)?;
    let halves = [0, 1].map(|fold| {
        let (own, node) = bench.half(node, fold);
        let half = refined(&own, &node, &halves[fold]);
        half.map_or_else(|| halves[fold][0].clone(), |half| half.missing)
    });
    let deviance = whole.deviance;
    Some((whole.missing, Holds { halves, deviance }))
}

/// What an effect was taken for can be a piece of a force outside of the catalogue: that force as a law
/// beside `node`, which has one effect less, if it leads about as near as it did beside all: what is
/// `due` further off.
pub(crate) fn takes_over(
    bench: &Bench,
    node: &Node,
    unknown: &Unknown,
    due: f64,
) -> Option<Unknown> {
    let law = unknown.law.as_ref()?;
    let begun = [unknown.missing.clone()];
    let halves = law.halves.clone().map(|half| vec![half]);
    let (missing, law) = holds(bench, node, &begun, &halves, law.deviance + due)?;
    Some(Unknown {
        missing,
        law: Some(law),
        ..unknown.clone()
    })
}

/// A missing force beside forces without pattern.
pub(crate) struct Likelier {
    pub(crate) missing: Missing,
    /// −2 ln L with a charge for each number.
    pub(crate) score: f64,
    /// Δ(−2 ln L) against forces without pattern alone.
    pub(crate) gain: f64,
}

/// The likely force that follows a variable and pays best beside forces without pattern, if one does;
/// `than` are these alone.
fn followed(
    bench: &Bench,
    judge: &Judge,
    samples: &[Vec<Sampled>],
    likely: &[Missing],
    than: &Wander,
) -> Option<Likelier> {
    let active = judge.everywhere();
    let judged = |missing: Missing, from: Wander, searched: bool| {
        let Missing { driver, part, .. } = &missing;
        let mix = |samples| force::mix(bench, samples, driver, *part, missing.against);
        let mixes: Vec<_> = samples.iter().map(|samples| mix(samples)).collect();
        let beside = judge.beside(&active, &mixes, from.level, searched)?;
        Some((missing.charged(beside.deviance), missing, beside))
    };
    let first = likely.par_iter();
    let first = first.filter_map(|missing| judged(missing.clone(), *than, false));
    let mut first: Vec<_> = first.collect();
    first.sort_by(|a, b| a.0.total_cmp(&b.0));
    first.truncate(SEARCHED);
    let found = first
        .into_par_iter()
        .filter_map(|(_, missing, from)| judged(missing, from, true));
    let found: Vec<_> = found.collect();
    let found = found.into_iter().map(|(score, missing, beside)| Likelier {
        gain: than.deviance - beside.deviance,
        missing,
        score,
    });
    found
        .filter(|found| found.gain > PAY[0] + PAY[1] * found.missing.driver.numbers() as f64)
        .min_by(|a, b| a.score.total_cmp(&b.score))
}

/// The best of each variable, best first.
fn shortlist(all: Vec<Missing>) -> Vec<Missing> {
    let mut best: Vec<Missing> = Vec::new();
    for missing in all {
        if !best.iter().any(|known| known.driver == missing.driver) {
            best.push(missing);
        }
    }
    best
}

fn describe(
    bench: &Bench,
    samples: &[Vec<Sampled>],
    missing: Missing,
    law: Option<Holds>,
    gain: f64,
) -> Unknown {
    let mut moments: Vec<(f64, f64, f64)> = Vec::new();
    for sampled in samples.iter().flatten() {
        let force = missing
            .driver
            .force(&missing.weights, sampled, missing.part);
        let still = missing.against && sampled.stands();
        let z = missing.driver.variable(sampled, missing.part);
        moments.push((
            sampled.t_s,
            missing.driver.shown(z),
            if still { 0.0 } else { force },
        ));
    }
    let middle = median(moments.iter().map(|m| m.2));
    let deviates = |force: f64| force - if missing.against { 0.0 } else { middle };
    let most = moments
        .iter()
        .map(|m| deviates(m.2))
        .max_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
    let large = |force: f64| deviates(force) * most.signum() > AT_WORK * most.abs();
    let mut intervals_s: Vec<[f64; 2]> = Vec::new();
    for (at_s, ..) in moments.iter().filter(|m| large(m.2)) {
        let [from, to] = [at_s - PULSE_S / 2.0, at_s + PULSE_S / 2.0];
        match intervals_s.last_mut() {
            Some(last) if from - last[1] < 1.5 * PULSE_S => last[1] = to,
            _ => intervals_s.push([from, to]),
        }
    }
    let shape = shape(&missing, bench.lacks_motion(), &moments, most, &large);
    Unknown {
        missing,
        law,
        intervals_s,
        shape,
        gain,
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn shape(
    missing: &Missing,
    of_motion: bool,
    moments: &[(f64, f64, f64)],
    most: f64,
    large: &dyn Fn(f64) -> bool,
) -> String {
    let [what, unit] = missing.part.quantity(of_motion);
    let way = if missing.against {
        " against the motion"
    } else {
        ""
    };
    let driver = &missing.driver;
    let at: Vec<f64> = moments
        .iter()
        .filter(|m| large(m.2))
        .map(|m| m.1)
        .filter(|z| z.is_finite())
        .collect();
    let (low, high) = at
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| {
            (l.min(*z), h.max(*z))
        });
    let place = if low.is_finite() {
        format!(
            "; most of it where {} lies between {low:.2} and {high:.2} {}",
            driver.name, driver.unit
        )
    } else {
        String::new()
    };
    format!(
        "a {what}{way}{} that follows {}, up to {:.3} {unit}{place}",
        driver.character(),
        driver.name,
        if missing.against { most.abs() } else { most }
    )
}
