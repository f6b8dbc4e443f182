//! How a machine that is told speeds or nothing is predicted with and without what was found, on time that the
//! fit has not seen.

use slipstream_recording::recording::Robot;

use super::claim::Claim;
use super::errors::Errors;
use super::fitted::Fitted;
use super::prediction::{Noise, Predictor, SHORTEST_S, deviations};
use super::search::problem;
use crate::data::streams::WheelKind;
use crate::estimate::masked::Masked;
use crate::estimate::scoring::SHORT;
use crate::judge::{Predictions, QUANTITIES, Worth};
use crate::model::command_to_wheels::DriveRun;
use crate::model::drive::DRIVE;
use crate::model::from_wheels::{FromWheels, Reference};
use crate::model::run::Run;
use crate::model::streams::{Joint, ROBUST};
use crate::model::view::View;
use crate::predict::predictor::unit;
use crate::predict::window::at_most;

/// Parts of the windows that are predicted by what was fitted to the others.
const FOLDS: usize = 5;
/// A row with a smaller probability of being ordinary is an outlier.
pub(super) const ORDINARY: f64 = 0.5;
/// Share of all poses up to which outliers are few.
const FEW: f64 = 0.1;
/// A window begins this long after an outlier (s).
const AFTER_S: f64 = 1e-6;
/// Most windows of a run that a budget predicts.
const BUDGET_WINDOWS: usize = 40;
/// Most effects of a budget: every subset of them is predicted once.
const PLAYERS: usize = 10;

/// Number of a run, and begin and end (s) of a window of it.
type RunWindow = (usize, [f64; 2]);

/// Claims of one effect, and the parameters of the machine that they explain.
struct Player {
    name: &'static str,
    toggles: Vec<usize>,
}

/// A machine and what was fitted to it.
pub(super) struct Measured<'a> {
    pub(super) name: &'a str,
    pub(super) robots: &'a [&'a Robot],
    pub(super) fitted: Fitted<'a>,
}

/// The same with what was found.
pub(super) struct Bench<'a> {
    own: &'a Measured<'a>,
    players: Vec<Player>,
    /// What the filters of the machine read with everything that was fitted, and the noise of its drive.
    pub(super) all: Vec<f64>,
    drive_noise: Option<Vec<f64>>,
    /// The same without and with what was found.
    pub(super) nominal: Vec<f64>,
    pub(super) found: Vec<f64>,
    /// Standard deviations of the sensors of each run.
    pub(super) deviations: Vec<[f64; QUANTITIES]>,
    /// Windows of all runs.
    windows: Vec<RunWindow>,
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
    /// The bench of these claims.
    pub(super) fn new(own: &'a Measured<'a>, claims: &[Claim]) -> Self {
        let fitted = &own.fitted;
        let at = &fitted.found.selected.fit.at;
        let drive = fitted.drive_at(at);
        let mut bench = Self {
            own,
            players: players(claims),
            all: fitted.machine_at(at),
            drive_noise: drive.map(|own| own[DRIVE..].to_vec()),
            // biases of single runs belong to sensors and are no effect
            nominal: fitted.machine_at(&fitted.nuisances(at)),
            found: Vec::new(),
            deviations: Vec::new(),
            windows: Vec::new(),
        };
        bench.found = bench.with(at);
        let machine = bench.machine();
        let runs = machine.runs.iter();
        bench.deviations = runs
            .map(|run| deviations(run, bench.drive_of(run.robot), &own.robots[run.robot].noise))
            .collect();
        bench.windows = bench.cut();
        bench
    }

    /// Fitted parameters with what was found alone.
    pub(super) fn found_at(&self) -> Vec<f64> {
        self.found_in(&self.own.fitted.found.selected.fit.at)
    }

    /// Of fitted parameters, what the claims explain, and nuisances.
    fn found_in(&self, at: &[f64]) -> Vec<f64> {
        let own = self.players.iter().flat_map(|player| &player.toggles);
        self.own.fitted.with(at, own)
    }

    /// Drives of all runs of which both commands and wheels were recorded.
    fn drives(&self) -> impl Iterator<Item = &'a DriveRun> {
        let drive = self.own.fitted.streams.drive;
        drive.into_iter().flat_map(|drive| &drive.runs)
    }

    fn machine(&self) -> &'a FromWheels {
        self.own.fitted.streams.reference
    }

    /// The machine with what the claims explain as in `at`.
    fn with(&self, at: &[f64]) -> Vec<f64> {
        self.own.fitted.machine_at(&self.found_in(at))
    }

    fn drive_of(&self, robot: usize) -> Option<&'a DriveRun> {
        self.drives().find(|drive| drive.robot == robot)
    }

    /// What predicts a run.
    pub(super) fn predictor(&self, run: usize) -> Predictor<'_> {
        let own = &self.machine().runs[run];
        Predictor {
            machine: self.machine(),
            run: own,
            drive: self.drive_of(own.robot),
            deviations: self.deviations[run],
            noise: Some(Noise {
                at: &self.all,
                drive: self.drive_noise.as_deref(),
            }),
        }
    }

    /// Windows of all runs. Where a few poses jump, no prediction runs over them: they count as outliers, which
    /// are told, and say nothing of the model.
    fn cut(&self) -> Vec<RunWindow> {
        let view = View {
            machine: self.machine(),
            robust: true,
        };
        let of_run = |(i, run): (usize, &Run)| {
            let windows = self.predictor(i).windows();
            let Some(pose) = &run.pose else {
                return windows;
            };
            let jumps_s = view.extraordinary_of(Reference::Pose, i, &self.all, ORDINARY);
            if jumps_s.len() as f64 > FEW * pose.all.len() as f64 {
                return windows;
            }
            cut(&windows, &jumps_s)
        };
        let runs = self.machine().runs.iter().enumerate();
        runs.flat_map(|own| of_run(own).into_iter().map(move |window| (own.0, window)))
            .collect()
    }

    /// Predicts every window of each run by the nominal model, and by a model fitted without it.
    pub(super) fn errors(&self) -> Vec<[Errors; 2]> {
        let folds = self.folds();
        let mut all: Vec<[Errors; 2]> = Vec::new();
        all.resize_with(self.machine().runs.len(), Default::default);
        for (k, (run, window)) in self.windows.iter().enumerate() {
            let predictor = self.predictor(*run);
            let sides = [&self.nominal, &folds[k % folds.len()]];
            for (sum, at) in all[*run].iter_mut().zip(sides) {
                let own = predictor.errors(*run, at, &[*window]);
                *sum = std::mem::take(sum).and(own);
            }
        }
        all
    }

    /// Parameters fitted without the windows of each fold; with a single window there is nothing beside it.
    fn folds(&self) -> Vec<Vec<f64>> {
        let count = self.windows.len();
        if self.players.is_empty() || count < 2 {
            return vec![self.found.clone()];
        }
        let folds = FOLDS.min(count);
        let left_out = |fold: usize| self.windows.iter().skip(fold).step_by(folds);
        (0..folds)
            .map(|fold| self.fitted_without(&left_out(fold).collect::<Vec<_>>()))
            .collect()
    }

    /// The machine as it is fitted without these windows.
    fn fitted_without(&self, left_out: &[&RunWindow]) -> Vec<f64> {
        let Fitted { streams, found } = self.own.fitted;
        let runs = &streams.reference.runs;
        let is_left_out = |robot: usize, t_s: f64| {
            let mut own = left_out.iter().filter(|(run, _)| runs[*run].robot == robot);
            own.any(|(_, [from_s, to_s])| (*from_s..*to_s).contains(&t_s))
        };
        let of_machine = runs.iter().map(|run| (run.blocks, run.robot));
        let of_drive = self.drives().map(|run| (run.blocks, run.robot));
        let mask = of_machine.chain(of_drive).flat_map(|(blocks, robot)| {
            let middles = (0..blocks.count).map(move |block| blocks.middle_s(block));
            middles.map(move |t_s| (robot, t_s))
        });
        let mask: Vec<bool> = mask.map(|(robot, t_s)| is_left_out(robot, t_s)).collect();
        let joint = Joint::new(streams, &found.nominal, &found.table.weights, ROBUST);
        let masked = Masked {
            inner: &joint,
            left_out: &mask,
        };
        let fit = &found.selected.fit;
        let at = problem(&masked, &found.table)
            .fit(&fit.at, &fit.free, SHORT)
            .at;
        self.with(&at)
    }

    /// What every subset of the effects that were found is worth.
    pub(super) fn worth(&self) -> Worth {
        let of_runs = self.windows.chunk_by(|(a, _), (b, _)| a == b);
        let windows = of_runs.flat_map(|own| at_most(own, BUDGET_WINDOWS));
        let windows: Vec<RunWindow> = windows.collect();
        let players = &self.players[..self.players.len().min(PLAYERS)];
        let fitted = &self.own.fitted;
        let fit = &fitted.found.selected.fit.at;
        Worth::new(players.iter().map(|own| own.name).collect(), |left_out| {
            let own = players.iter().filter(|own| !left_out.contains(&own.name));
            let kept = own.flat_map(|player| &player.toggles);
            let at = fitted.machine_at(&fitted.with(fit, kept));
            let of_runs = windows.chunk_by(|(a, _), (b, _)| a == b);
            let scores = of_runs.map(|own| {
                let (run, _) = own[0];
                let windows: Vec<[f64; 2]> = own.iter().map(|(_, window)| *window).collect();
                self.predictor(run).errors(run, &at, &windows).score
            });
            scores.collect()
        })
    }

    /// What the judge is told of the machine.
    pub(super) fn predictions(&self, errors: &[[Errors; 2]]) -> Predictions {
        let runs = errors.iter().zip(&self.machine().runs);
        let spans = runs.flat_map(|(pair, run)| {
            let own = pair[1].windows.iter();
            own.map(|(window, _)| window.map(|t_s| t_s + run.origin_s))
        });
        let side = |side: usize| {
            let windows = errors.iter().flat_map(|pair| &pair[side].windows);
            windows.map(|(_, score)| *score).collect()
        };
        Predictions::new(self.own.name, spans.collect(), [side(0), side(1)])
    }

    /// Unit of a channel.
    pub(super) fn unit(&self, channel: usize) -> &'static str {
        let mut drives = self.drives();
        let angles = drives.all(|drive| drive.wheels.kind == WheelKind::Angle);
        unit(channel, angles)
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
