//! The 24 numbers as the simulation has them, with any causes.

use rayon::prelude::*;
use slipstream_bus::Experiment;
use slipstream_launch::{Request, in_process, resolve};

use super::candidate::{Candidate, Kind, Scope};
use super::numbers::{Numbers, places};
use crate::StudyError;

/// Where a robot starts, and where it ends by its encoders and in truth: x (m), y (m).
#[derive(Debug, Clone, Copy)]
struct StartAndEnds {
    start: [f64; 2],
    encoder: [f64; 2],
    truth: [f64; 2],
}

/// The paper's two experiments with the platoon as they are assumed: without and with the limit.
#[derive(Debug, Clone)]
pub(super) struct Simulation {
    experiments: [Experiment; 2],
}

impl Simulation {
    /// The experiments as their file assumes them.
    pub(super) fn new() -> Result<Self, StudyError> {
        let experiment = |limit: &str| {
            let request = Request {
                experiment: Some("platoon".to_owned()),
                set: vec![("control.torque_limit".to_owned(), limit.to_owned())],
                ..Request::default()
            };
            resolve(&request).map(|resolved| resolved.experiment)
        };
        Ok(Self {
            experiments: [experiment("none")?, experiment("outer")?],
        })
    }

    /// Where robots end with these causes.
    fn ends(&self, causes: &[(Candidate, f64)]) -> Result<[[StartAndEnds; 3]; 2], StudyError> {
        let run = |number: usize| {
            let mut experiment = self.experiments[number].clone();
            for (cause, size) in causes {
                cause.change(*size, number, &mut experiment);
            }
            run(&experiment)
        };
        Ok([run(0)?, run(1)?])
    }

    /// The numbers with these causes.
    pub(super) fn numbers(&self, causes: &[(Candidate, f64)]) -> Result<Numbers, StudyError> {
        Ok(numbers(&self.ends(causes)?, causes))
    }
}

/// The numbers of robots that end so, as the tape says them with these causes.
fn numbers(ends: &[[StartAndEnds; 3]; 2], causes: &[(Candidate, f64)]) -> Numbers {
    places().map(|own| {
        let StartAndEnds {
            start,
            encoder,
            truth,
        } = ends[own.experiment][own.robot];
        let acting = causes
            .iter()
            .filter(|(cause, _)| cause.acts(own.experiment, own.robot));
        let taped = |end, (cause, size): &(Candidate, f64)| cause.kind.taped(*size, start, end);
        let end = if own.is_taped {
            acting.fold(truth, taped)
        } else {
            encoder
        };
        end[own.axis]
    })
}

/// Where the three robots start and end.
fn run(experiment: &Experiment) -> Result<[StartAndEnds; 3], StudyError> {
    let reports = in_process::run(experiment, false)?;
    Ok([0, 1, 2].map(|robot| {
        let plane = |[x, y, _]: [f64; 3]| [x, y];
        StartAndEnds {
            start: plane(experiment.robots[robot].pose),
            encoder: plane(reports.agents[robot].final_odometry),
            truth: plane(reports.plant.robots[robot].final_true),
        }
    }))
}

/// Sizes at which a response is simulated, as shares of the largest.
const SHARES: [f64; 11] = [
    -1.0, -0.75, -0.5, -0.3, -0.15, 0.0, 0.15, 0.3, 0.5, 0.75, 1.0,
];

/// How the numbers change with the size of one cause alone, by linear interpolation between simulated sizes (m).
#[derive(Debug, Clone)]
pub(super) struct Response {
    pub(super) candidate: Candidate,
    changes: Vec<Numbers>,
}

impl Response {
    /// The responses to all candidates. A cause of one robot or one experiment changes there what it changes if it acts on
    /// all: robots hear of each other by their encoders alone.
    pub(super) fn all(simulation: &Simulation) -> Result<Vec<Self>, StudyError> {
        let nominal = simulation.ends(&[])?;
        let mut of_all: Vec<(Kind, Vec<Numbers>)> = Vec::new();
        let mut responses = Vec::new();
        for candidate in Candidate::all() {
            let kind = candidate.kind;
            let known = of_all.iter().position(|(own, _)| *own == kind);
            let place = match known {
                Some(place) => place,
                None => {
                    of_all.push((kind, changes(simulation, kind, &nominal)?));
                    of_all.len() - 1
                }
            };
            let own = of_all[place].1.iter().map(|change| {
                let mut change = *change;
                for (number, own) in change.iter_mut().zip(places()) {
                    if !candidate.acts(own.experiment, own.robot) {
                        *number = 0.0;
                    }
                }
                change
            });
            responses.push(Self {
                candidate,
                changes: own.collect(),
            });
        }
        Ok(responses)
    }

    /// The change of the numbers at a size (m).
    pub(super) fn at(&self, size: f64) -> Numbers {
        let share = (size / self.candidate.kind.largest()).clamp(-1.0, 1.0);
        let above = SHARES
            .partition_point(|own| *own < share)
            .clamp(1, SHARES.len() - 1);
        let [low, high] = [above - 1, above];
        let part = (share - SHARES[low]) / (SHARES[high] - SHARES[low]);
        let [low, high] = [&self.changes[low], &self.changes[high]];
        std::array::from_fn(|i| low[i] + part * (high[i] - low[i]))
    }

    /// The sizes that were simulated, without 0.
    pub(super) fn sizes(&self) -> impl Iterator<Item = f64> {
        let largest = self.candidate.kind.largest();
        SHARES
            .into_iter()
            .filter(|own| *own != 0.0)
            .map(move |own| own * largest)
    }
}

/// What a kind changes at each of [`SHARES`] if it acts on all robots.
fn changes(
    simulation: &Simulation,
    kind: Kind,
    nominal: &[[StartAndEnds; 3]; 2],
) -> Result<Vec<Numbers>, StudyError> {
    let before = numbers(nominal, &[]);
    let change = |share: f64| {
        let cause = [(
            Candidate {
                kind,
                scope: Scope::All,
            },
            share * kind.largest(),
        )];
        let after = match kind.is_of_tape() {
            true => numbers(nominal, &cause),
            false => simulation.numbers(&cause)?,
        };
        Ok(std::array::from_fn(|i| after[i] - before[i]))
    };
    SHARES.into_par_iter().map(change).collect()
}
