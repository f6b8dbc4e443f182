//! What may change of how a robot answers its torques: each effect of the catalogue that acts at once on a plant that rolls.
//! What its wheels, its lengths and its sensors do is told by the filters of the wheels.

use nalgebra::DMatrix;
use slipstream_bus::{EffectSpec, RobotModel};
use slipstream_sim::Robot;
use slipstream_sim::effects::{ModelSite, Role, When, find};

use super::hypotheses::{CHANGE, Hypotheses, Hypothesis, Shown, UNKNOWN, wheels};
use super::learnt::Moved;
use crate::data::track;
use crate::estimate::term::{Link, Term};
use crate::explain::dynamic::baseline::Baseline;
use crate::filter::dynamic::{Noise, Sensor};
use crate::model::hypothesis::{self, changes_commands_over_time, is_bound_to_place, sizes_of};
use crate::model::plant::filtered::robot;
use crate::model::plant::machine::Machine;
use crate::model::plant::table::Table;

/// Change of a parameter by which the plant is differentiated, in the smallest size that is expected of it.
const STEP: f64 = 0.05;
/// Deviation of a number among recordings of one robot, among changes that happen, and at all: of a factor as a logarithm,
/// of all else in the smallest size that is expected of it.
const FACTOR: [f64; 3] = [0.006, CHANGE, UNKNOWN];
const SIZE: [f64; 3] = [0.1, 10.0, 2.0];

/// Prior log-odds (nats) against a change of each number by itself beside one that they share.
const UNEVEN: f64 = 4.0;

/// A number of an effect.
struct EffectNumber {
    name: &'static str,
    /// Its parameter among those of the table, and its change, or that of its logarithm, by a parameter of 1.
    index: usize,
    slope: f64,
    role: Role,
}

impl EffectNumber {
    /// Variances of its parameter among recordings of one robot, among changes that happen, and at all.
    fn variances(&self) -> [f64; 3] {
        let own = match self.role {
            Role::Factor => FACTOR.map(|own| own / self.slope),
            _ => SIZE,
        };
        own.map(|own| own * own)
    }
}

/// What is heard, here and in a recording.
pub(super) const SENSORS: [(Sensor, track::Sensor); 2] = [
    (Sensor::WheelAngle, track::Sensor::WheelAngle),
    (Sensor::WheelSpeed, track::Sensor::WheelSpeed),
];

/// What the baseline was fitted as.
pub(crate) struct Forces {
    pub(crate) noise: Noise,
    pub(crate) plants: Plants,
    pub(crate) robots: Moved<Robot>,
    /// Variances of the readings of each of [`SENSORS`], of those that the baseline has.
    pub(crate) variance: [Option<[f64; 3]>; 2],
}

/// Plants of a machine by what changed of it.
pub(super) struct Plants {
    machine: Machine,
    table: Table,
    /// Which parameters of the table may change.
    indices: Vec<usize>,
}

impl Plants {
    /// The model with everything that the baseline showed.
    pub(super) fn model(&self) -> &RobotModel {
        &self.machine.model
    }

    /// The plant whose parameters are off those of the baseline by `shift`, and each with one number a little larger, with
    /// effects besides that are none of these; `None` where no robot has them.
    pub(super) fn at(&self, shift: &[f64], besides: &[EffectSpec]) -> Option<Moved<Robot>> {
        let mut model = self.machine.model.clone();
        for spec in besides {
            match model
                .effects
                .iter_mut()
                .find(|own| own.effect == spec.effect)
            {
                Some(own) => own.clone_from(spec),
                None => model.effects.push(spec.clone()),
            }
        }
        let mut at = self.table.start.clone();
        for (index, own) in self.indices.iter().zip(shift) {
            at[*index] += own;
        }
        let robot = |at: &[f64]| robot(&model, &self.table.hypotheses(at));
        let after = self.indices.iter().map(|index| {
            let mut at = at.clone();
            at[*index] += STEP;
            robot(&at)
        });
        let count = self.indices.len();
        Some(Moved {
            base: robot(&at)?,
            after: after.collect::<Option<_>>()?,
            places: (0..count).collect(),
            steps: vec![STEP; count],
        })
    }
}

/// What the filter reads of a robot, and what may change of it.
pub(super) fn of(baseline: Baseline) -> Option<(Forces, Hypotheses)> {
    let machine = baseline.machine;
    let all = hypothesis::all(&machine.model, &machine.tracks, &machine.excluded);
    let table = Table::new(&machine, &all, &[]);
    let terms = table.terms.iter().filter(|term| acts_at_once(term));
    let terms: Vec<(&Term, Vec<EffectNumber>)> = terms
        .map(|term| (term, numbers(&table, term)))
        .filter(|(_, numbers)| !numbers.is_empty())
        .collect();
    let each = || terms.iter().flat_map(|(_, numbers)| numbers);
    let mut first = 0;
    let mut found = Vec::new();
    for (term, numbers) in &terms {
        let whole = whole(&table, term, numbers, (first, each().count()));
        found.extend(wheels(&whole).into_iter().map(|own| Hypothesis {
            cost: term.cost,
            ..own
        }));
        found.push(whole);
        first += numbers.len();
    }
    let hypotheses = Hypotheses {
        all: found,
        repeats: each().map(|own| own.variances()[0]).collect(),
        wide: each().map(|own| own.variances()[2]).collect(),
    };
    let indices = each().map(|own| own.index).collect();
    let plants = Plants {
        machine,
        table,
        indices,
    };
    Some((forces(plants, &baseline.noise)?, hypotheses))
}

/// Whether an effect shows in the next rows, whatever was commanded before and wherever the robot is.
fn acts_at_once(term: &Term) -> bool {
    let shown = term.shown.first();
    let info = shown.and_then(|shown| find(shown.effect));
    info.is_some_and(|info| {
        term.is_smooth()
            && shown.is_some_and(|shown| shown.word.is_none())
            && !changes_commands_over_time(info)
            && !is_bound_to_place(info)
            && info.acts == When::Always
            && (!info.kinematic || info.site == ModelSite::Command)
    })
}

/// The parameters where a number is a little larger than in the baseline.
fn moved(table: &Table, index: usize) -> Vec<f64> {
    let mut at = table.start.clone();
    at[index] += STEP;
    at
}

/// The numbers that say how large an effect is.
fn numbers(table: &Table, term: &Term) -> Vec<EffectNumber> {
    let Some(info) = term.shown.first().and_then(|shown| find(shown.effect)) else {
        return Vec::new();
    };
    let sizes = term.parameters.iter().take(sizes_of(info)).enumerate();
    let each = sizes.filter_map(|(place, index)| {
        let at = moved(table, *index);
        let acting = table.hypotheses(&at);
        let own = acting.iter().position(|own| own.info.id == info.id)?;
        let before: usize = acting[..own].iter().map(|own| own.values.len()).sum();
        let (name, value) = *acting[own].values.get(place)?;
        let weights = table.weights(&at);
        let weight = weights.get(before + place)?;
        let (_, slope) = weight.iter().find(|(other, _)| other == index)?;
        let role = info.parameter(name)?.role;
        Some(EffectNumber {
            name,
            index: *index,
            slope: if role == Role::Factor {
                slope / value
            } else {
                *slope
            },
            role,
        })
    });
    each.collect()
}

/// An effect whose numbers are parameters from `first` on, of `count`.
fn whole(
    table: &Table,
    term: &Term,
    numbers: &[EffectNumber],
    (first, count): (usize, usize),
) -> Hypothesis {
    let mut directions = DMatrix::zeros(count, numbers.len());
    for k in 0..numbers.len() {
        directions[(first + k, k)] = 1.0;
    }
    let of = |(k, number): (usize, &EffectNumber)| Shown {
        name: number.name,
        link: if number.role == Role::Factor {
            Link::Log
        } else {
            Link::Identity
        },
        weights: (0..numbers.len())
            .map(|own| if own == k { number.slope } else { 0.0 })
            .collect(),
    };
    let is_new = table.starts(term).iter().all(|own| own.replaces.is_none());
    Hypothesis {
        effect: term.shown.first().map_or(term.name, |own| own.effect),
        directions,
        values: numbers.iter().enumerate().map(of).collect(),
        confused: Vec::new(),
        mirror: None,
        plausible: numbers.iter().map(|own| own.variances()[1]).collect(),
        inflation: 1.0,
        cost: term.cost + UNEVEN * (numbers.len() - 1) as f64,
        positive: term.positive && is_new,
    }
}

fn forces(plants: Plants, noise: &Noise) -> Option<Forces> {
    let machine = &plants.machine;
    let track = machine.tracks.first()?;
    let variance = SENSORS.map(|(_, own)| track.of(own).map(|own| own.deviation.map(|d| d * d)));
    Some(Forces {
        noise: machine.humbled(noise),
        robots: plants.at(&[], &[])?,
        variance,
        plants,
    })
}
