//! Agreement between the separate diagnoses of several runs of one machine.

use std::collections::BTreeMap;

use slipstream_answer::Finding;
use slipstream_diagnose::InputError;
use slipstream_recording::Recording;

use crate::study::{Found, Study};

/// Recordings of one machine.
const TOGETHER: [&[&str]; 1] = [&["trento-wheelchair-01", "trento-wheelchair-03"]];

/// An estimate and its 95 % interval.
pub(crate) type Estimate = (f64, [f64; 2]);

/// Estimates of each parameter by the runs of one machine, or of machines of one type.
pub(crate) struct Agreement {
    pub(crate) runs: Vec<String>,
    /// Estimate of each run, by effect and parameter with its unit.
    pub(crate) rows: BTreeMap<(String, String), Vec<Option<Estimate>>>,
}

impl Agreement {
    fn new(runs: Vec<(String, Vec<&Finding>)>) -> Self {
        let mut rows: BTreeMap<(String, String), Vec<Option<Estimate>>> = BTreeMap::new();
        for (run, (_, findings)) in runs.iter().enumerate() {
            for finding in findings {
                for parameter in &finding.parameters {
                    let estimate = parameter.estimate.zip(parameter.ci95);
                    let unit = match parameter.unit.as_str() {
                        "1" => String::new(),
                        unit => format!(" ({unit})"),
                    };
                    let key = (finding.effect.clone(), format!("{}{unit}", parameter.name));
                    let row = rows.entry(key).or_insert_with(|| vec![None; runs.len()]);
                    if estimate.is_some() {
                        row[run] = estimate;
                    }
                }
            }
        }
        rows.retain(|_, row| row.iter().any(Option::is_some));
        let runs = runs.into_iter().map(|(name, _)| name).collect();
        Self { runs, rows }
    }
}

/// Whether all runs found it and their intervals have a value in common.
pub(crate) fn agree(row: &[Option<Estimate>]) -> bool {
    let all: Option<Vec<[f64; 2]>> = row.iter().map(|one| one.map(|(_, ci)| ci)).collect();
    all.is_some_and(|all| {
        let low = all.iter().map(|ci| ci[0]).fold(f64::NEG_INFINITY, f64::max);
        let high = all.iter().map(|ci| ci[1]).fold(f64::INFINITY, f64::min);
        low <= high
    })
}

/// The agreement of each group of runs that is there.
pub(crate) fn agreements(
    recordings: &[Recording],
    studies: &[Study<'_>],
) -> Result<Vec<Agreement>, InputError> {
    let mut list = Vec::new();
    for names in TOGETHER {
        let own: Vec<&Study<'_>> = studies
            .iter()
            .filter(|study| names.contains(&study.recording.name.as_str()))
            .collect();
        let runs = own.iter().map(|study| {
            let findings = study.found.answer.findings.iter().collect();
            (study.recording.name.clone(), findings)
        });
        if own.len() > 1 {
            list.push(Agreement::new(runs.collect()));
        }
    }
    for (recording, study) in recordings.iter().zip(studies) {
        if recording.robots.len() < 2 {
            continue;
        }
        if recording.same_robot {
            let alone: Result<Vec<Found>, InputError> = (0..recording.robots.len())
                .map(|i| Found::new(&[alone(recording, &[i])], &[]))
                .collect();
            let alone = alone?;
            let runs =
                recording.robots.iter().zip(&alone).map(|(robot, found)| {
                    (robot.name.clone(), found.answer.findings.iter().collect())
                });
            list.push(Agreement::new(runs.collect()));
        } else {
            let runs = recording.robots.iter().map(|robot| {
                let all = study.found.answer.findings.iter();
                let own = all.filter(|finding| finding.robot == robot.name);
                (robot.name.clone(), own.collect())
            });
            list.push(Agreement::new(runs.collect()));
        }
    }
    Ok(list)
}

/// The recording of these robots alone.
pub(crate) fn alone(recording: &Recording, robots: &[usize]) -> Recording {
    let robots = robots.iter().map(|i| recording.robots[*i].clone());
    Recording {
        robots: robots.collect(),
        links: None,
        ..recording.clone()
    }
}
