//! Recordings of the command line, with the maps that say what those of other programs contain.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;
use slipstream_recording::{Import, Map, Spooled, StreamKind, TopicMap};

use crate::exit::Error;
use crate::models::Models;
use crate::print::{note_line, prints};

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

/// How much is said of what was guessed about a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guesses {
    /// Everything.
    Whole,
    /// One line, and for recordings of one kind once; with --verbose everything.
    Brief,
}

impl Reading {
    /// Reads a recording whose rows stay on disk; what was guessed and what is odd is said, and what about its model, unless
    /// `models` has others: the joints that they name help the guess of a bag's topics.
    pub(crate) fn spool(
        &self,
        path: &Path,
        models: &Models,
        guesses: Guesses,
    ) -> Result<Spooled, Error> {
        let map = Map::read(self.topics.as_deref(), self.columns.as_deref())?;
        let spooled = slipstream_recording::read_spooled(path, &map, &models.wheel_joints())?;
        let is_whole = guesses == Guesses::Whole || prints().details;
        if is_whole {
            for guess in &spooled.guesses {
                note_line!("{guess}");
            }
        } else if let Some(guess) = spooled.guesses.first() {
            note_once(path, guess);
        }
        for warning in &spooled.warnings {
            note_line!("{warning}");
        }
        if models.is_empty() {
            note_model(path, &spooled.on_model, is_whole);
        }
        models.note_poses(spooled.robots());
        Ok(spooled)
    }

    /// The map of topics, if one was given.
    pub(crate) fn topics(&self) -> Result<Option<TopicMap>, Error> {
        match Map::read(self.topics.as_deref(), None)? {
            Map::Topics(map) => Ok(Some(map)),
            Map::Columns(_) | Map::None => Ok(None),
        }
    }

    /// Reads a recording into memory, as [`Self::spool`].
    pub(crate) fn read(&self, path: &Path, models: &Models) -> Result<Import, Error> {
        Ok(self.spool(path, models, Guesses::Brief)?.load()?)
    }
}

/// Prints what was taken of the model that came with a recording: all notes, or how many there are.
fn note_model(path: &Path, notes: &[String], is_whole: bool) {
    match notes {
        [first, others @ ..] if !others.is_empty() && !is_whole => {
            let (count, path) = (others.len(), path.display());
            note_line!("{first}; notes: {count}, told by `slipstream robot {path}`");
        }
        notes => {
            for note in notes {
                note_line!("{note}");
            }
        }
    }
}

/// Guesses that were told.
static TOLD: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Prints a guessed map as one line, if no recording before had the same.
fn note_once(path: &Path, guess: &str) {
    let (title, map) = guess.split_once('\n').unwrap_or((guess, ""));
    let is_new = TOLD
        .lock()
        .is_ok_and(|mut told| told.insert(map.to_owned()));
    if is_new {
        let title = title.trim_end_matches(':');
        let (streams, path) = (streams_of(map), path.display());
        note_line!("{title}: {streams}; `slipstream check {path}` says more");
    }
}

/// The streams of a map, and the topic of each: `command /cmd_vel, pose /mocap/pose`.
fn streams_of(map: &str) -> String {
    let streams = map.lines().filter_map(|line| {
        if let Some(table) = line.strip_prefix("[robots.") {
            // In a map of columns, each stream is a table.
            let stream = table.trim_end_matches(']').rsplit_once('.')?.1;
            return StreamKind::from_name(stream).map(|_| stream.to_owned());
        }
        let (stream, source) = line.split_once(" = ")?;
        StreamKind::from_name(stream)?;
        let mut texts = source.split('"').skip(1).step_by(2);
        let topic = texts.find(|text| text.starts_with('/'));
        Some(topic.map_or(stream.to_owned(), |topic| format!("{stream} {topic}")))
    });
    streams.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guess_is_one_line() {
        let topics = "format = 1\nstamps = \"message\"\n[robots.\"r.1\"]\ncommand = \"/cmd_vel\"\nwheels = { right = { topic = \
                      \"/r\", field = \"data\" }, left = { topic = \"/l\", field = \"data\" }, quantity = \"ticks\" }\n";
        assert_eq!(streams_of(topics), "command /cmd_vel, wheels /r");
        let columns = "format = 1\n[robots.robot.pose]\nfile = \"a.csv\"\nt_s = 1\n[robots.robot.odometry]\nt_s = 1\n";
        assert_eq!(streams_of(columns), "pose, odometry");
    }
}
