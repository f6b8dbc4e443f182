//! The folder of a sealed trial: recordings, models and commitments first, labels after the diagnosis.
//!
//! ```text
//! FOLDER/commitments.txt       one line per case: SHA-256 of nonce, line feed and label
//! FOLDER/case-0001/            a recording
//! FOLDER/robots/case-0001.toml its nominal model
//! FOLDER/sealed/case-0001.txt  nonce and label, written when the labels are revealed
//! FOLDER/labels.toml           all labels, written when they are revealed
//! ```

use std::path::{Path, PathBuf};

use slipstream_bag::output::OutputFolder;
use slipstream_recording::{robot_toml, write_folder};

use crate::TrialError;
use crate::in_order::for_each_in_order;
use crate::label::{self, Label, Labels};
use crate::maker::{MadeCase, PlannedCase};
use crate::protocol::Question;
use crate::seal::Sealed;

/// A trial with its recordings made and its labels sealed.
#[derive(Debug)]
pub struct SealedTrial {
    folder: PathBuf,
    cases: Vec<SealedCase>,
}

#[derive(Debug)]
struct SealedCase {
    name: String,
    sealed: Sealed,
    commitment: String,
    without: Vec<String>,
}

impl SealedTrial {
    /// Makes cases of a plan in a new or empty folder, which appears complete or not at all. `done` is
    /// called after each case and can end the work.
    ///
    /// # Errors
    /// A folder that is not empty, a file that cannot be written, an interruption.
    pub fn make(
        planned: &[PlannedCase],
        folder: &Path,
        mut done: impl FnMut() -> Result<(), TrialError> + Send,
    ) -> Result<Self, TrialError> {
        let making = OutputFolder::create(folder)?;
        let robots = making.path().join("robots");
        std::fs::create_dir(&robots).map_err(TrialError::system(robots.display()))?;
        let mut cases = Vec::new();
        for_each_in_order(planned, PlannedCase::make, |planned, made| {
            let fault = |why| {
                TrialError::input(
                    &planned.name,
                    why,
                    "this is an error of the program: please report it",
                )
            };
            let made = made.map_err(fault)?;
            write(&made, making.path(), &planned.name)?;
            let sealed = Sealed {
                nonce: planned.nonce.clone(),
                text: text(&planned.name, &made.label)?,
            };
            cases.push(SealedCase {
                name: planned.name.clone(),
                commitment: sealed.commitment(),
                sealed,
                without: made.label.without,
            });
            done()
        })?;
        let lines = cases
            .iter()
            .map(|case| format!("{}  {}\n", case.commitment, case.name));
        put(
            &making.path().join("commitments.txt"),
            &lines.collect::<String>(),
        )?;
        making.finish()?;
        Ok(Self {
            folder: folder.to_owned(),
            cases,
        })
    }

    /// The commitments, in the order of the cases.
    pub fn commitments(&self) -> Vec<String> {
        self.cases
            .iter()
            .map(|case| case.commitment.clone())
            .collect()
    }

    /// Reveals the labels: writes nonces and labels and checks them against the published commitments.
    ///
    /// # Errors
    /// A file that cannot be written, a label that does not match its commitment.
    pub fn open(&self) -> Result<Labels, TrialError> {
        let sealed = self.folder.join("sealed");
        std::fs::create_dir_all(&sealed).map_err(TrialError::system(sealed.display()))?;
        let published = self.folder.join("commitments.txt");
        let commitments =
            std::fs::read_to_string(&published).map_err(TrialError::system(published.display()))?;
        let mut labels = Labels::new();
        for (SealedCase { name, sealed, .. }, line) in self.cases.iter().zip(commitments.lines()) {
            put(
                &self.folder.join("sealed").join(format!("{name}.txt")),
                &format!("{}\n{}", sealed.nonce, sealed.text),
            )?;
            if line != format!("{}  {name}", sealed.commitment()) {
                return Err(TrialError::input(
                    published.display(),
                    format!("the commitment of {name} does not match its label"),
                    "the trial is invalid: repeat it",
                ));
            }
            let own: Labels = toml::from_str(&sealed.text).map_err(|error| {
                TrialError::input(
                    name,
                    error.message(),
                    "this is an error of the program: please report it",
                )
            })?;
            labels.extend(own);
        }
        let file = self.folder.join("labels.toml");
        let text = label::to_text(&labels).map_err(|error| {
            TrialError::input(file.display(), error.to_string(), "please report it")
        })?;
        put(&file, &text)?;
        Ok(labels)
    }

    /// The questions to the diagnosis, with the effects `without` removed from every catalogue.
    pub fn questions(&self, without: &[String]) -> Vec<Question> {
        let question = |case: &SealedCase| Question {
            name: case.name.clone(),
            model: format!("robots/{}.toml", case.name),
            without: [without, case.without.as_slice()].concat(),
        };
        self.cases.iter().map(question).collect()
    }
}

fn write(made: &MadeCase, folder: &Path, name: &str) -> Result<(), TrialError> {
    let place = folder.join(name);
    write_folder(&made.recording, &place)?;
    let model = folder.join("robots").join(format!("{name}.toml"));
    Ok(robot_toml::write(&made.model, &model)?)
}

fn text(name: &str, label: &Label) -> Result<String, TrialError> {
    let one = Labels::from([(name.to_owned(), label.clone())]);
    label::to_text(&one).map_err(|error| TrialError::input(name, error.to_string(), "report it"))
}

fn put(path: &Path, text: &str) -> Result<(), TrialError> {
    std::fs::write(path, text).map_err(TrialError::system(path.display()))
}
