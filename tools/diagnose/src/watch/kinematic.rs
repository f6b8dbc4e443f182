//! The filters of a robot that is told speeds or nothing, row by row: commands to wheels, wheels to poses and gyro.

use std::collections::VecDeque;
use std::sync::Arc;

use super::bank::{Bank, Source};
use super::evidence::Evidence;
use super::learnt::{Driven, Learnt, Moved, averaged_s};
use super::linear::{Change, Linear};
use crate::data::command::CommandPath;
use crate::data::feed::Feed;
use crate::data::reference::PoseRow;
use crate::data::streams::WheelKind;
use crate::data::wheel_path::Turned;
use crate::filter::cholesky::inverse_factor;
use crate::filter::wheel_channel::{self, ChannelNoise, ChannelRow};
use crate::filter::{Innovation, gyro, wheels_to_pose};
use crate::model::drive::{Response, Turning};

/// Rows that are this much farther apart than usual begin a filter anew (s).
const LOST_S: f64 = 5.0;
/// Changes of states by which filters are differentiated: m and rad, s.
const STATE: f64 = 1e-5;
const TIME_S: f64 = 1e-3;
/// Wheels are known a little beyond the time of a row that is heard (s).
const AHEAD_S: f64 = 0.012;

/// A series of a filter on its way.
#[derive(Clone)]
struct FilterSeries<On> {
    on: Option<On>,
    source: usize,
    last_s: f64,
}

impl<On> FilterSeries<On> {
    fn new(source: usize) -> Self {
        Self {
            on: None,
            source,
            last_s: f64::NEG_INFINITY,
        }
    }

    fn restart(&mut self) {
        (self.on, self.last_s) = (None, f64::NEG_INFINITY);
    }
}

/// The series of these sources, where there are any.
fn series<On>(sources: Option<Vec<usize>>) -> Vec<FilterSeries<On>> {
    sources
        .into_iter()
        .flatten()
        .map(FilterSeries::new)
        .collect()
}

/// The filters of one robot on their way.
pub(crate) struct Kinematic {
    learnt: Learnt,
    poses: Vec<FilterSeries<wheels_to_pose::On<f64>>>,
    rates: Vec<FilterSeries<gyro::On<f64>>>,
    drive: Vec<FilterSeries<DriveChannel>>,
    evidence: Evidence,
    heard: [usize; 2],
}

/// A channel of the drive on its way, and how far its wheels were simulated to turn (rad).
#[derive(Clone)]
struct DriveChannel {
    on: wheel_channel::On<f64>,
    simulated: f64,
}

impl Kinematic {
    /// The filters of a robot, and the sources that a bank has of them.
    pub(crate) fn new(learnt: Learnt) -> (Self, Vec<Source>) {
        let mut sources = Vec::new();
        let mut add = |count: usize, n: usize, places: &[usize]| -> Vec<usize> {
            let first = sources.len();
            sources.extend((0..count).map(|_| Source {
                n,
                places: places.to_vec(),
            }));
            (first..sources.len()).collect()
        };
        let poses = learnt.poses.as_ref();
        let poses = poses.map(|own| add(own.interleaved.series, 4, &own.physics.places));
        let rates = learnt.rates.as_ref();
        let rates = rates.map(|own| add(own.interleaved.series, 4, &own.models.places));
        let drive = learnt.driven.as_ref();
        let drive = drive.map(|own| add(2, 3, &own.parameters.places));
        let own = Self {
            poses: series(poses),
            rates: series(rates),
            drive: series(drive),
            evidence: Evidence::default(),
            learnt,
            heard: [0; 2],
        };
        (own, sources)
    }

    /// From now on the robot has parameters that are off those of the baseline by `shift`. Returns whether filters read the
    /// same parameters there.
    pub(crate) fn move_to(&mut self, shift: &[f64]) -> bool {
        let other = Learnt::new(Arc::clone(&self.learnt.baseline), shift);
        if other.places() != self.learnt.places() {
            return false;
        }
        self.learnt = other;
        true
    }

    /// Forgets where the robot is.
    pub(crate) fn restart(&mut self) {
        self.poses.iter_mut().for_each(FilterSeries::restart);
        self.rates.iter_mut().for_each(FilterSeries::restart);
        self.drive.iter_mut().for_each(FilterSeries::restart);
        self.evidence = Evidence::default();
        self.heard = [0; 2];
    }

    /// Hears the rows of a feed for which wheels are known.
    pub(crate) fn hear(&mut self, feed: &mut Feed, bank: &mut Bank) {
        if let Some(drive) = self.learnt.commanded.as_ref() {
            if feed.commands.times_s.is_empty() {
                return;
            }
            let base = Response::new(&feed.commands, &drive.base);
            let after = drive.after.iter();
            let after: Vec<_> = after
                .map(|own| Response::new(&feed.commands, own))
                .collect();
            let places = drive.places.clone();
            let wheels = TurningWheels {
                base: &base,
                after: after.iter().map(|own| own as &dyn Turned<f64>).collect(),
                places: &places,
                until_s: feed.now_s,
            };
            self.references(&mut feed.poses, &mut feed.rates, &wheels, bank);
        } else if feed.wheels.times_s.len() > 1 {
            let last_s = feed.wheels.times_s.last().copied();
            let wheels = TurningWheels {
                base: &feed.wheels,
                after: Vec::new(),
                places: &[],
                until_s: last_s.unwrap_or(f64::NEG_INFINITY) - AHEAD_S,
            };
            self.references(&mut feed.poses, &mut feed.rates, &wheels, bank);
        }
        self.hear_drive(feed, bank);
    }

    fn references(
        &mut self,
        poses: &mut VecDeque<PoseRow>,
        rates: &mut VecDeque<(f64, f64)>,
        wheels: &TurningWheels<'_>,
        bank: &mut Bank,
    ) {
        while let Some(row) = poses.front()
            && self.learnt.measured_s(false, row.0) <= wheels.until_s
            && let Some(row) = poses.pop_front()
        {
            self.hear_pose(&row, wheels, bank);
        }
        while let Some(row) = rates.front()
            && self.learnt.measured_s(true, row.0) <= wheels.until_s
            && let Some(row) = rates.pop_front()
        {
            self.hear_rate(&row, wheels, bank);
        }
    }
}

/// The wheels as they turn, and as they would after a change of parameters of the drive, where they follow commands.
struct TurningWheels<'a> {
    base: &'a dyn Turned<f64>,
    after: Vec<&'a dyn Turned<f64>>,
    /// Which of all parameters were changed.
    places: &'a [usize],
    until_s: f64,
}

impl<'a> TurningWheels<'a> {
    /// After a change of one of all parameters.
    fn after(&self, place: Option<usize>) -> &'a dyn Turned<f64> {
        let number = place.and_then(|place| self.places.iter().position(|own| *own == place));
        number.map_or(self.base, |number| self.after[number])
    }
}

impl<P> Moved<P> {
    /// After a change.
    fn at(&self, change: Option<Change>) -> &P {
        match change {
            Some(Change::Parameter(i)) => &self.after[i],
            _ => &self.base,
        }
    }

    /// Which of all parameters a change is of.
    fn place(&self, change: Option<Change>) -> Option<usize> {
        match change {
            Some(Change::Parameter(i)) => Some(self.places[i]),
            _ => None,
        }
    }
}

impl Kinematic {
    fn hear_pose(&mut self, row: &PoseRow, wheels: &TurningWheels<'_>, bank: &mut Bank) {
        let Some(own) = &self.learnt.poses else {
            return;
        };
        let (at, count) = (self.heard[0], own.interleaved.series as f64);
        self.heard[0] += 1;
        let series = own.interleaved.of_row(at);
        let Some(series) = series.and_then(|k| self.poses.get_mut(k)) else {
            return;
        };
        let filter = self.learnt.pose_filter();
        let noise = &own.noise;
        let lost = row.0 - series.last_s > LOST_S + own.interval_s;
        series.last_s = row.0;
        let Some(on) = series.on.as_mut().filter(|_| !lost) else {
            series.on = Some(filter.begin(wheels.base, &own.physics.base, noise, row));
            bank.lose(series.source);
            return;
        };
        let before = on.clone();
        let step = |change: Option<Change>| {
            let mut on = before.clone();
            match change {
                Some(Change::State(3, h)) => on.time_s += h,
                Some(Change::State(i, h)) => on.state.mean[i] += h,
                Some(Change::Parameter(_)) | None => (),
            }
            let wheels = wheels.after(own.physics.place(change));
            on.angles = wheels.angles_at(on.time_s, &mut 0);
            let innovation = filter.hear(wheels, own.physics.at(change), noise, &mut on, row);
            (on, innovation)
        };
        let (after, innovation) = step(None);
        let steps = [STATE, STATE, STATE, TIME_S];
        let row = Linear::by_differences(
            &whitening(&innovation),
            &steps,
            &own.physics.steps,
            |change| {
                let (on, innovation) = step(change);
                let [x, y, yaw] = on.state.mean;
                (innovation.difference, [x, y, yaw, on.time_s])
            },
        );
        *on = after;
        bank.hear(series.source, &row, 1.0 / count);
    }

    fn hear_rate(&mut self, row: &(f64, f64), wheels: &TurningWheels<'_>, bank: &mut Bank) {
        let Some(own) = &self.learnt.rates else {
            return;
        };
        let (at, count) = (self.heard[1], own.interleaved.series as f64);
        self.heard[1] += 1;
        let series = own.interleaved.of_row(at);
        let Some(series) = series.and_then(|k| self.rates.get_mut(k)) else {
            return;
        };
        let filter = self.learnt.gyro_filter();
        let lost = row.0 - series.last_s > LOST_S;
        series.last_s = row.0;
        let Some(on) = series.on.as_mut().filter(|_| !lost) else {
            series.on = Some(filter.begin(wheels.base, &own.models.base, row));
            bank.lose(series.source);
            return;
        };
        let before = on.clone();
        let step = |change: Option<Change>| {
            let mut on = before.clone();
            match change {
                Some(Change::State(i @ (0 | 1), h)) => on.state.mean[i] += h,
                Some(Change::State(2, h)) => on.measured += h,
                Some(Change::State(_, h)) => on.time_s += h,
                Some(Change::Parameter(_)) | None => (),
            }
            let wheels = wheels.after(own.models.place(change));
            on.angles = wheels.angles_at(on.time_s, &mut 0);
            let innovation = filter.hear(wheels, own.models.at(change), &mut on, row);
            (on, innovation)
        };
        let (after, innovation) = step(None);
        let [[w, ..], ..] = whitening(&innovation);
        let steps = [STATE, STATE, STATE, TIME_S];
        let row = Linear::by_differences(&[[w]], &steps, &own.models.steps, |change| {
            let (on, innovation) = step(change);
            let [x, d] = on.state.mean;
            ([innovation.difference[0]], [x, d, on.measured, on.time_s])
        });
        *on = after;
        bank.hear(series.source, &row, 1.0 / count);
    }

    /// Hears the rows of the wheels beside their commands.
    fn hear_drive(&mut self, feed: &mut Feed, bank: &mut Bank) {
        let Some(driven) = &self.learnt.driven else {
            feed.rows.clear();
            return;
        };
        if feed.commands.times_s.is_empty() {
            return;
        }
        let own = &driven.parameters;
        let base = SimulatedWheels::new(&feed.commands, &own.base);
        let after = own.after.iter();
        let after: Vec<SimulatedWheels<'_>> = after
            .map(|own| SimulatedWheels::new(&feed.commands, own))
            .collect();
        while let Some((t_s, value)) = feed.rows.pop_front() {
            let told = feed.commands.at(t_s).unwrap_or([0.0; 2]);
            let last_s = self.drive[0].last_s;
            let (counts, rests) = self.evidence.of(driven, t_s, told, value);
            let lost = t_s - last_s > LOST_S || rests;
            let from_s = if lost { t_s } else { last_s };
            let at = base.over(from_s, t_s);
            let others = after.iter().map(|own| own.over(from_s, t_s));
            let others: Vec<(Turning<f64>, Turning<f64>)> = others.collect();
            for (channel, series) in self.drive.iter_mut().enumerate() {
                series.last_s = t_s;
                let row = DriveRow {
                    t_s,
                    value,
                    channel,
                    counts,
                    driven,
                    at,
                    others: &others,
                };
                row.hear(series, lost, bank);
            }
        }
    }
}

/// Wheels as a drive turns them.
struct SimulatedWheels<'a> {
    response: Response<'a, f64>,
    mean_s: f64,
}

impl<'a> SimulatedWheels<'a> {
    fn new(commands: &'a CommandPath, parameters: &[f64]) -> Self {
        Self {
            response: Response::new(commands, parameters),
            mean_s: averaged_s(parameters),
        }
    }

    /// At one time, and as a later row has them.
    fn over(&self, from_s: f64, to_s: f64) -> (Turning<f64>, Turning<f64>) {
        let before = self.response.at(from_s, &mut 0);
        (before, self.response.averaged(to_s, self.mean_s, &mut 0))
    }
}

/// A row of the wheels beside what the drive was simulated to do.
struct DriveRow<'a> {
    t_s: f64,
    value: [f64; 2],
    channel: usize,
    counts: bool,
    driven: &'a Driven,
    /// The simulated wheels at the last row and at this one, and the same after a change of each parameter.
    at: (Turning<f64>, Turning<f64>),
    others: &'a [(Turning<f64>, Turning<f64>)],
}

impl DriveRow<'_> {
    fn noise(&self) -> &ChannelNoise<f64> {
        &self.driven.noise[self.channel]
    }

    fn half(&self, pair: [f64; 2]) -> f64 {
        let sign = if self.channel == 0 { 1.0 } else { -1.0 };
        (pair[0] + pair[1] * sign) * 0.5
    }

    /// As the channel's filter hears it, after the wheels were simulated from `simulated` on; and how far they turned.
    fn of(
        &self,
        (before, now): &(Turning<f64>, Turning<f64>),
        simulated: f64,
    ) -> (ChannelRow<f64>, f64) {
        let simulated = simulated + self.half(now.angle_rad) - self.half(before.angle_rad);
        let speed_rad_s = self.half(now.speed_rad_s);
        let predicted = match self.driven.kind {
            WheelKind::Angle => simulated,
            WheelKind::Speed => speed_rad_s,
        };
        let row = ChannelRow {
            time_s: self.t_s,
            rest: self.half(self.value) - predicted,
            speed_rad_s,
            counts: self.counts,
        };
        (row, simulated)
    }

    fn hear(&self, series: &mut FilterSeries<DriveChannel>, lost: bool, bank: &mut Bank) {
        let Some(before) = series.on.clone().filter(|_| !lost) else {
            let (row, simulated) = self.of(&self.at, 0.0);
            let mut on = None;
            if self.driven.kind == WheelKind::Speed {
                self.noise().hear_speed(&mut on, &row);
            }
            let on = on.unwrap_or_else(|| self.noise().begin(&row));
            series.on = Some(DriveChannel { on, simulated });
            bank.lose(series.source);
            return;
        };
        let step = |change: Option<Change>| {
            let mut own = before.clone();
            let mut at = &self.at;
            match change {
                Some(Change::State(2, h)) => own.simulated += h,
                Some(Change::State(i, h)) => own.on.state.mean[i] += h,
                Some(Change::Parameter(i)) => at = &self.others[i],
                None => (),
            }
            let (row, simulated) = self.of(at, own.simulated);
            own.simulated = simulated;
            let innovation = match self.driven.kind {
                WheelKind::Angle => self.noise().hear_angle(&mut own.on, &row),
                WheelKind::Speed => {
                    let mut on = Some(own.on);
                    let innovation = self.noise().hear_speed(&mut on, &row);
                    own.on = on.unwrap_or_else(|| self.noise().begin(&row));
                    innovation
                }
            };
            (own, innovation)
        };
        let (after, innovation) = step(None);
        let [[w, ..], ..] = whitening(&innovation);
        let steps = [STATE, STATE, STATE];
        let row = Linear::by_differences(&[[w]], &steps, &self.driven.parameters.steps, |change| {
            let (own, innovation) = step(change);
            let [x, d] = own.on.state.mean;
            ([innovation.difference[0]], [x, d, own.simulated])
        });
        series.on = Some(after);
        bank.hear(series.source, &row, f64::from(u8::from(self.counts)));
    }
}

/// What makes the innovation of a row white. A row that is far off counts for less, but always for something: a change
/// makes all rows odd (Huber 1964).
fn whitening(own: &Innovation<f64>) -> [[f64; 3]; 3] {
    if own.scalar {
        let w = 1.0 / own.covariance[0][0].sqrt();
        let root = counts(own.difference[0] * w, 1.0);
        return [[w * root, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    }
    let factor = inverse_factor(&own.covariance);
    let white = factor.map(|row| {
        row.iter()
            .zip(&own.difference)
            .map(|(w, e)| w * e)
            .sum::<f64>()
    });
    let size = white.iter().map(|own| own * own).sum::<f64>().sqrt();
    let root = counts(size, 3.0);
    factor.map(|row| row.map(|own| own * root))
}

/// Innovations of more than so many deviations count for less.
const OUTLIER_DEVIATIONS: f64 = 3.0;

/// The root of the weight of a row of so many numbers whose innovation has this size in deviations.
pub(super) fn counts(size: f64, numbers: f64) -> f64 {
    let share = OUTLIER_DEVIATIONS * numbers.sqrt() / size.abs();
    share.min(1.0).sqrt()
}
