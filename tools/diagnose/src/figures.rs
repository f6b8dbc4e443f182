//! What the figures of a report show, as plain numbers: residuals, missing forces, paths, and what
//! was ruled out down to which size.

use rayon::prelude::*;
use slipstream_sim::CommandKind;
use slipstream_sim::effects::{Info, Variable, When};

use crate::Request;
use crate::bench::{Bench, Node};
use crate::drivers::{Driver, Sampled, rate};
use crate::force::{self, Answers, Part};
use crate::hypothesis::{self, Hypothesis};
use crate::limits::{self, Limit};
use crate::local;
use crate::score;
use crate::track::{CHANNEL_NAMES, CHANNELS, Sensor};
use crate::unknown::Unknown;
use crate::weigh::Found;
use crate::window::{WINDOW_S, cut};

/// A point of a figure: what stands on the axis across, what on the axis up.
pub type Point = (f64, f64);

/// What the figures of one machine show. A point that is not finite is a gap.
#[derive(Debug, Clone)]
pub struct Figures {
    /// The machine.
    pub robot: String,
    /// Begin and end of each of its recordings (s).
    pub spans_s: Vec<[f64; 2]>,
    /// Simulated minus measured, one for each channel of each recording.
    pub residuals: Vec<Residuals>,
    /// The force that the models miss; none for robots that are driven by speeds.
    pub forces: Vec<MissingForce>,
    /// The same against the variable that tells most of each finding.
    pub against: Vec<Against>,
    /// Where the camera saw each run, and where the models predict it.
    pub paths: Vec<Paths>,
    /// From which size on each effect that was not found would have been seen.
    pub limits: Vec<Limit>,
}

/// Residuals of one channel in the windows of the fit: time (s), standard deviations of the sensor.
#[derive(Debug, Clone)]
pub struct Residuals {
    /// Number of the recording, from 0.
    pub run: usize,
    /// As in `held_out`.
    pub channel: &'static str,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A force that a model misses over time (s), estimated every 50 ms without an idea of its cause,
/// and its mean over a quarter of a second without the extremes.
#[derive(Debug, Clone)]
pub struct MissingForce {
    /// Number of the recording, from 0.
    pub run: usize,
    /// What it is, with its unit.
    pub quantity: String,
    /// Of the nominal model.
    pub before: Vec<Point>,
    /// Of the model with what was found; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A missing force against a variable.
#[derive(Debug, Clone)]
pub struct Against {
    /// The finding's effect.
    pub effect: String,
    /// The force, with its unit.
    pub quantity: String,
    /// The variable, with its unit.
    pub variable: String,
    /// Every moment, without the finding.
    pub before: Vec<Point>,
    /// Every moment with what was found; empty for `unknown` and for what is measured.
    pub after: Vec<Point>,
    /// Of an effect outside of the catalogue: the force that was found.
    pub curve: Vec<Point>,
    /// The curve is a function of the variable, not of more.
    pub is_function: bool,
}

/// Paths on the floor (m) in pieces of 5 s: the start of each is fitted to its first half second,
/// the rest is simulated from the commands alone.
#[derive(Debug, Clone)]
pub struct Paths {
    /// Number of the recording, from 0.
    pub run: usize,
    /// Where the camera saw the tracked point.
    pub camera: Vec<Point>,
    /// Where the nominal model has it.
    pub before: Vec<Point>,
    /// Where the model with what was found has it; empty where nothing was found.
    pub after: Vec<Point>,
}

/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);

/// Half of the time over which a missing force is shown (s).
const SHOWN_S: f64 = 0.13;
/// Half of the time over which the camera's speed is taken (s).
const CAMERA_S: f64 = 0.12;

/// A missing force at one moment.
struct Moment {
    run: usize,
    sampled: Sampled,
    /// Along the body (N) and about the vertical (N m).
    force: [f64; 2],
}

impl Figures {
    /// What is shown of a machine and what was found on it.
    pub(crate) fn new(bench: &Bench, found: &Found, request: &Request<'_>) -> Self {
        let robot = bench.tracks[0].robot.clone();
        (request.progress)(&format!("{robot}: figures"));
        let has_findings = !found.node.hypotheses.is_empty();
        let before = moments(bench, &found.nominal).unwrap_or_default();
        let after = has_findings
            .then(|| moments(bench, &found.node))
            .flatten()
            .unwrap_or_default();
        let left = if has_findings { &after } else { &before };
        let mut effects: Vec<&Info> = found.node.hypotheses.iter().map(|h| h.info).collect();
        effects.sort_by_key(|info| info.id);
        effects.dedup();
        let of_effect = |info: &&Info| of_effect(bench, info, &before, &after);
        let mut against: Vec<Against> = effects.iter().flat_map(of_effect).collect();
        if let Some(unknown) = &found.unknown {
            against.extend(of_unknown(bench, unknown, left));
        }
        (request.progress)(&format!("{robot}: what is ruled out"));
        let all = hypothesis::all(&bench.model, &bench.tracks, request.excluded);
        Self {
            robot,
            spans_s: bench
                .tracks
                .iter()
                .map(crate::track::Track::span_s)
                .collect(),
            residuals: residuals(bench, found),
            forces: over_time(bench, &before, &after),
            against,
            paths: paths(bench, found),
            limits: limits::limits(bench, &all, found),
        }
    }
}

fn residuals(bench: &Bench, found: &Found) -> Vec<Residuals> {
    let runs = 0..bench.tracks.len();
    let all = runs.flat_map(|run| (0..CHANNELS).map(move |channel| (run, channel)));
    let all = all.map(|(run, channel)| Residuals {
        run,
        channel: CHANNEL_NAMES[channel],
        before: of_channel(bench, &found.nominal, run, channel),
        after: if found.node.hypotheses.is_empty() {
            Vec::new()
        } else {
            of_channel(bench, &found.node, run, channel)
        },
    });
    all.filter(|residuals| residuals.before.iter().any(|(_, r)| r.is_finite()))
        .collect()
}

/// The residuals of a channel, with a gap between windows.
fn of_channel(bench: &Bench, node: &Node, run: usize, channel: usize) -> Vec<Point> {
    let windows = bench.windows.iter().zip(&node.fit.linear);
    let windows = windows.filter(|(window, _)| window.run == run);
    windows
        .flat_map(|(window, linear)| {
            let rows = window
                .channels
                .iter()
                .zip(&window.stamps_s)
                .zip(&linear.residuals);
            let own = rows.filter(move |((own, _), _)| usize::from(**own) == channel);
            own.map(|((_, t_s), residual)| (*t_s, *residual))
                .chain([GAP])
        })
        .collect()
}

/// The missing force at every pulse around `node`.
fn moments(bench: &Bench, node: &Node) -> Option<Vec<Moment>> {
    let answers: Vec<Answers> = force::answers(bench, node, 1.0)?;
    let forces = local::over_time(bench, node, &answers, &[1.0; CHANNELS]);
    let windows = bench.windows.par_iter().zip(&answers).zip(forces);
    let moments = windows.flat_map_iter(|((window, answers), forces)| {
        let pulses = answers.samples.iter().zip(forces);
        pulses.map(|(sampled, force)| Moment {
            run: window.run,
            sampled: *sampled,
            force,
        })
    });
    Some(moments.collect())
}

fn over_time(bench: &Bench, before: &[Moment], after: &[Moment]) -> Vec<MissingForce> {
    if before.is_empty() {
        return Vec::new();
    }
    let runs = 0..bench.tracks.len();
    let all = runs.flat_map(|run| [Part::Longitudinal, Part::Yaw].map(|part| (run, part)));
    let line = |moments: &[Moment], run: usize, part: Part| -> Vec<Point> {
        let own = moments.iter().filter(|moment| moment.run == run);
        let own = own.map(|moment| (moment.sampled.t_s, acting_on(bench, part, moment)));
        smoothed(&own.collect::<Vec<Point>>())
    };
    let all = all.map(|(run, part)| MissingForce {
        run,
        quantity: quantity(bench, part),
        before: line(before, run, part),
        after: line(after, run, part),
    });
    all.collect()
}

/// The mean of what lies near each point of a line, without the quarters that lie lowest and highest.
fn smoothed(line: &[Point]) -> Vec<Point> {
    let near = |t_s: f64| {
        let first = line.partition_point(|(other_s, _)| *other_s < t_s - SHOWN_S);
        let end = line.partition_point(|(other_s, _)| *other_s <= t_s + SHOWN_S);
        &line[first..end]
    };
    let mean = |points: &[Point]| {
        let mut values: Vec<f64> = points.iter().map(|(_, y)| *y).collect();
        values.sort_by(f64::total_cmp);
        let cut = values.len() / 4;
        let kept = &values[cut..values.len() - cut];
        kept.iter().sum::<f64>() / kept.len() as f64
    };
    line.iter()
        .map(|(t_s, _)| (*t_s, mean(near(*t_s))))
        .collect()
}

/// What a missing force and moment are on one part of the robot (N, N m): along the body, about the
/// vertical, or torques of the wheels that make both. Or speed and turn rate (m/s, rad/s), and speeds
/// of wheels.
fn acting_on(bench: &Bench, part: Part, moment: &Moment) -> f64 {
    let body = &bench.model.robot;
    let [r, b] = [body.wheel_radius_m, body.half_track_m];
    let [along, about] = moment.force;
    match part {
        Part::Longitudinal => along,
        Part::Yaw => about,
        Part::WheelRight if bench.lacks_motion() => (along + about * b) / r,
        Part::WheelLeft if bench.lacks_motion() => (along - about * b) / r,
        Part::WheelRight => r * (along + about / b) / 2.0,
        Part::WheelLeft => r * (along - about / b) / 2.0,
    }
}

fn quantity(bench: &Bench, part: Part) -> String {
    let [what, unit] = part.quantity(bench.lacks_motion());
    format!("missing {what} ({unit})")
}

/// The parts and the names of the variables that tell most of an effect.
fn telling(info: &Info) -> impl Iterator<Item = (Part, &'static str)> {
    info.follows.iter().filter_map(|(channel, variable)| {
        let part = Part::ALL
            .into_iter()
            .find(|part| part.name() == channel.name())?;
        let name = match variable {
            Variable::Speed => "v",
            Variable::TurnRate => "w",
            Variable::Heading => "heading",
            Variable::Command => "torque",
        };
        Some((part, name))
    })
}

/// The variables over which the slip of wheels is shown.
fn slip_over(info: &Info) -> &'static [&'static str] {
    match info.acts {
        When::Sliding => &["torque"],
        When::Inside => &["x", "y"],
        _ => &[],
    }
}

fn of_effect(bench: &Bench, info: &Info, before: &[Moment], after: &[Moment]) -> Vec<Against> {
    let slip = of_slip(bench, info, before);
    if !slip.is_empty() {
        return slip;
    }
    let samples: Vec<Vec<Sampled>> = vec![before.iter().map(|m| m.sampled).collect()];
    let drivers = Driver::all(&samples);
    let parts = telling(info).filter_map(|(part, name)| {
        let driver = drivers.iter().find(|driver| driver.name == name)?;
        let points = |moments: &[Moment]| -> Vec<Point> {
            let all = moments.iter().map(|moment| {
                let z = driver.shown(driver.variable(&moment.sampled, part));
                (z, acting_on(bench, part, moment))
            });
            all.collect()
        };
        Some(Against {
            effect: info.id.to_owned(),
            quantity: quantity(bench, part),
            variable: variable(bench, driver, part),
            before: points(before),
            after: points(after),
            curve: Vec::new(),
            is_function: true,
        })
    });
    parts.collect()
}

/// How much faster the wheels turn than the body moves, as encoders and camera saw it: no force can
/// stand for slip. Nothing without both.
fn of_slip(bench: &Bench, info: &Info, moments: &[Moment]) -> Vec<Against> {
    let slip = |moment: &Moment| -> Option<f64> {
        let track = &bench.tracks[moment.run];
        track.of(Sensor::WheelAngle)?;
        let s = &moment.sampled;
        let [dx, dy, _] = rate(track.of(Sensor::Pose)?, s.t_s, CAMERA_S);
        Some(s.v - dx * s.pose[2].cos() - dy * s.pose[2].sin())
    };
    let samples: Vec<Vec<Sampled>> = vec![moments.iter().map(|m| m.sampled).collect()];
    let drivers = Driver::all(&samples);
    let over = slip_over(info).iter().filter_map(|name| {
        let driver = drivers.iter().find(|driver| driver.name == *name)?;
        let part = Part::Longitudinal;
        let points = moments
            .iter()
            .filter_map(|m| Some((driver.variable(&m.sampled, part), slip(m)?)));
        Some(Against {
            effect: info.id.to_owned(),
            quantity: "wheels faster than the body (m/s)".to_owned(),
            variable: variable(bench, driver, part),
            before: points.collect(),
            after: Vec::new(),
            curve: Vec::new(),
            is_function: true,
        })
    });
    over.filter(|against| against.before.iter().any(|(_, slip)| slip.is_finite()))
        .collect()
}

/// A variable in words, with its unit.
fn variable(bench: &Bench, driver: &Driver, part: Part) -> String {
    let commanded = match bench.tracks[0].kind() {
        CommandKind::Voltage => "voltage (V)",
        CommandKind::Torque => "torque (N m)",
        CommandKind::Speed => "wheel speed (rad/s)",
    };
    match (driver.name, part) {
        ("t", _) => "t (s)".to_owned(),
        ("v", _) => "forward speed (m/s)".to_owned(),
        ("w", _) => "yaw rate (rad/s)".to_owned(),
        ("torque", Part::WheelRight | Part::WheelLeft) => format!("commanded {commanded}"),
        ("torque", Part::Yaw) => format!("commanded right minus left {commanded}"),
        ("torque", Part::Longitudinal) => format!("commanded right plus left {commanded}"),
        ("wheel_angle", Part::WheelLeft) => "angle of the left wheel in its turn (rad)".to_owned(),
        ("wheel_angle", _) => "angle of the right wheel in its turn (rad)".to_owned(),
        ("heading", _) => "heading (rad)".to_owned(),
        ("time_at_rest", _) => "time at rest (s)".to_owned(),
        (name, _) => format!("{name} ({})", driver.unit),
    }
}

/// The force outside of the catalogue. What follows the position is shown over both of its axes.
fn of_unknown(bench: &Bench, unknown: &Unknown, left: &[Moment]) -> Vec<Against> {
    let missing = &unknown.missing;
    let (part, driver) = (missing.part, &missing.driver);
    let opposes = |s: &Sampled| match (missing.against, part) {
        (false, _) => 1.0,
        (true, Part::Yaw) => opposing(s.w),
        (true, _) => opposing(s.v),
    };
    let is_function = driver.name != "position";
    let way = if missing.against {
        ", against the motion"
    } else {
        ""
    };
    let axes: &[&str] = if is_function {
        &[""]
    } else {
        driven_over(left)
    };
    let across = |axis: &str, s: &Sampled| match axis {
        "x (m)" => s.pose[0],
        "y (m)" => s.pose[1],
        _ => driver.shown(driver.variable(s, part)),
    };
    let of_axis = |axis: &&str| {
        let points = left.iter().map(|moment| {
            let force = acting_on(bench, part, moment) * opposes(&moment.sampled);
            (across(axis, &moment.sampled), force)
        });
        let curve = left.iter().map(|moment| {
            let force = driver.force(&missing.weights, &moment.sampled, part);
            (across(axis, &moment.sampled), force)
        });
        let mut curve: Vec<Point> = curve.filter(|(z, _)| z.is_finite()).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        Against {
            effect: "unknown".to_owned(),
            quantity: quantity(bench, part).replace(" (", &format!("{way} (")),
            variable: if axis.is_empty() {
                variable(bench, driver, part)
            } else {
                (*axis).to_owned()
            },
            before: points.collect(),
            after: Vec::new(),
            curve,
            is_function,
        }
    };
    axes.iter().map(of_axis).collect()
}

/// The axes of the floor along which the robot went at least a tenth as far as along the other.
fn driven_over(moments: &[Moment]) -> &'static [&'static str] {
    let length = |i: usize| {
        let places = moments
            .iter()
            .map(|moment| moment.sampled.pose[i])
            .filter(|v| v.is_finite());
        let empty = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = places.fold(empty, |(low, high), v| (low.min(v), high.max(v)));
        high - low
    };
    match (length(0), length(1)) {
        (x, y) if y < 0.1 * x => &["x (m)"],
        (x, y) if x < 0.1 * y => &["y (m)"],
        _ => &["x (m)", "y (m)"],
    }
}

/// The sign that makes a force count against the motion; none where it stands still.
fn opposing(speed: f64) -> f64 {
    if force::is_still(speed) {
        f64::NAN
    } else {
        -speed.signum()
    }
}

fn paths(bench: &Bench, found: &Found) -> Vec<Paths> {
    let runs = bench.tracks.iter().enumerate();
    let with_camera = runs.filter(|(_, track)| track.of(Sensor::Pose).is_some());
    let paths = with_camera.map(|(run, _)| {
        let [camera, before] = path(bench, run, &[]);
        let hypotheses = &found.node.hypotheses;
        let unknown = found.unknown.as_ref();
        let law = unknown.and_then(|unknown| unknown.law(bench, None));
        let after = if hypotheses.is_empty() && law.is_none() {
            Vec::new()
        } else {
            let [_, after] = path(&bench.under(law), run, hypotheses);
            after
        };
        Paths {
            run,
            camera,
            before,
            after,
        }
    });
    paths.collect()
}

/// Where the camera saw a run and where the model with `hypotheses` predicts it, in pieces.
fn path(bench: &Bench, run: usize, hypotheses: &[Hypothesis]) -> [Vec<Point>; 2] {
    let track = &bench.tracks[run];
    let Some(which) = track
        .series
        .iter()
        .position(|series| series.sensor == Sensor::Pose)
    else {
        return [Vec::new(), Vec::new()];
    };
    let series = &track.series[which];
    let windows = cut(track, run, WINDOW_S, &[]);
    let pieces = windows.par_iter().map(|window| {
        let predicted = score::predicted(bench, window, hypotheses);
        let (residuals, _) = predicted.unwrap_or_default();
        let (seen, predicted): (Vec<Point>, Vec<Point>) = window
            .measured(track, which)
            .map(|(_, pose, base)| {
                let residual = |i: usize| residuals.get(base + i).copied().unwrap_or(f64::NAN);
                let at = |i: usize| pose[i] + residual(i) * series.deviation[i];
                ((pose[0], pose[1]), (at(0), at(1)))
            })
            .unzip();
        [seen, predicted]
    });
    let pieces: Vec<[Vec<Point>; 2]> = pieces.collect();
    [0, 1].map(|i| {
        pieces
            .iter()
            .flat_map(|piece| piece[i].iter().copied().chain([GAP]))
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_sim::effects::{CATALOGUE, Place};

    /// What misses a force is shown against something, what only a sensor or a link shows is not, nor
    /// is a push, which the force over time shows.
    #[test]
    fn every_force_has_a_telling_variable() {
        for info in CATALOGUE {
            let elsewhere = matches!(info.place, Place::Sensor | Place::Link);
            let nothing = telling(info).next().is_none() && slip_over(info).is_empty();
            let expected = elsewhere || info.acts == When::Once;
            assert_eq!(nothing, expected, "{}", info.id);
        }
    }

    #[test]
    fn smoothing_keeps_a_straight_line() {
        let line: Vec<Point> = (0..40)
            .map(|i| f64::from(i) * 0.05)
            .map(|t| (t, 2.0 * t))
            .collect();
        let smooth = smoothed(&line);
        assert_eq!(smooth.len(), line.len());
        let inside = smooth[4..36].iter();
        assert!(
            inside
                .zip(&line[4..36])
                .all(|(a, b)| (a.1 - b.1).abs() < 1e-12)
        );
    }

    #[test]
    fn a_robot_at_rest_has_no_motion_to_oppose() {
        assert!(opposing(1e-4).is_nan());
        assert_eq!([opposing(0.3), opposing(-0.3)], [-1.0, 1.0]);
    }
}
