//! One diagnosis in a process of its own, which gets only the recording and the nominal model.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::TrialError;
use crate::answer::{self, DiagnosisAnswer};

/// Exit code of a diagnosis whose input is unusable.
const UNUSABLE_INPUT: i32 = 2;
/// Interval between checks whether the process has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(10);

/// The input of a diagnosis.
#[derive(Debug, Clone)]
pub struct DiagnosisInput<'a> {
    /// Folder of the recording.
    pub recording: &'a Path,
    /// Folder of a recording from before; without one, what the model lacks is asked.
    pub against: Option<&'a Path>,
    /// File of the nominal model.
    pub model: &'a Path,
    /// Effects removed from the catalogue.
    pub without: &'a [String],
}

/// The result of a diagnosis.
#[derive(Debug, Clone)]
pub struct DiagnosisRun {
    /// The answer, or why there is none.
    pub answer: Result<DiagnosisAnswer, String>,
    /// Whether it called the input unusable (exit code 2).
    pub refused: bool,
    /// Duration (s).
    pub seconds: f64,
}

/// The program that diagnoses, with its time limit.
#[derive(Debug, Clone)]
pub struct DiagnosisProgram<'a> {
    /// The program; its arguments are those of `slipstream`.
    pub program: &'a Path,
    /// Time limit for one case.
    pub limit: Duration,
    /// Set when the user interrupts.
    pub stop: &'a AtomicBool,
}

impl DiagnosisProgram<'_> {
    /// Diagnoses one case.
    ///
    /// The process runs in a new folder with copies of recording and model under neutral names.
    ///
    /// # Errors
    /// A case that cannot be copied, a program that cannot be started, an interruption.
    pub fn diagnose(&self, case: &DiagnosisInput<'_>) -> Result<DiagnosisRun, TrialError> {
        let folder = tempfile::tempdir().map_err(TrialError::system("a temporary folder"))?;
        copy_folder(case.recording, &folder.path().join("recording"))?;
        copy_file(case.model, &folder.path().join("robot.toml"))?;
        if let Some(before) = case.against {
            copy_folder(before, &folder.path().join("before"))?;
        }
        let messages = folder.path().join("words.txt");
        let file = File::create(&messages).map_err(TrialError::system(messages.display()))?;
        let mut command = Command::new(self.program);
        command
            .current_dir(folder.path())
            .args([
                "diagnose",
                "recording",
                "--robot",
                "robot.toml",
                "--json",
                "answer.json",
            ])
            .args(case.against.iter().flat_map(|_| ["--against", "before"]))
            .args(
                case.without
                    .iter()
                    .flat_map(|effect| ["--without", effect.as_str()]),
            )
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(file);
        let start = Instant::now();
        let child = command
            .spawn()
            .map_err(TrialError::system(self.program.display()))?;
        let ended = self.wait(child, start)?;
        let seconds = start.elapsed().as_secs_f64();
        let refused = ended.and_then(|status| status.code()) == Some(UNUSABLE_INPUT);
        let answer = match ended {
            None => Err(format!("no answer in {:.0} s", self.limit.as_secs_f64())),
            Some(status) if status.success() => read_answer(&folder.path().join("answer.json")),
            Some(status) => Err(last_message(&messages, status)),
        };
        Ok(DiagnosisRun {
            answer,
            refused,
            seconds,
        })
    }

    /// Waits for the process to end; `None` after a timeout.
    fn wait(&self, mut child: Child, start: Instant) -> Result<Option<ExitStatus>, TrialError> {
        loop {
            let ended = child
                .try_wait()
                .map_err(TrialError::system("waiting for diagnose"))?;
            let interrupted = self.stop.load(Ordering::Relaxed);
            if ended.is_some() && !interrupted {
                return Ok(ended);
            }
            if interrupted || start.elapsed() > self.limit {
                // Killing fails if the process has just ended.
                let _ = child.kill();
                let _ = child.wait();
                return if interrupted {
                    Err(TrialError::Interrupted)
                } else {
                    Ok(None)
                };
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

fn read_answer(path: &Path) -> Result<DiagnosisAnswer, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("no answer: {error}"))?;
    answer::parse(&text).map_err(|why| format!("no answer in the contract's form: {why}"))
}

/// The last line that a failed diagnosis wrote.
fn last_message(path: &PathBuf, status: ExitStatus) -> String {
    let text = std::fs::read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&text).into_owned();
    let last = text.lines().rfind(|line| !line.trim().is_empty());
    format!("{status}: {}", last.unwrap_or("no message"))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), TrialError> {
    std::fs::create_dir(to).map_err(TrialError::system(to.display()))?;
    let entries = std::fs::read_dir(from).map_err(|error| case_error(from, &error))?;
    for entry in entries {
        let entry = entry.map_err(TrialError::system(from.display()))?;
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy_folder(&source, &target)?;
        } else {
            copy_file(&source, &target)?;
        }
    }
    Ok(())
}

fn copy_file(from: &Path, to: &Path) -> Result<(), TrialError> {
    let copied = std::fs::copy(from, to);
    copied.map(|_| ()).map_err(|error| case_error(from, &error))
}

fn case_error(path: &Path, error: &std::io::Error) -> TrialError {
    let remedy = "labels stand beside the folders and models that they name";
    TrialError::input(path.display(), error.to_string(), remedy)
}
