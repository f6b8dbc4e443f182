//! One diagnosis in a process of its own, that sees the recording and the nominal model alone.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::TrialError;
use crate::answer::{self, Answer};

/// How often the process is looked at.
const LOOK: Duration = Duration::from_millis(10);

/// What is handed to a diagnosis.
#[derive(Debug, Clone)]
pub struct Case<'a> {
    /// The recording's folder.
    pub recording: &'a Path,
    /// The nominal model.
    pub model: &'a Path,
    /// Effects that are taken out of the catalogue.
    pub without: &'a [String],
}

/// How a diagnosis ended.
#[derive(Debug, Clone)]
pub struct Examined {
    /// The answer, or why there is none.
    pub answer: Result<Answer, String>,
    /// How long it took (s).
    pub seconds: f64,
}

/// The program that diagnoses, and when to give it up.
#[derive(Debug, Clone)]
pub struct Examiner<'a> {
    /// The program; called as `slipstream` is.
    pub program: &'a Path,
    /// Longest time for one case.
    pub limit: Duration,
    /// Set when somebody interrupts.
    pub stop: &'a AtomicBool,
}

impl Examiner<'_> {
    /// Diagnoses one case.
    ///
    /// The process works in a new folder that holds a copy of the recording and of the model under
    /// names that say nothing.
    ///
    /// # Errors
    /// A case that cannot be copied, a program that does not start, an interruption.
    pub fn diagnose(&self, case: &Case<'_>) -> Result<Examined, TrialError> {
        let room = tempfile::tempdir().map_err(TrialError::system("a temporary folder"))?;
        copy_folder(case.recording, &room.path().join("recording"))?;
        copy_file(case.model, &room.path().join("robot.toml"))?;
        let words = room.path().join("words.txt");
        let file = File::create(&words).map_err(TrialError::system(words.display()))?;
        let mut command = Command::new(self.program);
        command
            .current_dir(room.path())
            .args([
                "diagnose",
                "recording",
                "--robot",
                "robot.toml",
                "--json",
                "answer.json",
            ])
            .args(
                case.without
                    .iter()
                    .flat_map(|effect| ["--without", effect.as_str()]),
            )
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(file);
        let begin = Instant::now();
        let child = command
            .spawn()
            .map_err(TrialError::system(self.program.display()))?;
        let ended = self.wait(child, begin)?;
        let seconds = begin.elapsed().as_secs_f64();
        let answer = match ended {
            None => Err(format!("no answer in {:.0} s", self.limit.as_secs_f64())),
            Some(status) if status.success() => read_answer(&room.path().join("answer.json")),
            Some(status) => Err(last_words(&words, status)),
        };
        Ok(Examined { answer, seconds })
    }

    /// Waits for the end; `None` when time was up.
    fn wait(&self, mut child: Child, begin: Instant) -> Result<Option<ExitStatus>, TrialError> {
        loop {
            let ended = child
                .try_wait()
                .map_err(TrialError::system("waiting for diagnose"))?;
            let interrupted = self.stop.load(Ordering::Relaxed);
            if ended.is_some() && !interrupted {
                return Ok(ended);
            }
            if interrupted || begin.elapsed() > self.limit {
                // one that has just ended cannot be killed, and need not be
                let _ = child.kill();
                let _ = child.wait();
                return if interrupted {
                    Err(TrialError::Interrupted)
                } else {
                    Ok(None)
                };
            }
            std::thread::sleep(LOOK);
        }
    }
}

fn read_answer(path: &Path) -> Result<Answer, String> {
    let text = std::fs::read_to_string(path).map_err(|error| format!("no answer: {error}"))?;
    answer::parse(&text).map_err(|why| format!("no answer in the contract's form: {why}"))
}

fn last_words(path: &PathBuf, status: ExitStatus) -> String {
    let words = std::fs::read(path).unwrap_or_default();
    let words = String::from_utf8_lossy(&words).into_owned();
    let last = words.lines().rfind(|line| !line.trim().is_empty());
    format!("{status}: {}", last.unwrap_or("without a word"))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), TrialError> {
    std::fs::create_dir(to).map_err(TrialError::system(to.display()))?;
    let entries = std::fs::read_dir(from).map_err(|error| no_case(from, &error))?;
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
    copied.map(|_| ()).map_err(|error| no_case(from, &error))
}

fn no_case(path: &Path, error: &std::io::Error) -> TrialError {
    let remedy = "labels stand beside the folders and models that they name";
    TrialError::unusable(path.display(), error.to_string(), remedy)
}
