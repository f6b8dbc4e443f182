//! How a machine that is told speeds or nothing is predicted with and without what was found, on time that the
//! fit has not seen.

use slipstream_recording::recording::Robot;

use super::calibration::Calibration;
use super::claim::Claim;
use super::drive::DriveFit;
use super::open_loop::HORIZON_S;
use super::prediction::{Errors, Noise, Predictor, SHORTEST_S, deviations};
use crate::answer::{Budget, HeldOut};
use crate::data::wheel_rows::WheelKind;
use crate::estimate::blocks::Blocks;
use crate::estimate::masked::Masked;
use crate::estimate::scoring::SHORT;
use crate::judge::{
    self, HEADING, Judged, NAMES, PLACE, Player, QUANTITIES, Score, Squares, culprits,
};
use crate::model::command_to_wheels::CommandToWheels;
use crate::model::drive::{DRIVE, SLOW_SHARE};
use crate::model::from_wheels::{
    DRIVE_FIRST, FromWheels, RUN_BIAS, RUN_LATE, RUN_RATE, Reference, View,
};

/// Parts of the windows that are predicted by what was fitted to the others.
const FOLDS: usize = 5;
/// A pose with a smaller probability of being ordinary is an outlier, and the share of all poses up to which
/// outliers are few.
const ORDINARY: f64 = 0.5;
const FEW: f64 = 0.1;
/// A window begins this long after an outlier (s).
const AFTER_S: f64 = 1e-6;
/// Most windows of a run that a budget predicts.
const BUDGET_WINDOWS: usize = 40;
/// Most players of a budget: every subset of them is predicted once.
const PLAYERS: usize = 10;

/// A machine and what was fitted to it.
pub(super) struct Measured<'a> {
    pub(super) name: &'a str,
    pub(super) robots: &'a [&'a Robot],
    pub(super) machine: &'a FromWheels,
    pub(super) nominal: &'a [f64],
    pub(super) drive: Option<&'a CommandToWheels>,
    pub(super) calibration: Option<&'a Calibration>,
    pub(super) driven: Option<&'a DriveFit>,
}

/// The same with what was found.
pub(super) struct Bench<'a> {
    own: &'a Measured<'a>,
    players: Vec<Player>,
    /// All parameters as they were fitted.
    all: &'a [f64],
    /// Parameters without and with what was found.
    pub(super) nominal: Vec<f64>,
    pub(super) fitted: Vec<f64>,
    /// Standard deviations of the sensors of each run.
    pub(super) deviations: Vec<[f64; QUANTITIES]>,
}

/// The predictions of each run, without and with what was found.
pub(super) struct Predicted {
    pub(super) errors: Vec<[Errors; 2]>,
    before: Score,
    after: Score,
}

/// The players of these claims, those that bring most first.
fn players(claims: &[Claim]) -> Vec<Player> {
    let mut players: Vec<Player> = Vec::new();
    for claim in claims {
        match players.iter_mut().find(|own| own.name == claim.effect) {
            Some(own) => own.toggles.extend(&claim.toggles),
            None => players.push(Player {
                name: claim.effect,
                toggles: claim.toggles.clone(),
            }),
        }
    }
    players
}

impl<'a> Bench<'a> {
    /// The bench of these claims; `all` are the parameters as they were fitted.
    pub(super) fn new(own: &'a Measured<'a>, claims: &[Claim], all: &'a [f64]) -> Self {
        let mut bench = Self {
            own,
            players: players(claims),
            all,
            nominal: own.nominal.to_vec(),
            fitted: Vec::new(),
            deviations: Vec::new(),
        };
        // biases and clocks of single runs belong to sensors and are no effect
        for run in 0..own.machine.runs.len() {
            for parameter in [RUN_BIAS, RUN_LATE, RUN_RATE] {
                let index = own.machine.of_run(run, parameter);
                bench.nominal[index] = all[index];
            }
        }
        bench.fitted = bench.with(all);
        let runs = own.machine.runs.iter();
        bench.deviations = runs
            .map(|run| deviations(run, bench.drive_of(run.robot), &own.robots[run.robot].noise))
            .collect();
        bench
    }

    /// Nominal parameters with those that the claims explain as in `at`.
    fn with(&self, at: &[f64]) -> Vec<f64> {
        let mut with = self.nominal.clone();
        for index in self.players.iter().flat_map(|player| &player.toggles) {
            with[*index] = at[*index];
        }
        with
    }

    fn drive_of(&self, robot: usize) -> Option<&'a crate::model::command_to_wheels::DriveRun> {
        let mut drives = self.own.drive.iter().flat_map(|drive| &drive.runs);
        drives.find(|drive| drive.robot == robot)
    }

    /// What predicts a run.
    pub(super) fn predictor(&self, run: usize) -> Predictor<'_> {
        let own = &self.own.machine.runs[run];
        Predictor {
            machine: self.own.machine,
            run: own,
            drive: self.drive_of(own.robot),
            deviations: self.deviations[run],
            noise: Some(Noise {
                at: self.all,
                drive: self.own.driven.map(|own| &own.after.fit.at[DRIVE..]),
            }),
        }
    }

    /// Windows of each run. Where a few poses jump, no prediction runs over them: they count as outliers, which
    /// are told, and say nothing of the model.
    fn windows(&self) -> Vec<Vec<[f64; 2]>> {
        let view = View {
            machine: self.own.machine,
            robust: true,
        };
        let runs = self.own.machine.runs.iter().enumerate();
        runs.map(|(i, run)| {
            let windows = self.predictor(i).windows();
            let Some(pose) = &run.pose else {
                return windows;
            };
            let jumps_s = view.extraordinary_of(Reference::Pose, i, self.all, ORDINARY);
            if jumps_s.len() as f64 > FEW * pose.all.len() as f64 {
                return windows;
            }
            cut(&windows, &jumps_s)
        })
        .collect()
    }

    /// Predicts every window by the nominal model, and by a model fitted without it.
    pub(super) fn judged(&self) -> Predicted {
        let windows = self.windows();
        let folds = self.folds(&windows);
        let each = windows.iter().enumerate().map(|(run, own)| {
            let predictor = self.predictor(run);
            let before = predictor.errors(run, &self.nominal, own, true);
            let first: usize = windows[..run].iter().map(Vec::len).sum();
            let after = own.iter().enumerate().map(|(k, window)| {
                let at = &folds[(first + k) % folds.len()];
                predictor.errors(run, at, &[*window], true)
            });
            [before, after.fold(Errors::default(), Errors::and)]
        });
        let errors: Vec<[Errors; 2]> = each.collect();
        let sum = |side: usize| Score::of_all(errors.iter().map(|pair| &pair[side].score));
        Predicted {
            before: sum(0),
            after: sum(1),
            errors,
        }
    }

    /// Parameters fitted without the windows of each fold; with a single window there is nothing beside it.
    fn folds(&self, windows: &[Vec<[f64; 2]>]) -> Vec<Vec<f64>> {
        let count = windows.iter().map(Vec::len).sum::<usize>();
        if self.players.is_empty() || count < 2 {
            return vec![self.fitted.clone()];
        }
        let folds = 0..FOLDS.min(count);
        let folds_count = folds.len();
        folds
            .map(|fold| {
                let mut number = 0..;
                let left_out: Vec<Vec<[f64; 2]>> = windows
                    .iter()
                    .map(|own| {
                        let own = own.iter().zip(&mut number);
                        let own = own.filter(|(_, k)| k % folds_count == fold);
                        own.map(|(window, _)| *window).collect()
                    })
                    .collect();
                self.fitted_without(&left_out)
            })
            .collect()
    }

    /// Parameters fitted without these times (s) of each run.
    fn fitted_without(&self, left_out: &[Vec<[f64; 2]>]) -> Vec<f64> {
        let Measured {
            machine,
            drive,
            calibration,
            driven,
            nominal,
            ..
        } = self.own;
        let runs = machine.runs.iter().zip(left_out);
        let times_of = |robot: usize| {
            let own = runs.clone().find(|(run, _)| run.robot == robot);
            own.map_or(&[][..], |(_, times)| times.as_slice())
        };
        let mut at = self.all.to_vec();
        if let Some(calibration) = calibration {
            let view = View {
                machine,
                robust: true,
            };
            let own = machine
                .runs
                .iter()
                .map(|run| (run.blocks, times_of(run.robot)));
            let masked = Masked {
                inner: &view,
                left_out: &mask(own),
            };
            let problem = machine.problem(&masked, nominal);
            let fit = &calibration.after.fit;
            at = problem.fit(&fit.at, &fit.free, SHORT).at;
        }
        if let (Some(found), Some(drive)) = (driven, drive) {
            let own = drive
                .runs
                .iter()
                .map(|run| (run.blocks, times_of(run.robot)));
            let masked = Masked {
                inner: *drive,
                left_out: &mask(own),
            };
            let problem = drive.problem(&masked, &found.nominal);
            let fit = &found.after.fit;
            let other = problem.fit(&fit.at, &fit.free, SHORT).at;
            at[DRIVE_FIRST..DRIVE_FIRST + DRIVE].copy_from_slice(&other[..DRIVE]);
        }
        at[DRIVE_FIRST + SLOW_SHARE] = 0.0;
        self.with(&at)
    }

    /// What every subset of the players (as bits) scores on some windows, all fitted together.
    fn worth(&self) -> Vec<Score> {
        let windows: Vec<Vec<[f64; 2]>> = self
            .windows()
            .into_iter()
            .map(|all| {
                let stride = all.len().div_ceil(BUDGET_WINDOWS).max(1);
                all.into_iter().step_by(stride).collect()
            })
            .collect();
        let players = &self.players[..self.players.len().min(PLAYERS)];
        let subsets = 0..1_usize << players.len();
        subsets
            .map(|subset| {
                let mut at = self.nominal.clone();
                let own = players.iter().enumerate();
                for (_, player) in own.filter(|(i, _)| subset >> i & 1 == 1) {
                    player.toggles.iter().for_each(|i| at[*i] = self.fitted[*i]);
                }
                let runs = windows.iter().enumerate();
                let scores =
                    runs.map(|(run, own)| self.predictor(run).errors(run, &at, own, false).score);
                scores.fold(Score::default(), |sum, own| sum.and(&own))
            })
            .collect()
    }

    /// Of quantities that are predicted worse, the effect that makes the first of them so.
    pub(super) fn culprit(&self, worse: &[usize]) -> Option<(&'static str, &'static str)> {
        let quantity = *worse.iter().max()?;
        let worth = self.worth();
        let squares: Option<Vec<f64>> = worth.iter().map(|own| own.mean_square(quantity)).collect();
        let count = self.players.len().min(PLAYERS);
        let (player, _) = *culprits(count, &squares?).first()?;
        let player = self.players.get(player)?;
        Some((player.name, NAMES[quantity]))
    }

    /// Where the error of position and heading went.
    pub(super) fn budget(&self, predicted: &Predicted) -> Vec<Budget> {
        let worth = self.worth();
        let names: Vec<&str> = self
            .players
            .iter()
            .take(PLAYERS)
            .map(|own| own.name)
            .collect();
        let both = [("m", PLACE), ("rad", HEADING)];
        let own = both.into_iter().filter_map(|(unit, quantity)| {
            let squares = Squares {
                robot: self.own.name,
                unit,
                held_out: [
                    predicted.before.mean_square(quantity)?,
                    predicted.after.mean_square(quantity)?,
                ],
                sensor: predicted.after.sensor(quantity)?,
                expected: predicted.after.expected(quantity)?,
            };
            let worth: Option<Vec<f64>> =
                worth.iter().map(|own| own.mean_square(quantity)).collect();
            judge::budget(&squares, &names, &worth?)
        });
        own.collect()
    }

    fn unit(&self, channel: usize) -> &'static str {
        let mut drives = self.own.drive.iter().flat_map(|drive| &drive.runs);
        let speeds = drives.any(|drive| drive.wheels.kind == WheelKind::Speed);
        match NAMES[channel] {
            "pose_x" | "pose_y" => "m",
            "imu_gz" => "rad/s",
            "wheel_right" | "wheel_left" if speeds => "rad/s",
            _ => "rad",
        }
    }
}

impl Predicted {
    /// Quantities that are predicted worse than by the nominal model.
    pub(super) fn worse(&self) -> Vec<usize> {
        let side = |side: usize| {
            let windows = self.errors.iter().flat_map(|pair| &pair[side].windows);
            windows.map(|(_, score)| *score).collect::<Vec<Score>>()
        };
        judge::worse(&side(0), &side(1))
    }

    pub(super) fn held_out(&self, bench: &Bench<'_>) -> HeldOut {
        let both = [&self.before, &self.after];
        judge::held_out(bench.own.name, HORIZON_S, both, &|channel| {
            bench.unit(channel)
        })
    }

    /// What the judge is told of the machine.
    pub(super) fn machine(&self, name: &str, machine: &FromWheels) -> Judged {
        let runs = self.errors.iter().zip(&machine.runs);
        let windows = runs.flat_map(|(pair, run)| {
            let own = pair[1].windows.iter();
            own.map(|(window, score)| (window.map(|t_s| t_s + run.origin_s), *score))
        });
        Judged {
            robot: name.to_owned(),
            before: self.before,
            after: self.after,
            windows: windows.collect(),
            refused: Vec::new(),
        }
    }
}

/// Windows cut at these times (s, rising), without pieces that are too short.
fn cut(windows: &[[f64; 2]], times_s: &[f64]) -> Vec<[f64; 2]> {
    let mut pieces = Vec::new();
    for [from_s, to_s] in windows {
        let inside = times_s.iter().filter(|t_s| (*from_s..*to_s).contains(*t_s));
        let mut begin = *from_s;
        for end in inside.chain([to_s]) {
            pieces.push([begin, *end]);
            begin = *end + AFTER_S;
        }
    }
    pieces.retain(|[from_s, to_s]| to_s - from_s >= SHORTEST_S);
    pieces
}

/// Which blocks of runs lie in times (s) that are left out.
fn mask<'a>(runs: impl Iterator<Item = (Blocks, &'a [[f64; 2]])>) -> Vec<bool> {
    let own = runs.flat_map(|(blocks, times)| {
        (0..blocks.count).map(move |block| {
            let middle_s = blocks.middle_s(block);
            times.iter().any(|[a, b]| (*a..*b).contains(&middle_s))
        })
    });
    own.collect()
}
