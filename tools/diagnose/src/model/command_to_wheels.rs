//! From commanded to measured wheel speeds, for one drive in one or several runs.

use rayon::prelude::*;
use slipstream_bus::RobotModel;
use slipstream_recording::recording::Robot;
use slipstream_sim::Scalar;

use super::comparison::{self, Before, SHARES};
use super::crude;
use super::drive::{
    AVERAGED, CLOCK, DEAD_BAND, DEAD_ZONE, DELAY, DRIVE, FRICTION, GAIN, GAIN_ASYMMETRY, LAG, PULL,
    Response, SAG, SATURATION,
};
use super::nominal::clock_rate;
use super::volts;
use crate::data::command::{CommandPath, commands};
use crate::data::matched::{Stamps, shift_against};
use crate::data::streams::WheelKind;
use crate::data::wheel_path::median_interval;
use crate::data::wheel_rows::{WheelRows, is_running, match_wheels, rows};
use crate::estimate::blocks::{self, Blocks};
use crate::estimate::cluster::LEAST_RUNS;
use crate::estimate::information::{Dual, Rows, empty};
use crate::estimate::pairs::{self, Share, Side};
use crate::estimate::whitened::Whitened;
use crate::estimate::{BlockScore, Likelihood};
use crate::filter::Innovation;
use crate::filter::wheel_channel::{self, ChannelNoise, ChannelRow, Tails};

/// Logarithms of noise sizes: disturbance (rad/s), its time (s) and walk (rad/√s) of the sum and of
/// the difference of both wheels, sensor noise (rad, or rad/s), stamp noise (s).
pub(crate) const NOISE: usize = 8;
/// Of these, the times of the disturbances.
pub(crate) const TIMES: [usize; 2] = [1, 4];
/// Longest of them of a motor under voltage (s).
const MOST_TIME_S: f64 = 0.2;
/// Least walk of a wheel's angle (rad/√s): 5 µm at the rim of a wheel of 5 cm after a second, less than
/// drives repeat and than integrators of simulators differ from the closed form by. Without a floor the
/// likelihood of exact angles grows without end where some rows fit exactly. It is a walk, for errors of
/// integrators add up; a noise of the sensor would draw one error out over many rows.
const LEAST_WALK: f64 = 1e-4;
/// Least noise of a wheel's speed (rad/s): what integrators differ by.
const LEAST_SPEED_RAD_S: f64 = 1e-4;

/// One run.
#[derive(Debug)]
pub(crate) struct DriveRun {
    /// Which of the robots it is of.
    pub(crate) robot: usize,
    pub(crate) commands: CommandPath,
    pub(crate) wheels: WheelRows,
    pub(crate) blocks: Blocks,
}

/// The drive.
#[derive(Debug)]
pub(crate) struct CommandToWheels {
    pub(crate) runs: Vec<DriveRun>,
    /// Largest commanded wheel speed (rad/s).
    pub(crate) largest_rad_s: f64,
    /// Crude logarithm of what wheels turn over what they are told, where it is beyond a factor of 2; else 0.
    pub(crate) crude_gain: f64,
    /// What it is compared with.
    pub(crate) before: Before,
}

/// Its likelihood, with or without outliers.
pub(crate) struct DriveView<'a> {
    pub(crate) drive: &'a CommandToWheels,
    /// Whether rows may be outliers. Without, the likelihood has one smooth maximum: a start.
    pub(crate) robust: bool,
}

impl CommandToWheels {
    /// The drive of these runs; `None` without a run that has commanded speeds and wheels.
    pub(crate) fn new(
        robots: &[&Robot],
        model: &RobotModel,
        excluded_s: &[[f64; 2]],
    ) -> Option<Self> {
        let mut runs: Vec<DriveRun> = Vec::new();
        for (at, robot) in robots.iter().enumerate() {
            let first = runs.last().map_or(0, |run| run.blocks.end());
            if let Some(mut run) = DriveRun::new(robot, model, excluded_s, first) {
                run.robot = at;
                runs.push(run);
            }
        }
        let largest = runs.iter().map(|run| run.commands.largest_rad_s());
        let largest_rad_s = largest.fold(0.0, f64::max);
        (largest_rad_s > 0.0).then(|| Self {
            crude_gain: crude::gain_ln(runs.iter().map(|run| (&run.commands, &run.wheels))),
            runs,
            largest_rad_s,
            before: Before::default(),
        })
    }

    /// Compares runs of today with those of the first `count` of `robots`, which are from before.
    pub(crate) fn compare(&mut self, count: usize, robots: &[&Robot]) {
        let runs = self.runs.iter().map(|run| (run.blocks, run.course()));
        let before = self.runs.iter().filter(|run| run.robot < count).count();
        let clusters = comparison::clusters(before, &runs.collect::<Vec<_>>());
        let mut stamped = [[0.0; 2]; SHARES];
        let clusters = clusters.filter(|_| {
            let (then, now) = self.runs.split_at_mut(before);
            let mut pairs = then.iter_mut().zip(now);
            pairs.all(|(a, b)| {
                let both = [robots[a.robot], robots[b.robot]];
                let stamps = Stamps::new(both, |own| own.wheels.as_ref());
                let told = Stamps::new(both, |own| own.command.as_ref());
                stamped[0] = shift_against(stamps.as_ref(), told.as_ref());
                stamps.is_some_and(|own| match_wheels(&own, [&mut a.wheels, &mut b.wheels]))
            })
        });
        self.before = Before {
            runs: before,
            robots: count,
            clusters,
            stamped,
            ..Before::default()
        };
    }

    /// Number of parameters, noise sizes included.
    pub(crate) fn parameters(&self) -> usize {
        if self.before.any() {
            Self::SHARE + 1
        } else {
            DRIVE + NOISE
        }
    }

    /// Index of the share that runs from before and of today do not have in common.
    pub(crate) const SHARE: usize = Self::shared(DRIVE);

    /// Index of a parameter that runs from before share with those of today.
    pub(crate) const fn shared(parameter: usize) -> usize {
        DRIVE + NOISE + parameter
    }

    /// The parameters of one run, out of all.
    pub(crate) fn local(&self, run: usize, at: &[f64]) -> Vec<f64> {
        if !self.before.any() {
            return at.to_vec();
        }
        let mut own = comparison::of_machine(at, DRIVE, Self::shared(0), self.before.has(run));
        own.extend(&at[DRIVE..DRIVE + NOISE]);
        own
    }

    /// Where the parameters of a run stand among all: pairs of the run's own number and the index.
    fn places(&self, run: usize) -> Vec<(usize, usize)> {
        if !self.before.any() {
            return (0..DRIVE + NOISE).map(|i| (i, i)).collect();
        }
        let mut places = comparison::places(DRIVE, Self::shared(0), self.before.has(run));
        places.extend((DRIVE..DRIVE + NOISE).map(|i| (i, i)));
        places
    }

    /// Values of all parameters in the nominal model, with first guesses of the noise sizes.
    pub(crate) fn nominal(&self, model: &RobotModel) -> Vec<f64> {
        let by_volts = self.runs.iter().any(|run| run.commands.by_volts);
        let mut at = drive_of(model, by_volts);
        let top = self.largest_rad_s;
        let sensor = match self.runs[0].wheels.kind {
            WheelKind::Angle => [3e-3, 3e-3],
            WheelKind::Speed => [0.03, 0.01],
        };
        let noise = [0.02 * top, 1.0, 1e-4 * top, 0.01 * top, 1.0, 1e-4 * top];
        at.extend(noise.into_iter().chain(sensor).map(f64::ln));
        if self.before.any() {
            at.extend_from_within(..DRIVE);
            at[..DRIVE].fill(0.0);
            at.push(0.0);
        }
        at
    }

    /// Indices of the noise sizes.
    pub(crate) fn noise(&self) -> Vec<usize> {
        let share = self.before.is_paired().then_some(Self::SHARE);
        (DRIVE..DRIVE + NOISE).chain(share).collect()
    }
}

/// Parameters of the drive as the model lists them; `by_volts`: it is told voltages.
pub(crate) fn drive_of(model: &RobotModel, by_volts: bool) -> Vec<f64> {
    let plain = |effect: &str, name: &str| model.number(effect, name).unwrap_or(0.0);
    let mut at = vec![0.0; DRIVE];
    at[DELAY] = plain("actuator_delay", "delay_s");
    at[LAG] = plain("actuator_lag", "time_constant_s");
    let [right, left] =
        ["right", "left"].map(|name| model.number("motor_gain", name).unwrap_or(1.0).ln());
    let [right_count, left_count] = ["right_scale", "left_scale"]
        .map(|name| model.number("encoder_scale", name).unwrap_or(1.0).ln());
    at[GAIN] = (right + left + right_count + left_count) / 2.0;
    at[GAIN_ASYMMETRY] = right - left + right_count - left_count;
    at[DEAD_BAND] = plain("command_dead_band", "speed_rad_s");
    at[DEAD_ZONE] = plain("command_dead_zone", "speed_rad_s");
    at[SATURATION] = plain("command_saturation", "speed_rad_s");
    at[SAG] = plain("supply_sag", "rate_per_s");
    at[DELAY] += plain("wheels_latency", "latency_s");
    at[CLOCK] = clock_rate(model, "wheels").unwrap_or(0.0);
    let Some(volts) = volts::of_model(model).filter(|_| by_volts) else {
        return at;
    };
    at[DEAD_ZONE] += plain("command_dead_zone", "voltage_v") * volts.speed_per_volt;
    if let Some(load) = volts.load {
        let per_torque = load.speed_per_torque;
        at[LAG] += load.lag_s();
        at[DEAD_ZONE] += plain("command_dead_zone", "torque_nm") * per_torque;
        at[SATURATION] += plain("command_saturation", "torque_nm") * per_torque;
        at[FRICTION] = plain("axle_friction", "torque_nm") * per_torque;
        let sine = plain("floor_slope", "grade").atan().sin();
        at[PULL] = load.speed_per_sine * sine * plain("floor_slope", "downhill_rad").cos();
    }
    at
}

impl DriveRun {
    fn new(
        robot: &Robot,
        model: &RobotModel,
        excluded_s: &[[f64; 2]],
        first_block: usize,
    ) -> Option<Self> {
        let origin_s = crate::data::origin_of(robot);
        let mut commands = commands(robot, model, origin_s)?;
        let wheels = rows(robot, model, &commands, origin_s, excluded_s)?;
        commands.running = is_running(&wheels, &commands);
        let span_s = [wheels.rows.first()?.time_s, wheels.rows.last()?.time_s];
        Some(Self {
            robot: 0,
            commands,
            blocks: Blocks::new(span_s, first_block),
            wheels,
        })
    }

    /// Median time between rows of the wheels (s).
    pub(crate) fn interval_s(&self) -> f64 {
        let times_s: Vec<f64> = self.wheels.rows.iter().map(|row| row.time_s).collect();
        median_interval(&times_s)
    }

    /// How the wheels would turn as commanded, piece by piece (rad).
    fn course(&self) -> Vec<f64> {
        let rows = &self.wheels.rows;
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Vec::new();
        };
        let response = Response::new(&self.commands, &[0.0; DRIVE]);
        comparison::course(&response, [first.time_s, last.time_s])
    }

    /// Times of the disturbances of sum and difference (s). Torques that disturb a motor under voltage have hardly a memory,
    /// and its speed forgets them as fast as it follows its command: a lasting push is physics.
    pub(crate) fn times_s<S: Scalar>(&self, at: &[S]) -> [S; 2] {
        TIMES.map(|own| {
            let time_s = at[DRIVE + own].exp();
            if self.commands.by_volts {
                time_s * MOST_TIME_S / (time_s + MOST_TIME_S)
            } else {
                time_s
            }
        })
    }

    /// Noise of both channels.
    pub(crate) fn noise<S: Scalar>(&self, at: &[S], tails: Tails) -> [ChannelNoise<S>; 2] {
        let sizes: [S; NOISE] = std::array::from_fn(|i| at[DRIVE + i].exp());
        let least = match self.wheels.kind {
            WheelKind::Angle => self.wheels.rounding_rad,
            WheelKind::Speed => LEAST_SPEED_RAD_S,
        };
        let times_s = self.times_s(at);
        let sensor = ((sizes[6] * sizes[6] + least * least) * 0.5).sqrt();
        [0, 1].map(|channel| {
            let walk = sizes[3 * channel + 2];
            ChannelNoise {
                disturbance_rad_s: sizes[3 * channel],
                time_s: times_s[channel],
                walk: (walk * walk + LEAST_WALK * LEAST_WALK).sqrt(),
                sensor,
                stamp_s: sizes[7],
                tails,
            }
        })
    }

    /// Filters both channels. `after` hears channel, time and disturbance behind every row.
    pub(crate) fn filter<S: Scalar>(
        &self,
        at: &[S],
        tails: Tails,
        sink: &mut dyn FnMut(Innovation<S>),
        after: &mut dyn FnMut(usize, f64, S),
    ) {
        let response = Response::new(&self.commands, at);
        let mut hint = 0;
        let simulated = self.wheels.rows.iter().map(|row| {
            let time_s = S::constant(row.time_s);
            let now = response.averaged(time_s, at[AVERAGED], &mut hint);
            let value = match self.wheels.kind {
                WheelKind::Angle => now.angle_rad,
                WheelKind::Speed => now.speed_rad_s,
            };
            let rest = [0, 1].map(|i| S::constant(row.values[i]) - value[i]);
            (row, rest, now.speed_rad_s)
        });
        let simulated: Vec<_> = simulated.collect();
        for (channel, (sign, noise)) in [1.0, -1.0]
            .into_iter()
            .zip(self.noise(at, tails))
            .enumerate()
        {
            let half = |pair: &[S; 2]| (pair[0] + pair[1] * sign) * 0.5;
            let rows = simulated.iter().map(|(row, rest, speed)| ChannelRow {
                time_s: row.time_s,
                rest: half(rest),
                speed_rad_s: half(speed),
                counts: row.counts,
            });
            let mut after = |t_s: f64, d: S| after(channel, t_s, d);
            match self.wheels.kind {
                WheelKind::Angle => wheel_channel::angles(rows, &noise, sink, &mut after),
                WheelKind::Speed => wheel_channel::speeds(rows, &noise, sink, &mut after),
            }
        }
    }
}

impl CommandToWheels {
    /// Log-likelihood of each block (nats) with such tails.
    fn value_with(&self, tails: Tails, at: &[f64]) -> Vec<f64> {
        let keep = self.before.is_paired();
        let runs = self.runs.par_iter().enumerate().map(|(i, run)| {
            let mut own = vec![0.0; run.blocks.count];
            let mut rows = Vec::new();
            let mut sink = |row: Innovation<f64>| {
                let block = run.blocks.of(row.time_s);
                own[block] += row.weight * row.log_likelihood;
                if keep {
                    rows.push(Whitened::new(&row, run.blocks.first + block));
                }
            };
            run.filter(&self.local(i, at), tails, &mut sink, &mut |_, _, _| ());
            (own, rows)
        });
        let runs: Vec<(Vec<f64>, Vec<Whitened>)> = runs.collect();
        let mut all: Vec<f64> = runs
            .iter()
            .flat_map(|(values, _)| values)
            .copied()
            .collect();
        if keep {
            let share = Share::new(at[Self::SHARE]);
            let (then, now) = runs.split_at(self.before.runs);
            for ((_, first), (_, second)) in then.iter().zip(now) {
                for (block, gain) in pairs::gains(first, second, share) {
                    all[block] += gain;
                }
            }
        }
        all
    }

    /// Score and information of each block with such tails.
    fn score_with(&self, tails: Tails, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        let keep = self.before.is_paired();
        let count = blocks::total(self.runs.iter().map(|run| run.blocks));
        let mut blocks = empty(count, free.len());
        let all = self.runs.par_iter().enumerate().map(|(i, run)| {
            let (local, to) = comparison::lanes(self.places(i).into_iter(), free);
            let filter = |p: &[Dual], sink: &mut dyn FnMut(Innovation<Dual>)| {
                run.filter(p, tails, sink, &mut |_, _, _| ());
            };
            let block = |t_s: f64| run.blocks.first + run.blocks.of(t_s);
            let rows = Rows::new(&self.local(i, at), &local, keep, filter, block);
            (rows, to)
        });
        let all: Vec<(Rows, Vec<(usize, usize)>)> = all.collect();
        for (rows, to) in &all {
            rows.add_to(&mut blocks, to);
        }
        if keep {
            let share = Share::new(at[Self::SHARE]);
            let place = free.iter().position(|own| *own == Self::SHARE);
            let (then, now) = all.split_at(self.before.runs);
            for both in then.iter().zip(now) {
                let sides = [both.0, both.1].map(|(rows, to)| Side { rows, to });
                pairs::add_to(&mut blocks, sides, share, place);
            }
        }
        blocks
    }
}

impl DriveView<'_> {
    fn tails(&self) -> Tails {
        if self.robust {
            Tails::Student
        } else {
            Tails::Normal
        }
    }
}

impl Likelihood for DriveView<'_> {
    fn blocks(&self) -> usize {
        blocks::total(self.drive.runs.iter().map(|run| run.blocks))
    }

    fn run_of(&self) -> Vec<usize> {
        blocks::run_of(self.drive.runs.iter().map(|run| run.blocks))
    }

    fn clusters(&self) -> Option<&[usize]> {
        self.drive.before.clusters.as_deref()
    }

    fn is_shared(&self, _: usize) -> bool {
        let runs = self.drive.runs.len();
        self.drive.before.shows_spread(runs, LEAST_RUNS)
    }

    fn apart(&self, at: &[f64]) -> f64 {
        if self.drive.before.is_paired() {
            Share::new(at[CommandToWheels::SHARE]).value
        } else {
            1.0
        }
    }

    fn loosen(&self, at: &mut [f64]) {
        if self.drive.before.is_paired() {
            at[CommandToWheels::SHARE] = 0.0;
        }
    }

    fn value(&self, at: &[f64]) -> Vec<f64> {
        self.drive.value_with(self.tails(), at)
    }

    fn score(&self, at: &[f64], free: &[usize]) -> Vec<BlockScore> {
        self.drive.score_with(self.tails(), at, free)
    }
}
