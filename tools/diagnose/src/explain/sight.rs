//! From which size on an effect that was not found would have been found: what these recordings cannot show.

use super::calibration::Calibration;
use super::drive::DriveFit;
use super::drive_terms::{is_nuisance, terms_of};
use super::terms;
use crate::answer::Detectable;
use crate::estimate::cluster::Precision;
use crate::estimate::scoring::{Fit, Problem};
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::drive::{DEAD_ZONE, DELAY, GAIN, GAIN_ASYMMETRY, LAG, SAG};
use crate::model::from_wheels::{
    ASYMMETRY, COMMON, FromWheels, GYRO_LATENCY, GYRO_RATE, OFFSET_X, OFFSET_Y, OFFSET_YAW,
    POSE_LATENCY, POSE_RATE, TRACK, View,
};
use crate::select::criterion::Criterion;
use crate::select::elimination::{KNOWN_SHARE, LEAST_APART, Selected, Term};

/// Deviations from which on an effect would have been found.
pub(super) const SIGMAS: f64 = 4.5;

/// A parameter of the catalogue as a sum of parameters of a fit.
struct Sight {
    effect: &'static str,
    parameter: &'static str,
    unit: &'static str,
    /// Its logarithm is fitted.
    is_factor: bool,
    weights: &'static [(usize, f64)],
}

const fn plain(
    effect: &'static str,
    parameter: &'static str,
    unit: &'static str,
    weights: &'static [(usize, f64)],
) -> Sight {
    Sight {
        effect,
        parameter,
        unit,
        is_factor: false,
        weights,
    }
}

const fn factor(
    effect: &'static str,
    parameter: &'static str,
    weights: &'static [(usize, f64)],
) -> Sight {
    Sight {
        is_factor: true,
        ..plain(effect, parameter, "1", weights)
    }
}

/// What wheels and a reference show.
const OF_REFERENCE: [Sight; 10] = [
    factor(
        "wheel_radius",
        "right_scale",
        &[(COMMON, 1.0), (ASYMMETRY, 0.5)],
    ),
    factor(
        "wheel_radius",
        "left_scale",
        &[(COMMON, 1.0), (ASYMMETRY, -0.5)],
    ),
    factor("track_width", "scale", &[(TRACK, 1.0)]),
    plain("pose_offset", "x_m", "m", &[(OFFSET_X, 1.0)]),
    plain("pose_offset", "y_m", "m", &[(OFFSET_Y, 1.0)]),
    plain("pose_offset", "yaw_rad", "rad", &[(OFFSET_YAW, 1.0)]),
    plain("pose_latency", "latency_s", "s", &[(POSE_LATENCY, 1.0)]),
    plain("clock_drift", "rate", "s/s", &[(POSE_RATE, 1.0)]),
    plain("imu_latency", "latency_s", "s", &[(GYRO_LATENCY, 1.0)]),
    plain("clock_drift", "rate", "s/s", &[(GYRO_RATE, 1.0)]),
];

/// What commands and wheels show.
const OF_DRIVE: [Sight; 6] = [
    plain("actuator_delay", "delay_s", "s", &[(DELAY, 1.0)]),
    plain("actuator_lag", "time_constant_s", "s", &[(LAG, 1.0)]),
    factor("motor_gain", "right", &[(GAIN, 1.0), (GAIN_ASYMMETRY, 0.5)]),
    factor("motor_gain", "left", &[(GAIN, 1.0), (GAIN_ASYMMETRY, -0.5)]),
    plain(
        "command_dead_zone",
        "speed_rad_s",
        "rad/s",
        &[(DEAD_ZONE, 1.0)],
    ),
    plain("supply_sag", "rate_per_s", "1/s", &[(SAG, 1.0)]),
];

/// A fit and what it was asked for.
struct Asked<'a> {
    problem: &'a Problem<'a>,
    found: &'a Selected,
    terms: Vec<Term>,
    criterion: Criterion,
}

/// What calibration and drive would have shown, but for effects of `found`.
pub(super) fn detectable(
    robot: &str,
    (machine, nominal): (&FromWheels, &[f64]),
    calibration: Option<&Calibration>,
    driven: Option<(&CommandToWheels, &DriveFit)>,
    excluded: &[String],
) -> Vec<Detectable> {
    let mut all = Vec::new();
    if let Some(own) = calibration {
        let joint = own.joint.as_ref();
        let machine = joint.map_or(machine, |own| &own.machine);
        let nominal = joint.map_or(nominal, |own| &own.nominal);
        let view = View {
            machine,
            robust: true,
        };
        let asked = Asked {
            problem: &machine.problem(&view, nominal),
            found: joint.map_or(&own.after, |own| &own.after),
            terms: terms::terms(machine, excluded, [false; 2]),
            criterion: own.criterion,
        };
        all.extend(asked.each(robot, &OF_REFERENCE));
    }
    if let Some((machine, own)) = driven {
        let mut terms = terms_of(machine, excluded);
        terms.retain(|term| !is_nuisance(term) && !term.by_profile);
        let asked = Asked {
            problem: &machine.problem(machine, &own.nominal),
            found: &own.after,
            terms,
            criterion: own.criterion,
        };
        all.extend(asked.each(robot, &OF_DRIVE));
    }
    all
}

/// What would be known of a term beside what was found; its parameters come first.
pub(super) fn beside(problem: &Problem<'_>, fit: &Fit, term: &Term) -> Option<Precision> {
    let own = term.parameters.iter().copied();
    let others = fit.free.iter().copied();
    let others = others.filter(|i| !term.parameters.contains(i));
    let mut beside = Fit {
        free: own.chain(others).collect(),
        ..fit.clone()
    };
    for index in &term.parameters {
        // at exactly 0 a law or a threshold has no derivative
        beside.at[*index] += f64::MIN_POSITIVE;
    }
    Precision::new(problem, &beside, beside.free.len())
}

impl Asked<'_> {
    fn each(&self, robot: &str, sights: &[Sight]) -> Vec<Detectable> {
        let mut all = Vec::new();
        for term in &self.terms {
            if self.found.kept(term.name).is_some() {
                continue;
            }
            let precision = beside(self.problem, &self.found.fit, term);
            let own = sights.iter().filter(|sight| {
                let mut parts = sight.weights.iter();
                parts.all(|(index, _)| term.parameters.contains(index))
            });
            for sight in own {
                let known = precision.as_ref().filter(|own| self.is_known(term, own));
                let size = known.map(|own| self.size(term, own, sight.weights));
                let size = size.filter(|own| own.is_finite());
                all.push(Detectable {
                    robot: robot.to_owned(),
                    effect: sight.effect,
                    parameter: sight.parameter,
                    unit: sight.unit,
                    smallest: size.map(|own| if sight.is_factor { own.exp_m1() } else { own }),
                });
            }
        }
        all
    }

    /// Whether the data say more of a term than its prior does.
    fn is_known(&self, term: &Term, precision: &Precision) -> bool {
        let mut all = term.parameters.iter().enumerate();
        all.all(|(place, index)| {
            let prior = self.problem.priors[*index].deviation;
            precision.covariance[(place, place)] < KNOWN_SHARE * prior * prior
        })
    }

    /// The size from which on both tests of a term are passed.
    fn size(&self, term: &Term, precision: &Precision, weights: &[(usize, f64)]) -> f64 {
        let apart = self.problem.likelihood.apart(&self.found.fit.at);
        let apart = apart.max(LEAST_APART);
        let places: Vec<(usize, f64)> = weights
            .iter()
            .filter_map(|(index, weight)| {
                let place = term.parameters.iter().position(|own| own == index)?;
                Some((place, *weight))
            })
            .collect();
        let variance = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            let pairs = places
                .iter()
                .flat_map(|a| places.iter().map(move |b| (a, b)));
            pairs.map(|((i, u), (k, w))| u * w * of(*i, *k)).sum()
        };
        let own = variance(&|i, k| precision.covariance[(i, k)]) * term.caution * term.caution;
        let floors = places.iter();
        let floors = floors.map(|(i, w)| w * w * apart * (term.floors[*i] + term.unnoticed[*i]));
        let by_blocks = SIGMAS * (own + floors.sum::<f64>()).sqrt();
        let least = self.criterion.least_gain(term.parameters.len());
        let expected = variance(&|i, k| precision.expected[(i, k)]);
        let by_gain = (2.0 * least * precision.overdispersion * expected).sqrt();
        by_blocks.max(by_gain)
    }
}
