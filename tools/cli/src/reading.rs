//! Recordings of the command line, with the maps that say what those of other programs contain.

use std::path::{Path, PathBuf};

use clap::Args;
use slipstream_recording::{Import, Map, Spooled};

use crate::exit::Error;
use crate::print::note_line;

/// Maps of recordings that other programs wrote.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Reading {
    /// Map from the topics of a bag to streams [default: guessed from types and names; `check --write-topics` writes
    /// the guess]
    #[arg(long, value_name = "FILE.toml", conflicts_with = "columns")]
    topics: Option<PathBuf>,
    /// Map from the columns of text files without recording.toml to streams [default: guessed from names and first
    /// rows; `check --write-columns` writes the guess]
    #[arg(long, value_name = "FILE.toml")]
    columns: Option<PathBuf>,
}

impl Reading {
    /// Reads a recording whose rows stay on disk; what is odd about it is said, and what about its model, unless another
    /// is given.
    pub(crate) fn spool_for(&self, path: &Path, model_is_given: bool) -> Result<Spooled, Error> {
        let map = Map::read(self.topics.as_deref(), self.columns.as_deref())?;
        let spooled = slipstream_recording::read_spooled(path, &map)?;
        for note in spooled.guesses.iter().chain(&spooled.warnings) {
            note_line!("{note}");
        }
        if !model_is_given {
            for note in &spooled.on_model {
                note_line!("{note}");
            }
        }
        Ok(spooled)
    }

    /// As [`Self::spool_for`], without another model.
    pub(crate) fn spool(&self, path: &Path) -> Result<Spooled, Error> {
        self.spool_for(path, false)
    }

    /// Reads a recording into memory; what is odd about it is said.
    pub(crate) fn read(&self, path: &Path) -> Result<Import, Error> {
        Ok(self.spool(path)?.load()?)
    }
}
