//! References that do not follow from the wheels: poses and the gyro.

use slipstream_recording::recording::Robot;

use super::matched::Stamps;
use super::streams;
use crate::data::wheel_path::median_interval;

/// Rows that a reference needs.
const LEAST_POSES: usize = 2;
const LEAST_RATES: usize = 40;
/// Time between the rows of a thinned series (s): poses, gyro.
pub(crate) const POSE_STEP_S: f64 = 0.5;
const GYRO_STEP_S: f64 = 0.25;
/// Most rows of one series, and of all series together.
const SERIES_ROWS: f64 = 1000.0;
const ALL_ROWS: f64 = 2500.0;
/// Most interleaved series.
const MOST_SERIES: f64 = 5.0;
/// A pose may lie this far outside of the wheels' rows (s).
const BEYOND_S: f64 = 0.3;

/// Steps of the reference over which its noise is small beside its way (s).
const WAY_STEP_S: f64 = 0.5;

/// A row of poses: stamp (s) and x (m), y (m), yaw (rad); NaN where a component was not seen.
pub(crate) type PoseRow = (f64, [f64; 3]);

/// Rows of a stream, and the same thinned.
#[derive(Debug, Clone, Default)]
pub(crate) struct Thinned<R> {
    pub(crate) all: Vec<R>,
    pub(crate) series: Vec<Vec<R>>,
}

/// Times that are ignored, and the time (s) that counts as zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span<'a> {
    pub(crate) origin_s: f64,
    pub(crate) excluded_s: &'a [[f64; 2]],
    /// First and last row of the wheels, counted from `origin_s`.
    pub(crate) wheels_s: [f64; 2],
}

impl Span<'_> {
    fn has(&self, stamp_s: f64, beyond_s: f64) -> bool {
        let [from_s, to_s] = self.wheels_s;
        let t_s = stamp_s - self.origin_s;
        let excluded = self
            .excluded_s
            .iter()
            .any(|[a, b]| (*a..=*b).contains(&stamp_s));
        (from_s - beyond_s..=to_s + beyond_s).contains(&t_s) && !excluded
    }
}

/// Poses of a robot; `None` with too few.
pub(crate) fn poses(robot: &Robot, span: Span<'_>) -> Option<Thinned<PoseRow>> {
    let mut all: Vec<PoseRow> = Vec::new();
    let placed = streams::poses(robot)?.into_iter();
    for (stamp_s, row) in placed.filter(|(_, [x, y, _])| x.is_finite() && y.is_finite()) {
        let t_s = stamp_s - span.origin_s;
        if span.has(stamp_s, BEYOND_S) && all.last().is_none_or(|(last, _)| t_s > *last) {
            all.push((t_s, row));
        }
    }
    let series = thinned(&all, &times(&all), POSE_STEP_S);
    (all.len() >= LEAST_POSES).then_some(Thinned { all, series })
}

/// The gyro of a robot as rates (`all`) and integrated (`series`); `None` with too few rows.
pub(crate) fn gyro(
    robot: &Robot,
    span: Span<'_>,
    wheel_interval_s: f64,
) -> Option<Thinned<(f64, f64)>> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (stamp_s, rate) in streams::turn_rates(robot)? {
        let t_s = stamp_s - span.origin_s;
        let later = all.last().is_none_or(|(last, _)| t_s > *last);
        if rate.is_finite() && span.has(stamp_s, 0.0) && later {
            all.push((t_s, rate));
        }
    }
    let step_s = gyro_step_s(wheel_interval_s);
    let series = thinned(&integrated(&all), &times(&all), step_s);
    (all.len() >= LEAST_RATES).then_some(Thinned { all, series })
}

/// Angle (rad) behind every rate (rad/s).
fn integrated(rates: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut angle = 0.0;
    let mut all = Vec::with_capacity(rates.len());
    for (i, (t_s, rate)) in rates.iter().enumerate() {
        if i > 0 {
            angle += (t_s - rates[i - 1].0) * (rate + rates[i - 1].1) / 2.0;
        }
        all.push((*t_s, angle));
    }
    all
}

fn times<V>(rows: &[(f64, V)]) -> Vec<f64> {
    rows.iter().map(|row| row.0).collect()
}

/// Keeps of the poses of two recordings the rows that both have, in the same series; `false` where these
/// are too few.
pub(crate) fn match_poses(stamps: &Stamps, both: [&mut Thinned<PoseRow>; 2]) -> bool {
    match_rows(stamps, both, POSE_STEP_S, <[PoseRow]>::to_vec)
}

/// The same for the gyro.
pub(crate) fn match_rates(
    stamps: &Stamps,
    both: [&mut Thinned<(f64, f64)>; 2],
    wheel_interval_s: f64,
) -> bool {
    match_rows(stamps, both, gyro_step_s(wheel_interval_s), integrated)
}

/// Rows with their stamps (s).
type StampedRows<V> = [(f64, V)];

/// The same for any rows; `filtered` makes of them what the filter reads.
fn match_rows<V: Copy>(
    stamps: &Stamps,
    [first, second]: [&mut Thinned<(f64, V)>; 2],
    step_s: f64,
    filtered: impl Fn(&StampedRows<V>) -> Vec<(f64, V)>,
) -> bool {
    let kept = stamps.keep([&mut first.all, &mut second.all], |row| row.0);
    if kept {
        let series = numbers(&times(&first.all), step_s);
        for own in [first, second] {
            own.series = picked(&filtered(&own.all), &series);
        }
    }
    kept
}

/// Time between the rows of a thinned series of the gyro (s).
fn gyro_step_s(wheel_interval_s: f64) -> f64 {
    GYRO_STEP_S.max(2.0 * wheel_interval_s)
}

impl<R: Copy> Thinned<R> {
    /// The same rows in one series as dense as they are, if there are not too many.
    pub(crate) fn dense(&self) -> Option<Self> {
        let dense = self.all.len() as f64 <= ALL_ROWS;
        dense.then(|| Self {
            all: self.all.clone(),
            series: vec![self.all.clone()],
        })
    }
}

/// Interleaved series of rows at least `step_s` apart.
fn thinned<R: Copy>(rows: &[R], times_s: &[f64], step_s: f64) -> Vec<Vec<R>> {
    picked(rows, &numbers(times_s, step_s))
}

fn picked<R: Copy>(rows: &[R], series: &[Vec<usize>]) -> Vec<Vec<R>> {
    let each = series.iter();
    each.map(|own| own.iter().map(|row| rows[*row]).collect())
        .collect()
}

/// Numbers of the rows of interleaved series at least `step_s` apart.
fn numbers(times_s: &[f64], step_s: f64) -> Vec<Vec<usize>> {
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
        return Vec::new();
    };
    let rows = times_s.len();
    let step_s = step_s.max((last - first) / SERIES_ROWS);
    let interval_s = median_interval(times_s).max(1e-9);
    let stride = (step_s / interval_s).round().max(1.0);
    let most = (ALL_ROWS * stride / rows as f64).floor();
    let count = most.clamp(1.0, stride.min(MOST_SERIES)) as usize;
    let stride = stride as usize;
    (0..count)
        .map(|k| (0..rows).skip(k * stride / count).step_by(stride).collect())
        .collect()
}

/// Way of the poses (m), in steps of half a second, which noise hardly lengthens.
pub(crate) fn seen_way_m(rows: &[PoseRow]) -> f64 {
    let mut last: Option<(f64, [f64; 2])> = None;
    let mut way = 0.0;
    let points = rows.iter().map(|(t_s, [x, y, _])| (*t_s, [*x, *y]));
    for (t_s, at) in points.filter(|(_, at)| at.iter().all(|x| x.is_finite())) {
        match last {
            Some((before_s, _)) if t_s - before_s < WAY_STEP_S => continue,
            Some((_, from)) => way += (at[0] - from[0]).hypot(at[1] - from[1]),
            None => {}
        }
        last = Some((t_s, at));
    }
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_within_half_a_second_is_no_way() {
        let at = |k: u32| (f64::from(k) * 0.1, [f64::from(k % 5), 0.0, 0.0]);
        let rows: Vec<PoseRow> = (0..50).map(at).collect();
        assert_eq!(seen_way_m(&rows), 0.0);
    }
}
