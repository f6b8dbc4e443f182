//! A trial's folder: recordings and models for everyone, commitments before, labels after.
//!
//! ```text
//! FOLDER/commitments.txt      one line a case: SHA-256 of nonce, line feed and label
//! FOLDER/case-0001/           a recording
//! FOLDER/robots/case-0001.toml
//! FOLDER/sealed/case-0001.txt the nonce, then the label: written when the seals are opened
//! FOLDER/labels.toml          all labels: likewise
//! ```

use std::path::{Path, PathBuf};

use slipstream_recording::{robot_toml, write_folder};

use crate::TrialError;
use crate::hold::Question;
use crate::label::{self, Label, Labels};
use crate::maker::{Made, Plan, Planned};
use crate::parallel::each;
use crate::seal::Sealed;

/// A trial whose recordings are made and whose labels are sealed.
#[derive(Debug)]
pub struct Trial {
    folder: PathBuf,
    cases: Vec<Case>,
}

#[derive(Debug)]
struct Case {
    name: String,
    sealed: Sealed,
    commitment: String,
    without: Vec<String>,
}

impl Trial {
    /// Makes all cases of a plan into a folder that must not exist or be empty; it appears whole or
    /// not at all. `done` hears of each case and may end it all.
    ///
    /// # Errors
    /// A folder that is not empty, a file that cannot be written, an interruption.
    pub fn make(
        plan: &Plan,
        folder: &Path,
        mut done: impl FnMut() -> Result<(), TrialError>,
    ) -> Result<Self, TrialError> {
        empty(folder)?;
        let parent = folder
            .parent()
            .filter(|parent| *parent != Path::new(""))
            .unwrap_or(Path::new("."));
        std::fs::create_dir_all(parent).map_err(TrialError::system(parent.display()))?;
        let making = tempfile::tempdir_in(parent).map_err(TrialError::system(parent.display()))?;
        let robots = making.path().join("robots");
        std::fs::create_dir(&robots).map_err(TrialError::system(robots.display()))?;
        let mut cases = Vec::new();
        let planned: Vec<Planned> = plan.cases().collect();
        each(&planned, Planned::make, |planned, made| {
            let fault =
                |why| TrialError::unusable(&planned.name, why, "the maker is at fault: report it");
            let made = made.map_err(fault)?;
            write(&made, making.path(), &planned.name)?;
            let sealed = Sealed {
                nonce: planned.nonce.clone(),
                text: text(&planned.name, &made.label)?,
            };
            cases.push(Case {
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
        if folder.exists() {
            std::fs::remove_dir(folder).map_err(TrialError::system(folder.display()))?;
        }
        std::fs::rename(making.keep(), folder).map_err(TrialError::system(folder.display()))?;
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

    /// Opens the seals: writes nonces and labels, reads them back, checks every commitment.
    ///
    /// # Errors
    /// A file that cannot be written, a label that is not the one that was committed to.
    pub fn open(&self) -> Result<Labels, TrialError> {
        let sealed = self.folder.join("sealed");
        std::fs::create_dir_all(&sealed).map_err(TrialError::system(sealed.display()))?;
        let published = self.folder.join("commitments.txt");
        let commitments =
            std::fs::read_to_string(&published).map_err(TrialError::system(published.display()))?;
        let mut labels = Labels::new();
        for (Case { name, sealed, .. }, line) in self.cases.iter().zip(commitments.lines()) {
            put(
                &self.folder.join("sealed").join(format!("{name}.txt")),
                &format!("{}\n{}", sealed.nonce, sealed.text),
            )?;
            if line != format!("{}  {name}", sealed.commitment()) {
                return Err(TrialError::unusable(
                    published.display(),
                    format!("the commitment of {name} is not that of its label"),
                    "the trial is void: hold it anew",
                ));
            }
            let own: Labels = toml::from_str(&sealed.text).map_err(|error| {
                TrialError::unusable(
                    name,
                    error.message(),
                    "this is a fault of the maker: report it",
                )
            })?;
            labels.extend(own);
        }
        let file = self.folder.join("labels.toml");
        let text = label::to_text(&labels).map_err(|error| {
            TrialError::unusable(file.display(), error.to_string(), "report it")
        })?;
        put(&file, &text)?;
        Ok(labels)
    }

    /// What the diagnosis is asked, `without` taken out of every catalogue.
    pub fn questions(&self, without: &[String]) -> Vec<Question> {
        let question = |case: &Case| Question {
            name: case.name.clone(),
            model: format!("robots/{}.toml", case.name),
            without: [without, case.without.as_slice()].concat(),
        };
        self.cases.iter().map(question).collect()
    }
}

fn empty(folder: &Path) -> Result<(), TrialError> {
    let full = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if full {
        let remedy = "name a new one";
        return Err(TrialError::unusable(
            folder.display(),
            "the folder is not empty",
            remedy,
        ));
    }
    Ok(())
}

fn write(made: &Made, folder: &Path, name: &str) -> Result<(), TrialError> {
    let place = folder.join(name);
    let failed = |error: slipstream_recording::Error| {
        TrialError::unusable(
            place.display(),
            error.to_string(),
            "check the place and its space",
        )
    };
    write_folder(&made.recording, &place).map_err(failed)?;
    let model = folder.join("robots").join(format!("{name}.toml"));
    robot_toml::write(&made.model, &model).map_err(failed)
}

fn text(name: &str, label: &Label) -> Result<String, TrialError> {
    let one = Labels::from([(name.to_owned(), label.clone())]);
    label::to_text(&one).map_err(|error| TrialError::unusable(name, error.to_string(), "report it"))
}

fn put(path: &Path, text: &str) -> Result<(), TrialError> {
    std::fs::write(path, text).map_err(TrialError::system(path.display()))
}
