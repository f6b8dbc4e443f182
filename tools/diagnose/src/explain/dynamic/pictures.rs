//! What the figures of a report show of a machine with masses.

use rayon::prelude::*;

use super::limits::limits;
use super::selection::Selected;
use crate::answer::{ErrorLine, Figures, LawCurve, MissingForce, Motion, Paths, Point, Profile};
use crate::data::track::{CHANNEL_NAMES, CHANNELS, Sensor, Track};
use crate::explain::drawn_span::drawn_span;
use crate::model::hypothesis::Hypothesis;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;
use crate::predict::misfit::Misfit;
use crate::predict::predictor::{Predictor, unit};
use crate::predict::window::{WINDOW_S, Window, cut};

/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);
/// Places of a line that the filter draws.
const PLACES: usize = 4000;
/// Sizes of a profile to each side, and windows by which it is predicted.
const SIZES: i32 = 8;
const WINDOWS: usize = 8;

/// One run predicted window by window.
struct Predicted {
    /// Errors of each channel, in its unit; places as seen from the robot.
    errors: Vec<Vec<Point>>,
    /// Time (s), where it was seen, and where it is predicted (m).
    path: Vec<(f64, Point, Point)>,
}

/// The figures of one machine, whose findings begin at number `first_finding`.
pub(crate) fn figures(
    machine: &Machine,
    predictor: &Predictor,
    selected: &Selected,
    all: &[Hypothesis],
    first_finding: usize,
) -> Figures {
    let found = !selected.fit.hypotheses.is_empty();
    let mut figures = Figures {
        robot: machine.tracks[0].robot.clone(),
        runs: names(machine),
        spans_s: machine.tracks.iter().map(Track::span_s).collect(),
        motion: motion(machine, selected.whole()),
        forces: forces(machine, selected, found),
        profiles: profiles(machine, predictor, selected, first_finding),
        laws: law(selected, first_finding).into_iter().collect(),
        limits: limits(machine, predictor, &selected.fit, all),
        ..Figures::default()
    };
    for run in 0..machine.runs.len() {
        let before = of_run(predictor, run, &[]);
        let after = found.then(|| of_run(predictor, run, &selected.fit.hypotheses));
        figures
            .errors
            .extend(lines(predictor, run, &before, after.as_ref()));
        figures
            .paths
            .extend(path(predictor, run, &before, after.as_ref()));
    }
    figures
}

/// Name of each run: of its recording where there are several, else of its robot.
fn names(machine: &Machine) -> Vec<String> {
    let tracks = &machine.tracks;
    let alone = tracks
        .iter()
        .all(|own| own.recording == tracks[0].recording);
    let named = tracks.iter().map(|own| {
        let name = if alone { &own.robot } else { &own.recording };
        name.clone()
    });
    named.collect()
}

/// How each run drove, by the filter.
fn motion(machine: &Machine, fit: &Filtered) -> Vec<Motion> {
    let mut all: Vec<Motion> = (0..machine.runs.len())
        .map(|run| Motion {
            run,
            speed_m_s: Vec::new(),
            turn_rad_s: Vec::new(),
        })
        .collect();
    machine.watched(fit, &fit.hypotheses, |run, t_s, state, _| {
        let [surge, _, turn] = state.velocity();
        all[run].speed_m_s.push((t_s, surge));
        all[run].turn_rad_s.push((t_s, turn));
    });
    for motion in &mut all {
        motion.speed_m_s = thinned(&motion.speed_m_s);
        motion.turn_rad_s = thinned(&motion.turn_rad_s);
    }
    all
}

/// At most [`PLACES`] points.
fn thinned(points: &[Point]) -> Vec<Point> {
    let stride = points.len().div_ceil(PLACES).max(1);
    points.iter().copied().step_by(stride).collect()
}

/// The disturbances along and about that the filter estimates over time (N, N m), of each run.
fn missing(machine: &Machine, fit: &Filtered) -> Vec<[Vec<Point>; 2]> {
    let mut all = vec![[Vec::new(), Vec::new()]; machine.runs.len()];
    machine.watched(fit, &fit.hypotheses, |run, t_s, _, disturbance| {
        all[run][0].push((t_s, disturbance[0]));
        all[run][1].push((t_s, disturbance[1]));
    });
    let runs = all.into_iter();
    runs.map(|lines| lines.map(|line| thinned(&line))).collect()
}

/// The forces that the models miss in each run; without findings the improved model is the nominal one.
fn forces(machine: &Machine, selected: &Selected, found: bool) -> Vec<MissingForce> {
    let before = missing(machine, &selected.nominal);
    let after = missing(machine, &selected.fit);
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

fn of_run(predictor: &Predictor, run: usize, hypotheses: &[Hypothesis]) -> Predicted {
    let simulated = predictor.simulated(hypotheses);
    let track = &predictor.tracks[run];
    let mut out = Predicted {
        errors: vec![Vec::new(); CHANNELS],
        path: Vec::new(),
    };
    for window in cut(track, run, WINDOW_S) {
        let predicted = simulated
            .as_ref()
            .and_then(|simulated| predictor.predicted(simulated, &window));
        if let Some((residuals, _)) = predicted {
            out.add(track, &window, &residuals);
        }
    }
    out
}

impl Predicted {
    fn add(&mut self, track: &Track, window: &Window, residuals: &[f64]) {
        for (which, series) in track.series.iter().enumerate() {
            let first = series.sensor.channel();
            for (t_s, values, base) in window.measured(track, which) {
                let mut error = [0, 1, 2].map(|part| {
                    let own = (part < series.sensor.width()).then(|| residuals.get(base + part));
                    own.flatten().copied().unwrap_or(f64::NAN) * series.deviation[part]
                });
                if series.sensor == Sensor::Pose {
                    let place = (values[0] + error[0], values[1] + error[1]);
                    self.path.push((t_s, (values[0], values[1]), place));
                    if values[2].is_finite() {
                        let (sin, cos) = values[2].sin_cos();
                        let [dx, dy, _] = error;
                        (error[0], error[1]) = (dx * cos + dy * sin, dy * cos - dx * sin);
                    }
                }
                for (part, error) in error.into_iter().enumerate() {
                    if part < series.sensor.width()
                        && let Some(line) = self.errors.get_mut(first + part)
                    {
                        line.push((t_s, error));
                    }
                }
            }
        }
        self.errors.iter_mut().for_each(|line| line.push(GAP));
        self.path.push((window.to_s, GAP, GAP));
    }
}

/// Errors of each channel of one run.
fn lines(
    predictor: &Predictor,
    run: usize,
    before: &Predicted,
    after: Option<&Predicted>,
) -> Vec<ErrorLine> {
    let track = &predictor.tracks[run];
    let headed = track.of(Sensor::Pose).is_some_and(|series| {
        let seen = series
            .rows
            .iter()
            .filter(|(_, values)| values[2].is_finite());
        seen.count() > 0
    });
    let angles = track.of(Sensor::WheelAngle).is_some();
    let names = CHANNEL_NAMES.iter().enumerate().take(CHANNELS);
    names
        .filter(|(channel, _)| before.errors[*channel].iter().any(|(_, r)| r.is_finite()))
        .map(|(channel, name)| ErrorLine {
            run,
            quantity: match *name {
                "pose_x" if headed => "forward",
                "pose_y" if headed => "sideways",
                "pose_yaw" => "heading",
                name => name,
            },
            unit: unit(channel, angles),
            deviation: predictor.deviation(channel),
            before: before.errors[channel].clone(),
            after: after.map_or_else(Vec::new, |after| after.errors[channel].clone()),
        })
        .collect()
}

/// The path of one run; of a long one the minute that loses most error.
fn path(
    predictor: &Predictor,
    run: usize,
    before: &Predicted,
    after: Option<&Predicted>,
) -> Option<Paths> {
    let sides = [(Some(before), 1.0), (after, -1.0)].into_iter();
    let squares = sides.flat_map(|(path, sign)| {
        let rows = path.into_iter().flat_map(|own| &own.path);
        rows.map(move |(t_s, seen, place)| {
            let square = (seen.0 - place.0).powi(2) + (seen.1 - place.1).powi(2);
            (*t_s, sign * square)
        })
    });
    let span_s = drawn_span(predictor.tracks[run].span_s(), squares);
    let within = |path: &Predicted, of: fn(&(f64, Point, Point)) -> Point| -> Vec<Point> {
        let own = path
            .path
            .iter()
            .filter(|row| row.0 >= span_s[0] && row.0 <= span_s[1]);
        own.map(of).collect()
    };
    let seen = within(before, |row| row.1);
    seen.iter().any(|(x, _)| x.is_finite()).then(|| Paths {
        run,
        span_s,
        in_pieces: true,
        by_wheels: false,
        before: within(before, |row| row.2),
        after: after.map_or_else(Vec::new, |after| within(after, |row| row.2)),
        seen,
    })
}

/// Error against the size of each finding.
fn profiles(
    machine: &Machine,
    predictor: &Predictor,
    selected: &Selected,
    first_finding: usize,
) -> Vec<Profile> {
    let hypotheses = &selected.fit.hypotheses;
    let named = hypotheses
        .iter()
        .enumerate()
        .filter(|(_, own)| selected.names(own));
    named
        .enumerate()
        .filter_map(|(k, (index, _))| {
            profile(machine, predictor, hypotheses, index, first_finding + k)
        })
        .collect()
}

fn profile(
    machine: &Machine,
    predictor: &Predictor,
    hypotheses: &[Hypothesis],
    index: usize,
    finding: usize,
) -> Option<Profile> {
    let own = &hypotheses[index];
    if own.is_local() {
        // a place or a moment: its size says little beside it
        return None;
    }
    let (name, value) = *own.values.last()?;
    let nothing = own.nothing(&machine.model, name);
    let by_factor = own.is_abrupt() || own.is_threshold() || own.has_play();
    let windows = predictor.some_windows(WINDOWS);
    let sizes = (-SIZES..=SIZES).into_par_iter().map(|k| {
        let share = f64::from(k) / f64::from(SIZES);
        if by_factor {
            value * 2.0_f64.powf(share)
        } else {
            value + share * (value - nothing)
        }
    });
    let worth: Vec<(f64, Misfit)> = sizes
        .map(|size| {
            let mut moved = hypotheses.to_vec();
            moved[index].set(name, size);
            moved[index].keep_in_order();
            (size, predictor.misfit(&windows, &moved))
        })
        .collect();
    let has = |channels: &[usize]| {
        let mut all = worth.iter();
        all.all(|(_, own)| channels.iter().all(|c| own.has(*c)))
    };
    let (unit, channels) = [("m", &[2, 3][..]), ("rad", &[4]), ("wheel", &[0, 1])]
        .into_iter()
        .find(|(_, channels)| has(channels))?;
    let points = worth.iter().map(|(size, own)| {
        let squares = channels
            .iter()
            .map(|c| own.mean_square(*c) * predictor.deviation(*c).powi(2));
        (*size, squares.sum::<f64>().sqrt())
    });
    Some(Profile {
        finding,
        parameter: name,
        unit,
        points: points.collect(),
    })
}

/// The force outside of the catalogue as a curve, where it is a table.
fn law(selected: &Selected, first_finding: usize) -> Option<LawCurve> {
    let unknown = selected.unknown.as_ref()?;
    let (knots, values) = unknown.table.as_ref()?;
    let named = selected
        .fit
        .hypotheses
        .iter()
        .filter(|own| selected.names(own));
    let at = |sign: f64| -> Vec<Point> {
        let values = values.iter().zip(&unknown.half);
        let values = values.map(|(value, half)| value + sign * half);
        knots.iter().copied().zip(values).collect()
    };
    let (quantity, unit) = if unknown.channel == "yaw" {
        ("moment about the vertical", "N m")
    } else {
        ("force along the body", "N")
    };
    Some(LawCurve {
        finding: first_finding + named.count(),
        quantity,
        unit,
        driver: unknown.driver,
        curve: at(0.0),
        band: [at(-1.0), at(1.0)],
    })
}
