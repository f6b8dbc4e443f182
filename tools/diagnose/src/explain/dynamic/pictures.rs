//! What the figures of a report show of a machine with masses.

use rayon::prelude::*;

use super::limits::limits;
use super::selection::Selected;
use crate::answer::{Figures, LawCurve, MissingForce, Motion, Point, Profile};
use crate::data::track::{Sensor, Track};
use crate::explain::figures::{OfRun, curve};
use crate::judge::POSE;
use crate::model::hypothesis::Hypothesis;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;
use crate::predict::drawn::Drawn;
use crate::predict::predictor::Predictor;
use crate::predict::window::{WINDOW_S, at_most, cut};

/// Places of a line that the filter draws.
const PLACES: usize = 4000;
/// Sizes of a profile to each side.
const SIZES: i32 = 8;

/// The figures of one machine, whose findings begin at number `first_finding`.
pub(crate) fn figures(
    machine: &Machine,
    predictor: &Predictor,
    selected: &Selected,
    all: &[Hypothesis],
    first_finding: usize,
) -> Figures {
    let hypotheses = &selected.fit.hypotheses;
    let (motion, _) = watched(machine, selected.whole());
    let mut figures = Figures {
        robot: machine.tracks[0].robot.clone(),
        spans_s: machine.tracks.iter().map(Track::span_s).collect(),
        motion,
        forces: forces(machine, selected),
        profiles: profiles(machine, selected, first_finding),
        laws: law(selected, first_finding).into_iter().collect(),
        limits: limits(machine, predictor, &selected.fit, all),
        ..Figures::default()
    };
    for (run, track) in predictor.tracks.iter().enumerate() {
        let before = drawn(predictor, run, &[]);
        let after = (!hypotheses.is_empty()).then(|| drawn(predictor, run, hypotheses));
        let own = OfRun {
            run,
            before: &before,
            after: after.as_ref(),
            origin_s: 0.0,
        };
        let angles = track.of(Sensor::WheelAngle).is_some();
        let headed = track.of(Sensor::Pose).is_some_and(|series| {
            let mut rows = series.rows.iter();
            rows.any(|(_, values)| values[2].is_finite())
        });
        let lines = own.lines([angles, headed], |channel| predictor.deviation(channel));
        figures.errors.extend(lines);
        let span_s = own.span_s(track.span_s(), POSE..POSE + 2);
        figures.paths.extend(own.path(span_s, false));
    }
    figures
}

/// How each run drove, and the force along (N) and moment about (N m) that act on it over time, by the filter.
fn watched(machine: &Machine, fit: &Filtered) -> (Vec<Motion>, Vec<[Vec<Point>; 2]>) {
    let mut all = vec![[const { Vec::new() }; 4]; machine.runs.len()];
    machine.watched(fit, &fit.hypotheses, |run, t_s, state, disturbance| {
        let [surge, _, turn] = state.velocity();
        let values = [surge, turn, disturbance[0], disturbance[1]];
        for (line, value) in all[run].iter_mut().zip(values) {
            line.push((t_s, value));
        }
    });
    let runs = all.iter().enumerate().map(|(run, lines)| {
        let [speed_m_s, turn_rad_s, along, about] =
            [0, 1, 2, 3].map(|i| at_most(&lines[i], PLACES));
        let motion = Motion {
            run,
            speed_m_s,
            turn_rad_s,
        };
        (motion, [along, about])
    });
    runs.unzip()
}

/// The forces that the models miss in each run; without findings the improved model is the nominal one.
fn forces(machine: &Machine, selected: &Selected) -> Vec<MissingForce> {
    let found = !selected.fit.hypotheses.is_empty();
    let [(_, before), (_, after)] =
        [&selected.nominal, &selected.fit].map(|fit| watched(machine, fit));
    let parts = [
        ("missing force along the body", "N"),
        ("missing moment about the vertical", "N m"),
    ];
    let runs = before.into_iter().zip(after).enumerate();
    let each = runs.flat_map(|(run, (before, after))| {
        let lines = parts.into_iter().zip(before).zip(after);
        lines.map(move |(((quantity, unit), before), after)| MissingForce {
            run,
            quantity,
            unit,
            before,
            after: if found { after } else { Vec::new() },
        })
    });
    each.collect()
}

/// The predictions of one run, window by window.
fn drawn(predictor: &Predictor, run: usize, hypotheses: &[Hypothesis]) -> Drawn {
    let windows = cut(&predictor.tracks[run], run, WINDOW_S);
    let each = predictor.residuals(&windows, hypotheses);
    let pairs = windows.iter().zip(each);
    let seen = pairs.filter_map(|(window, residuals)| {
        let mut own = Drawn::new(&predictor.tracks[run], window, &residuals?);
        own.gap(window.to_s);
        Some(own)
    });
    seen.fold(Drawn::default(), Drawn::and)
}

/// How the fit falls with the size of each finding.
fn profiles(machine: &Machine, selected: &Selected, first_finding: usize) -> Vec<Profile> {
    let all = selected.fit.hypotheses.iter().enumerate();
    let named = all.filter(|(_, own)| selected.names(own));
    (first_finding..)
        .zip(named)
        .filter_map(|(finding, (index, _))| profile(machine, &selected.fit, index, finding))
        .collect()
}

/// The same of one finding, at the gains of the fit.
fn profile(machine: &Machine, fit: &Filtered, index: usize, finding: usize) -> Option<Profile> {
    let own = &fit.hypotheses[index];
    if own.is_local() {
        // a place or a moment: its size says little beside it
        return None;
    }
    let (name, value) = *own.values.last()?;
    let likelihoods: Vec<Option<Point>> = sizes(own, value, own.nothing(&machine.model, name))
        .into_par_iter()
        .map(|size| {
            let mut moved = fit.hypotheses.clone();
            moved[index].set(name, size);
            moved[index].keep_in_order();
            let innovations = machine.innovations(fit, &moved)?;
            Some((size, -machine.deviance(&innovations) / 2.0))
        })
        .collect();
    Profile::new(finding, name, likelihoods.into_iter().flatten())
}

/// Sizes around one that was found, from nothing on, or by factors of it where nothing is far.
fn sizes(own: &Hypothesis, found: f64, nothing: f64) -> Vec<f64> {
    let by_factor = own.is_abrupt() || own.is_threshold() || own.has_play();
    let shares = (-SIZES..=SIZES).map(|k| f64::from(k) / f64::from(SIZES));
    shares
        .map(|share| {
            if by_factor {
                found * 2.0_f64.powf(share)
            } else {
                found + share * (found - nothing)
            }
        })
        .collect()
}

/// The force outside of the catalogue as a curve, where it is a table.
fn law(selected: &Selected, first_finding: usize) -> Option<LawCurve> {
    let unknown = selected.unknown.as_ref()?;
    let (knots, values) = unknown.table.as_ref()?;
    let all = selected.fit.hypotheses.iter();
    let finding = first_finding + all.filter(|own| selected.names(own)).count();
    let quantity = match unknown.channel {
        "yaw" => ("moment about the vertical", "N m"),
        _ => ("force along the body", "N"),
    };
    let values = [values.as_slice(), &unknown.half];
    Some(curve(finding, quantity, unknown.driver, knots, values))
}
