//! What a change may be: each effect of the catalogue that the streams show at once, as directions among the parameters.

use nalgebra::{DMatrix, DVector};
use slipstream_bus::RobotModel;

use super::learnt::{Learnt, Parameter};
use crate::answer::Finding;
use crate::estimate::Prior;
use crate::estimate::term::{Attribution, Link, Term, Value};
use crate::explain::kinematic::Baseline;
use crate::model::table::{Asked, Table};
use crate::model::wheel_parameters::RUN_BIAS;

/// A value of an effect: its name, how it changes, and its weights by the hypothesis' own numbers.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    pub(crate) name: &'static str,
    pub(crate) link: Link,
    pub(crate) weights: Vec<f64>,
}

/// One thing that may change.
#[derive(Debug, Clone)]
pub(crate) struct Hypothesis {
    pub(crate) effect: &'static str,
    /// Parameters by its own numbers.
    pub(crate) directions: DMatrix<f64>,
    pub(crate) values: Vec<Shown>,
    pub(crate) confused: Vec<&'static str>,
    pub(crate) mirror: Option<(&'static str, f64)>,
    /// Variance of each of its numbers among changes that happen.
    pub(crate) plausible: Vec<f64>,
    /// Inflation of its standard errors, and prior log-odds against it (nats).
    pub(crate) inflation: f64,
    pub(crate) cost: f64,
    /// Its first number cannot be negative.
    pub(crate) positive: bool,
}

impl Hypothesis {
    /// How many numbers it has.
    pub(crate) fn len(&self) -> usize {
        self.directions.ncols()
    }
}

impl Hypothesis {
    /// How far the parameters are from those of `model` where its effect is as large as a finding says.
    pub(super) fn moved(&self, model: &RobotModel, finding: &Finding) -> Option<DVector<f64>> {
        let change = |own: &Shown| {
            let mut all = finding.parameters.iter();
            let known = all.find(|parameter| parameter.name == own.name)?.estimate?;
            let was = model.number(self.effect, own.name);
            let change = match own.link {
                Link::Identity => known - was.unwrap_or(0.0),
                Link::Log => (known / was.unwrap_or(1.0)).ln(),
                Link::LogLoss => ((1.0 - known) / (1.0 - was.unwrap_or(0.0))).ln(),
            };
            change.is_finite().then_some(change)
        };
        let changes: Vec<f64> = self.values.iter().map(change).collect::<Option<_>>()?;
        if changes.len() != self.len() {
            return None;
        }
        let weights = self
            .values
            .iter()
            .flat_map(|own| own.weights.iter().copied());
        let by = DMatrix::from_row_iterator(changes.len(), self.len(), weights);
        let numbers = by.try_inverse()? * DVector::from_vec(changes);
        Some(&self.directions * numbers)
    }
}

/// What may change of a robot, and how far its parameters lie apart.
#[derive(Default)]
pub(crate) struct Hypotheses {
    pub(crate) all: Vec<Hypothesis>,
    /// Variance of each parameter among recordings of one unchanged robot, and among robots.
    pub(crate) repeats: Vec<f64>,
    pub(crate) wide: Vec<f64>,
}

impl Hypotheses {
    /// Adds what may change of other parameters.
    pub(super) fn extend(&mut self, other: Self) {
        let [before, behind] = [self.wide.len(), other.wide.len()];
        let padded = |own: &mut Hypothesis, [above, below]: [usize; 2]| {
            let rows = own.directions.nrows();
            let mut all = DMatrix::zeros(above + rows + below, own.len());
            all.rows_mut(above, rows).copy_from(&own.directions);
            own.directions = all;
        };
        for own in &mut self.all {
            padded(own, [0, behind]);
        }
        self.all.extend(other.all.into_iter().map(|mut own| {
            padded(&mut own, [before, 0]);
            own
        }));
        self.repeats.extend(other.repeats);
        self.wide.extend(other.wide);
    }
}

/// Deviation of a parameter that no effect has, and variance of one that repeats.
pub(super) const UNKNOWN: f64 = 0.3;
/// Deviation of changes of wheels and tracks while a robot drives, as a logarithm: a flat tyre, a slippery floor.
pub(super) const CHANGE: f64 = 0.1;
const REPEATS: f64 = 1e-12;
/// Deviation of the bias of a gyro among recordings, and at all (rad/s).
const BIAS_RAD_S: [f64; 2] = [0.005, 0.02];

/// Everything that may change of a robot, without `excluded`.
pub(crate) fn all(learnt: &Learnt, excluded: &[String]) -> Hypotheses {
    let baseline = &learnt.baseline;
    let table = Table::new(&Asked {
        streams: baseline.fitted().streams,
        nominal: &baseline.found.nominal,
        excluded,
        by_run: [false; 3],
    });
    let places: Vec<usize> = learnt
        .parameters
        .iter()
        .map(|own| index(*own, baseline))
        .collect();
    let smooth = table.terms.iter().filter(|term| term.is_smooth());
    let each = smooth.flat_map(|term| term.shown.iter().map(move |shown| (term, shown)));
    let all = each
        .flat_map(|(term, shown)| of(&table, &places, term, shown))
        .collect();
    let alone = |index: &usize| {
        let mut weights = table.weights.iter();
        weights.position(|own| matches!(own[..], [(read, _)] if read == *index))
    };
    let spread = places.iter().map(|index| match alone(index) {
        Some(own) => {
            let prior = table.priors[own].deviation;
            let wide = if table.priors[own].has_tails {
                UNKNOWN
            } else {
                prior
            };
            [table.repeats(own).max(REPEATS), wide * wide]
        }
        None => [REPEATS, UNKNOWN * UNKNOWN],
    });
    let (mut repeats, mut wide): (Vec<f64>, Vec<f64>) = spread.map(|[a, b]| (a, b)).unzip();
    if let Some(bias) = learnt.bias() {
        let [own, most] = BIAS_RAD_S;
        (repeats[bias], wide[bias]) = (own * own, most * most);
    }
    Hypotheses { all, repeats, wide }
}

/// Where a parameter stands among all that the filters read.
fn index(own: Parameter, baseline: &Baseline) -> usize {
    match own {
        Parameter::Machine(i) => i,
        Parameter::Bias => baseline.machine.of_run(0, RUN_BIAS),
        Parameter::Drive(i) => baseline.fitted().streams.of_drive(i),
    }
}

/// An effect, and each of both wheels or what they share alone; nothing of one that other parameters move.
fn of(table: &Table, places: &[usize], term: &Term, shown: &Attribution) -> Vec<Hypothesis> {
    if shown.values.is_empty() {
        return Vec::new();
    }
    let mut directions = DMatrix::zeros(places.len(), shown.parameters.len());
    for (column, parameter) in shown.parameters.iter().enumerate() {
        for (index, weight) in &table.weights[*parameter] {
            match places.iter().position(|own| own == index) {
                Some(line) => directions[(line, column)] += weight,
                None => return Vec::new(),
            }
        }
    }
    let value = |own: &Value| Shown {
        name: own.name,
        link: own.link,
        weights: weights(own, &shown.parameters),
    };
    let deviation = |own: &usize| match table.priors[*own] {
        Prior {
            has_tails: true, ..
        } => CHANGE,
        own => own.deviation,
    };
    let whole = Hypothesis {
        effect: shown.effect,
        plausible: shown
            .parameters
            .iter()
            .map(|own| deviation(own).powi(2))
            .collect(),
        directions,
        values: shown.values.iter().map(value).collect(),
        confused: shown.confused.clone(),
        mirror: shown.mirror,
        inflation: term.inflation,
        cost: term.cost,
        positive: false,
    };
    let mut all = wheels(&whole);
    all.push(whole);
    all
}

fn weights(own: &Value, parameters: &[usize]) -> Vec<f64> {
    let of = |parameter: &usize| own.weights.iter().find(|(index, _)| index == parameter);
    parameters
        .iter()
        .map(|own| of(own).map_or(0.0, |own| own.1))
        .collect()
}

/// Of an effect with a factor for each wheel: one wheel alone, the other, both alike.
pub(super) fn wheels(whole: &Hypothesis) -> Vec<Hypothesis> {
    let [right, left] = whole.values.as_slice() else {
        return Vec::new();
    };
    if whole.len() != 2 {
        return Vec::new();
    }
    let by = DMatrix::from_row_slice(2, 2, &[right.weights.as_slice(), &left.weights].concat());
    let Some(inverse) = by.try_inverse() else {
        return Vec::new();
    };
    let along = |sizes: [f64; 2]| {
        let own = &inverse * DVector::from_column_slice(&sizes);
        let directions = &whole.directions * own;
        let values = whole
            .values
            .iter()
            .zip(sizes)
            .filter(|(_, size)| *size != 0.0);
        Hypothesis {
            directions: DMatrix::from_column_slice(directions.len(), 1, directions.as_slice()),
            plausible: vec![CHANGE * CHANGE],
            values: values
                .map(|(own, size)| Shown {
                    weights: vec![size],
                    ..own.clone()
                })
                .collect(),
            ..whole.clone()
        }
    };
    vec![along([1.0, 0.0]), along([0.0, 1.0]), along([1.0, 1.0])]
}
