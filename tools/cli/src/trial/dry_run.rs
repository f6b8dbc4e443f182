//! `slipstream trial --dry-run`: what the trial costs, from a few of its cases.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use slipstream_trial::diagnosis_process::DiagnosisProgram;
use slipstream_trial::protocol::{diagnose_all, questions};
use slipstream_trial::sealed_trial::SealedTrial;

use super::arguments::Arguments;
use super::cases::Cases;
use super::temporary_folder::temporary_folder;
use crate::estimate::{self, Work, sample, spread};
use crate::exit::{Error, Exit};
use crate::print::print_line;

/// So many cases are diagnosed, as one takes ten times as long as another, and more until this time has passed.
const SAMPLE_CASES: usize = 4;
const SAMPLE_TIME: Duration = Duration::from_secs(10);

/// Runs the command.
pub(super) fn run(arguments: &Arguments, cases: &Cases, stop: &AtomicBool) -> Result<Exit, Error> {
    let program = arguments.program()?;
    let program = DiagnosisProgram {
        program: &program,
        limit: Duration::from_secs(arguments.limit_s),
        stop,
    };
    let temporary = temporary_folder()?;
    let without = &arguments.without;
    let diagnose = |at: usize| score_one(cases, at, without, temporary.path(), &program);
    let sample = sample(
        spread(cases.count()).into_iter(),
        SAMPLE_CASES,
        SAMPLE_TIME,
        diagnose,
    )?;
    let work = Work {
        pieces: cases.count(),
        name: "cases",
        divisible_by: cases.count(),
        threads: 1,
    };
    print_line!("{} cases", work.pieces);
    estimate::print(work, sample, "");
    Ok(Exit::Done)
}

/// Makes and diagnoses one case.
fn score_one(
    cases: &Cases,
    at: usize,
    without: &[String],
    temporary: &Path,
    program: &DiagnosisProgram<'_>,
) -> Result<(), Error> {
    let (folder, questions) = match cases {
        Cases::New(planned) => {
            let folder = temporary.join(at.to_string());
            let trial = SealedTrial::make(&planned[at..=at], &folder, || Ok(()))?;
            (folder, trial.questions(without))
        }
        Cases::Labelled(folder, labels) => {
            let all = questions(labels, without);
            (folder.clone(), all[at..=at].to_vec())
        }
    };
    diagnose_all(program, &folder, &questions, |_, _| {})?;
    Ok(())
}
