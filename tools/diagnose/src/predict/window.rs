//! A recording cut into windows, each with an initial state of its own: what is unknown before a
//! window cannot spoil it.

use slipstream_bus::Body;
use slipstream_sim::{Command, CommandKind};

use crate::data::track::{Sensor, Series, Track, geometry};

/// Length of a window (s).
pub(crate) const WINDOW_S: f64 = 5.0;
/// Windows that are predicted of a long recording.
const MOST: usize = 24;
/// How far a window's end may be moved to where the robot rolls gently (s).
const SEARCH_S: f64 = 1.2;

/// A slide that a torque began is over this long after it (s).
const SLIDE_S: f64 = 0.35;

/// An encoder that reads the same for so long (s) was looked at while its wheel rests.
const RESTS_S: f64 = 0.2;

/// Unknowns of a window's start: pose (3), surge and yaw rate, angles of both wheels.
pub(crate) const LOCALS: usize = 7;

/// One window: what was told and measured in it.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    /// Which track it is of.
    pub(crate) run: usize,
    pub(crate) from_s: f64,
    pub(crate) to_s: f64,
    /// Which of the track's commands holds at the start.
    pub(crate) command: usize,
    /// Of each series, the rows in the window.
    pub(crate) rows: Vec<[usize; 2]>,
    /// Where the residuals of each series begin.
    pub(crate) base: Vec<usize>,
    /// The channel of each residual.
    pub(crate) channels: Vec<u8>,
    /// The stamp of each residual (s).
    pub(crate) stamps_s: Vec<f64>,
    /// Places of residuals that share one rounding: readings of a wheel while it rests.
    pub(crate) rests: Vec<Vec<usize>>,
    /// Which unknowns of the start there are.
    pub(crate) free: [bool; LOCALS],
}

/// Cuts `track`, the `run`th, into windows of about `length_s` that start where little drives the
/// robot. Nothing is simulated over times that are left out.
pub(crate) fn cut(track: &Track, run: usize, length_s: f64) -> Vec<Window> {
    let mut windows = Vec::new();
    for [begin, end] in track.stretches_s() {
        let mut from_s = begin;
        while from_s + 1.0 < end {
            let wanted = from_s + length_s;
            let to_s = if wanted + 0.3 * length_s > end {
                end
            } else {
                gentle(track, wanted)
            };
            windows.push(Window::new(track, run, from_s, to_s));
            from_s = to_s;
        }
    }
    windows.retain(|window| !window.channels.is_empty());
    windows
}

/// All runs cut into windows of 5 s; of very long recordings some of them.
pub(crate) fn cut_some(tracks: &[Track]) -> Vec<Window> {
    let runs = tracks.iter().enumerate();
    let all = runs.flat_map(|(run, track)| cut(track, run, WINDOW_S));
    spread(all.collect(), MOST)
}

/// At most so many of all, at equal distances.
pub(crate) fn at_most<T: Clone>(all: &[T], most: usize) -> Vec<T> {
    let stride = all.len().div_ceil(most.max(1)).max(1);
    all.iter().step_by(stride).cloned().collect()
}

/// At most `most` of all windows, from begin to end.
fn spread(windows: Vec<Window>, most: usize) -> Vec<Window> {
    let count = windows.len();
    if count <= most {
        return windows;
    }
    let chosen = (0..most).map(|k| windows[k * (count - 1) / (most - 1)].clone());
    chosen.collect()
}

/// The instant near `wanted_s` at which a command begins, both wheels turn, and the least has been
/// asked of them for a while.
fn gentle(track: &Track, wanted_s: f64) -> f64 {
    let commands = track.commands.iter().map(|(t_s, _)| *t_s);
    let near = |t_s: &f64| (t_s - wanted_s).abs() <= SEARCH_S;
    let wheels = track.of(Sensor::WheelAngle);
    let cost = |t_s: f64| {
        let [first, end] = range(&track.commands, t_s - SLIDE_S, t_s + 0.05);
        let asked = track.commands[first.saturating_sub(1)..end].iter();
        let asked = asked.map(|(_, command)| size(command)).fold(0.0, f64::max);
        let speeds = wheels.map_or([1.0; 2], |wheels| speeds(wheels, t_s));
        let stands = speeds.iter().any(|speed| speed.abs() < 0.4);
        (stands, asked + (t_s - wanted_s).abs() * 1e-4)
    };
    let best = commands.filter(near).min_by(|a_s, b_s| {
        let (a, b) = (cost(*a_s), cost(*b_s));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    best.unwrap_or(wanted_s)
}

/// How much a command asks of the contacts, as far as it says.
fn size(command: &Command) -> f64 {
    match *command {
        Command::Torque { right_nm, left_nm } => right_nm.abs().max(left_nm.abs()),
        Command::Voltage { right_v, left_v } => right_v.abs().max(left_v.abs()),
        Command::Speed { .. } | Command::Twist { .. } => 0.0,
    }
}

/// Mean speeds of both wheels around `t_s` (rad/s).
fn speeds(wheels: &Series, t_s: f64) -> [f64; 2] {
    let [first, end] = range(&wheels.rows, t_s - 0.06, t_s + 0.06);
    match wheels.rows[first..end] {
        [(from_s, a), .., (to_s, b)] if to_s > from_s => {
            [0, 1].map(|i| (b[i] - a[i]) / (to_s - from_s))
        }
        _ => [0.0; 2],
    }
}

pub(crate) fn range<T>(rows: &[(f64, T)], from_s: f64, to_s: f64) -> [usize; 2] {
    let first = rows.partition_point(|(t_s, _)| *t_s < from_s);
    let end = rows.partition_point(|(t_s, _)| *t_s < to_s);
    [first, end]
}

/// Where the residuals of encoders lie, from `base` on, that read the same for long.
fn at_rest(rows: &[(f64, [f64; 3])], base: usize) -> Vec<Vec<usize>> {
    let width = Sensor::WheelAngle.width();
    let mut rests = Vec::new();
    for wheel in 0..width {
        let mut first = 0;
        for same in rows.chunk_by(|(_, a), (_, b)| a[wheel] == b[wheel]) {
            let place = |k: usize| base + k * width + wheel;
            let over_s = same[same.len() - 1].0 - same[0].0;
            if over_s >= RESTS_S {
                rests.push((first..first + same.len()).map(place).collect());
            }
            first += same.len();
        }
    }
    rests
}

impl Window {
    pub(crate) fn new(track: &Track, run: usize, from_s: f64, to_s: f64) -> Self {
        let told = &track.commands;
        let first = told.partition_point(|(t_s, _)| *t_s < from_s + 1e-9);
        let (mut rows, mut base) = (Vec::new(), Vec::new());
        let (mut channels, mut stamps_s) = (Vec::new(), Vec::new());
        let mut rests = Vec::new();
        for series in &track.series {
            let [first, end] = range(&series.rows, from_s, to_s);
            if series.sensor == Sensor::WheelAngle {
                rests.extend(at_rest(&series.rows[first..end], channels.len()));
            }
            base.push(channels.len());
            rows.push([first, end]);
            for (stamp_s, _) in &series.rows[first..end] {
                for part in 0..series.sensor.width() {
                    channels.push((series.sensor.channel() + part) as u8);
                    stamps_s.push(*stamp_s);
                }
            }
        }
        let mut window = Self {
            run,
            from_s,
            to_s,
            command: first.saturating_sub(1),
            rows,
            base,
            channels,
            stamps_s,
            rests,
            free: [true; LOCALS],
        };
        window.free = window.unknowns(track);
        window
    }

    /// What of the start is unknown: no pose without a camera, no angles without encoders, no speed
    /// where it is commanded or where the wheels stand.
    fn unknowns(&self, track: &Track) -> [bool; LOCALS] {
        let has = |sensor: Sensor| self.rows_of(track, sensor).is_some();
        let pose = has(Sensor::Pose);
        let angle = has(Sensor::WheelAngle);
        let rolls = track.kind() != CommandKind::Speed && !self.stands(track);
        [pose, pose, pose, rolls, rolls, angle, angle]
    }

    /// Whether the encoders show no motion as the window begins.
    fn stands(&self, track: &Track) -> bool {
        let Some(rows) = self.rows_of(track, Sensor::WheelAngle) else {
            return false;
        };
        let begin = rows
            .iter()
            .take_while(|(t_s, _)| *t_s <= self.from_s + 0.06);
        let same =
            |(_, angle): &(f64, [f64; 3])| angle[0] == rows[0].1[0] && angle[1] == rows[0].1[1];
        begin.clone().count() > 2 && begin.into_iter().all(same)
    }

    /// The rows of a sensor; `None` where there are none.
    fn rows_of<'a>(&self, track: &'a Track, sensor: Sensor) -> Option<&'a [(f64, [f64; 3])]> {
        let which = track.place(sensor)?;
        let [first, end] = self.rows[which];
        (end > first).then(|| &track.series[which].rows[first..end])
    }

    /// Time (s), values and place among the residuals of each row of a series.
    pub(crate) fn measured(
        &self,
        track: &Track,
        which: usize,
    ) -> impl Iterator<Item = (f64, [f64; 3], usize)> {
        let series = &track.series[which];
        let [first, end] = self.rows[which];
        let (base, width) = (self.base[which], series.sensor.width());
        let rows = series.rows[first..end].iter().enumerate();
        rows.map(move |(k, (t_s, values))| (*t_s, *values, base + k * width))
    }

    /// Lets the mean of residuals that share one rounding weigh as one of them: however often a wheel
    /// at rest is looked at, where it rests is known no better.
    pub(crate) fn share(&self, residuals: &mut [f64]) {
        for rest in &self.rests {
            let seen = || rest.iter().filter(|i| residuals[**i].is_finite());
            let count = seen().count() as f64;
            let mean = seen().map(|i| residuals[*i]).sum::<f64>() / count;
            let less = mean * (1.0 - count.sqrt().recip());
            rest.iter().for_each(|i| residuals[*i] -= less);
        }
    }

    /// The channel of readings that share one rounding, and how many were seen beside the first.
    pub(crate) fn repeated(&self, residuals: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        self.rests.iter().map(|rest| {
            let seen = rest.iter().filter(|i| residuals[**i].is_finite());
            let channel = usize::from(self.channels[rest[0]]);
            (channel, seen.count().saturating_sub(1) as f64)
        })
    }

    /// The first `over_s` of this window.
    pub(crate) fn head(&self, track: &Track, over_s: f64) -> Self {
        let to_s = (self.from_s + over_s).min(self.to_s);
        Self::new(track, self.run, self.from_s, to_s)
    }

    /// A first guess of the unknowns at the start, from the measurements near it.
    /// Without a camera the robot is where wheels took it since the recording began.
    pub(crate) fn guess(&self, track: &Track, body: &Body) -> [f64; LOCALS] {
        let [radius_m, half_track_m, _] = geometry(body);
        let poses = self.rows_of(track, Sensor::Pose);
        let reckoned = || track.reckoned(&[self.from_s], geometry(body))?.pop();
        let seen = poses.map(|rows| rows[0].1).or_else(reckoned);
        let pose = seen
            .unwrap_or([0.0; 3])
            .map(|own| if own.is_finite() { own } else { 0.0 });
        let angles = self.rows_of(track, Sensor::WheelAngle);
        let angle = angles.map_or([0.0; 2], |rows| [rows[0].1[0], rows[0].1[1]]);
        let yaw = pose[2];
        let [mut u, mut rate] = [0.0; 2];
        if let Some(wheels) = track.of(Sensor::WheelAngle).filter(|_| self.free[3]) {
            let [right, left] = speeds(wheels, self.from_s).map(|speed| speed * radius_m);
            [u, rate] = [(right + left) / 2.0, (right - left) / (2.0 * half_track_m)];
        } else if let Some(rows) = poses.filter(|_| self.free[3]) {
            let near = rows.iter().take_while(|(t_s, _)| *t_s < self.from_s + 0.3);
            if let Some((t_s, end)) = near.last().filter(|(t_s, _)| *t_s > rows[0].0) {
                let over = t_s - rows[0].0;
                let (dx, dy) = (end[0] - pose[0], end[1] - pose[1]);
                [u, rate] = [
                    (dx * yaw.cos() + dy * yaw.sin()) / over,
                    (end[2] - yaw) / over,
                ];
            }
        }
        let [u, rate] = [u, rate].map(|own| if own.is_finite() { own } else { 0.0 });
        let ahead = track.tracked_ahead_m;
        let [x, y] = [pose[0] - ahead * yaw.cos(), pose[1] - ahead * yaw.sin()];
        [x, y, yaw, u, rate, angle[0], angle[1]]
    }
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;

    use super::*;
    use crate::predict::fixture;
    use crate::predict::sum_of_squares::SumOfSquares;

    fn track(length_s: f64) -> Track {
        fixture::driven(&RobotModel::default(), length_s, fixture::gentle)
    }

    fn begins(windows: &[Window]) -> Vec<f64> {
        windows.iter().map(|window| window.from_s).collect()
    }

    #[test]
    fn windows_follow_each_other_without_overlap() {
        let track = track(31.0);
        let windows = cut(&track, 0, WINDOW_S);
        let [begin, end] = track.span_s();
        assert_eq!(windows[0].from_s, begin);
        assert_eq!(windows.last().unwrap().to_s, end);
        for pair in windows.windows(2) {
            assert_eq!(pair[0].to_s, pair[1].from_s);
            let rows = pair[0].rows.iter().zip(&pair[1].rows);
            rows.for_each(|(before, after)| assert_eq!(before[1], after[0]));
        }
        for window in &windows {
            let length_s = window.to_s - window.from_s;
            assert!((WINDOW_S - SEARCH_S..1.3 * WINDOW_S + SEARCH_S).contains(&length_s));
        }
    }

    #[test]
    fn a_short_recording_is_one_window_or_none() {
        for (length_s, count) in [(0.9, 0), (1.5, 1), (6.0, 1), (8.0, 2)] {
            let windows = cut(&track(length_s), 0, WINDOW_S);
            assert_eq!(windows.len(), count, "{length_s} s");
        }
    }

    #[test]
    fn of_too_many_windows_the_first_and_the_last_stay() {
        let windows = cut(&track(31.0), 0, WINDOW_S);
        let all = begins(&windows);
        assert_eq!(begins(&spread(windows.clone(), 100)), all);
        let few = begins(&spread(windows, 3));
        assert_eq!(few.len(), 3);
        assert_eq!([few[0], few[2]], [all[0], all[all.len() - 1]]);
    }

    #[test]
    fn what_rests_has_no_speed_to_fit() {
        let still = fixture::driven(&RobotModel::default(), 5.0, |_| [0.0; 2]);
        let [pose, angle] = [true; 2];
        let windows = cut(&still, 0, WINDOW_S);
        assert_eq!(
            windows[0].free,
            [pose, pose, pose, false, false, angle, angle]
        );
        let moving = cut(&track(12.0), 0, WINDOW_S);
        assert_eq!(moving[1].free, [true; LOCALS]);
    }

    #[test]
    fn a_wheel_at_rest_is_measured_once() {
        let still = fixture::driven(&RobotModel::default(), 3.0, |_| [0.0; 2]);
        let windows = cut(&still, 0, WINDOW_S);
        let [right, left] = &windows[0].rests[..] else {
            panic!("two wheels, {} rests", windows[0].rests.len());
        };
        assert!(right.len() > 100 && right.len() == left.len());
        assert!(right.iter().all(|i| windows[0].channels[*i] == 0));
        assert!(left.iter().all(|i| windows[0].channels[*i] == 1));
        let mut residuals = vec![0.0; windows[0].channels.len()];
        right.iter().for_each(|i| residuals[*i] = 1.7);
        left.iter().for_each(|i| residuals[*i] = f64::NAN);
        windows[0].share(&mut residuals);
        let squares: f64 = right.iter().map(|i| residuals[*i].powi(2)).sum();
        assert!((squares - 1.7 * 1.7).abs() < 1e-12);
        let squares = SumOfSquares::new(&windows[0], &residuals);
        // one reading of the right wheel, none of the left one
        assert!((squares.mean_square(0) - 1.7 * 1.7).abs() < 1e-12);
        assert_eq!(squares.mean_square(1), 0.0);
    }

    #[test]
    fn motion_at_rest_weighs_in_full() {
        let mut window = fixture::window(vec![0; 4]);
        window.rests = vec![vec![0, 1, 2, 3]];
        let mut residuals = [3.0, -1.0, 2.0, -4.0];
        window.share(&mut residuals);
        assert_eq!(residuals, [3.0, -1.0, 2.0, -4.0]);
    }

    #[test]
    fn wheels_that_turn_are_measured_with_each_reading() {
        let windows = cut(&track(12.0), 0, WINDOW_S);
        assert!(windows[1].rests.is_empty());
    }
}
