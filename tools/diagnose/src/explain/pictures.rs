//! What the figures of a report show of a machine that is told speeds or nothing.

use super::kinematic::Found;
use super::prediction::{CHANNELS, Errors};
use crate::answer::{Figures, Paths, Point, Residuals};

/// The figures of one machine.
pub(crate) fn figures(robot: &str, found: &Found) -> Figures {
    let has_claims = !found.claims.is_empty();
    let runs = found.errors.iter().enumerate();
    let residuals = runs.clone().flat_map(|(run, [before, after])| {
        (0..CHANNELS.len()).filter_map(move |channel| {
            let deviation = found.deviations[run][channel];
            let before = line(before, channel, deviation, found.origins_s[run]);
            let after = line(after, channel, deviation, found.origins_s[run]);
            (!before.is_empty()).then(|| Residuals {
                run,
                channel: CHANNELS[channel],
                before,
                after: if has_claims { after } else { Vec::new() },
            })
        })
    });
    let paths = runs.filter(|(_, [before, _])| !before.seen.is_empty());
    let paths = paths.map(|(run, [before, after])| Paths {
        run,
        camera: before.seen.clone(),
        before: before.predicted.clone(),
        after: if has_claims {
            after.predicted.clone()
        } else {
            Vec::new()
        },
    });
    Figures {
        robot: robot.to_owned(),
        spans_s: found.spans_s.clone(),
        residuals: residuals.collect(),
        forces: Vec::new(),
        against: Vec::new(),
        paths: paths.collect(),
        limits: Vec::new(),
    }
}

/// Residuals of one channel in standard deviations.
fn line(errors: &Errors, channel: usize, deviation: f64, origin_s: f64) -> Vec<Point> {
    let own = errors.residuals.iter().filter(|(_, c, _)| *c == channel);
    let mut points: Vec<Point> = own
        .map(|(t_s, _, residual)| (t_s + origin_s, residual / deviation))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}
