//! What the figures of a report show, as plain numbers: residuals, missing forces, paths, and what
//! was ruled out down to which size.

use rayon::prelude::*;
use slipstream_sim::effects::Info;

use crate::answer::Against;
use crate::answer::{Figures, MissingForce, Paths, Point, Residuals};
use crate::diagnosis::Request;
use crate::windows::against::{of_effect, of_unknown};
use crate::windows::bench::{Bench, Node};
use crate::windows::force::Part;
use crate::windows::hypothesis::{self, Hypothesis};
use crate::windows::limits;
use crate::windows::moment::{Moment, acting_on, moments, quantity};
use crate::windows::score;
use crate::windows::track::{CHANNEL_NAMES, CHANNELS, Sensor};
use crate::windows::weigh::Found;
use crate::windows::window::{WINDOW_S, cut};

/// A gap between pieces of a line.
const GAP: Point = (f64::NAN, f64::NAN);

/// Half of the time over which a missing force is shown (s).
const SHOWN_S: f64 = 0.13;
/// What is shown of a machine and what was found on it.
pub(crate) fn figures(bench: &Bench, found: &Found, request: &Request<'_>) -> Figures {
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
    Figures {
        robot,
        spans_s: bench
            .tracks
            .iter()
            .map(crate::windows::track::Track::span_s)
            .collect(),
        residuals: residuals(bench, found),
        forces: over_time(bench, &before, &after),
        against,
        paths: paths(bench, found),
        limits: limits::limits(bench, &all, found),
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
}
