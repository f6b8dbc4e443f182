//! Prediction error (`held_out` of the answer): the state at a window's start fitted to its first
//! half second, then simulated open loop.

use rayon::prelude::*;

use crate::windows::bench::{Bench, every_other};
use crate::windows::hypothesis::Hypothesis;
use crate::windows::misfit::Misfit;
use crate::windows::simulate::hardened;
use crate::windows::start;
use crate::windows::track::Sensor;
use crate::windows::unknown::Unknown;
use crate::windows::window::Window;

/// Time over which a window's start is fitted (s), and up to how much more where the pose was seen
/// less often than `SEEN` times in it.
const FITTED_S: f64 = 0.5;
const AT_MOST: u32 = 5;
const SEEN: usize = 5;

/// Misfit of the prediction of `windows` by the model with `hypotheses`, without their first half
/// second.
pub(crate) fn prediction(bench: &Bench, windows: &[Window], hypotheses: &[Hypothesis]) -> Misfit {
    let parts: Vec<Misfit> = windows
        .par_iter()
        .filter_map(|window| one(bench, window, hypotheses))
        .collect();
    parts
        .iter()
        .fold(Misfit::default(), |sum, part| sum.and(part))
}

/// Misfit of the prediction of every window by effects, and by a force outside of the catalogue, fitted
/// to every other one, in turn. A single window is predicted by what was fitted to it.
pub(crate) fn held_out(
    bench: &Bench,
    hypotheses: &[Hypothesis],
    unknown: Option<&Unknown>,
) -> Misfit {
    let windows = &bench.windows;
    let law = |half: Option<usize>| unknown.and_then(|unknown| unknown.law(bench, half));
    let whole = law(None);
    if windows.len() < 2 || hypotheses.is_empty() && whole.is_none() {
        return prediction(&bench.under(whole), windows, hypotheses);
    }
    let folds = (0..2).map(|fold| {
        let bench = &bench.under(law(Some(fold)));
        let learnt = bench.over(every_other(windows, fold)).refitted(hypotheses);
        let learnt = learnt.unwrap_or_else(|| hypotheses.to_vec());
        prediction(bench, &every_other(windows, 1 - fold), &learnt)
    });
    folds.fold(Misfit::default(), |sum, part| sum.and(&part))
}

fn one(bench: &Bench, window: &Window, hypotheses: &[Hypothesis]) -> Option<Misfit> {
    let (mut residuals, fitted_s) = predicted(bench, window, hypotheses)?;
    let acceleration = [0, 1].map(|part| Sensor::Imu.channel() + part);
    let stamped = window.stamps_s.iter().zip(&window.channels);
    for (residual, (stamp_s, channel)) in residuals.iter_mut().zip(stamped) {
        if *stamp_s < window.from_s + fitted_s {
            *residual = f64::NAN;
        } else if acceleration.contains(&usize::from(*channel)) {
            *residual = hardened(*residual);
        }
    }
    Some(Misfit::new(std::slice::from_ref(window), &[residuals]))
}

/// Residuals (deviations) of the prediction of one window, what its start was fitted to included,
/// and how long that is (s).
pub(crate) fn predicted(
    bench: &Bench,
    window: &Window,
    hypotheses: &[Hypothesis],
) -> Option<(Vec<f64>, f64)> {
    let track = &bench.tracks[window.run];
    (1..=AT_MOST).find_map(|times| {
        let fitted_s = FITTED_S * f64::from(times);
        let mut head = window.head(track, fitted_s);
        head.free = window.free;
        let heads = [head];
        bench.posed(hypotheses, &heads, |problem, values| {
            let still = problem.with_free(&[]);
            let guess = start::guess(&still, &[], &heads[0]);
            let seen = still.residuals(&[], &[guess])?.pop()?;
            if times < AT_MOST && window.free[0] && poses(&heads[0], &seen) < SEEN {
                return None;
            }
            let start = still.fit(&[], &[guess], 20)?.starts;
            let own = [window.clone()];
            let residuals = problem.over(&own).residuals(values, &start)?.pop()?;
            Some((residuals, fitted_s))
        })
    })
}

/// How many poses were compared.
fn poses(window: &Window, residuals: &[f64]) -> usize {
    let first = Sensor::Pose.channel();
    let pairs = window.channels.iter().zip(residuals);
    pairs
        .filter(|(c, r)| usize::from(**c) == first && r.is_finite())
        .count()
}

/// Root mean square of a channel, `None` where nothing was measured.
pub(crate) fn level(misfit: &Misfit, channel: usize) -> Option<f64> {
    (misfit.counts[channel] > 0.0).then(|| misfit.mean_square(channel).sqrt())
}

/// Root mean square over all samples of the pose, or of gyro and wheels where there is no pose; zero
/// where nothing of these was measured.
pub(crate) fn total(misfit: &Misfit) -> f64 {
    let pose = 2..5;
    let others = [0, 1, 9];
    let has = |channels: &[usize]| channels.iter().any(|c| misfit.counts[*c] > 0.0);
    let pose: Vec<usize> = pose.collect();
    let channels: &[usize] = if has(&pose) { &pose } else { &others };
    let squares: f64 = channels.iter().map(|c| misfit.squares[*c]).sum();
    let counts: f64 = channels.iter().map(|c| misfit.counts[*c]).sum();
    (squares / counts.max(1.0)).sqrt()
}
