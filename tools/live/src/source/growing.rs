//! An MCAP file that is still being recorded, or a folder of them as rosbag2 writes it.

use std::cell::RefCell;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use slipstream_bus::InputError;
use slipstream_recording::{Follower, TopicMap, WheelJoints, next_part};

use super::background::{Background, Outlet};
use super::heard::{Heard, Source};
use super::waiting::{MAGIC, Over, Waiting};

/// How often what was read is passed on while a file does not grow.
const PASSING_ON: Duration = Duration::from_millis(500);
/// How often it is looked for the next file of a folder.
const LOOKING: Duration = Duration::from_millis(100);
/// So long after a complete file the next one of a folder may begin.
const NEXT_WITHIN: Duration = Duration::from_secs(30);
/// What a recorder writes into a folder once it ends.
const DESCRIPTION: &str = "metadata.yaml";

/// A bag that grows.
pub struct Growing {
    name: String,
    background: Background,
}

impl Growing {
    /// Whether a path is an MCAP file without an end, or a folder of a recorder that goes on.
    pub fn grows(path: &Path) -> bool {
        if path.is_dir() {
            let has_parts = next_part(path, None).is_ok_and(|own| own.is_some());
            return has_parts && !path.join(DESCRIPTION).exists();
        }
        begins_like_mcap(path).is_ok() && !ends_like_mcap(path)
    }

    /// Reads an MCAP file, or the folder of a recorder with such files, from its beginning, and goes on as it grows. `map` says
    /// which topic is which stream; without one it is guessed from the first seconds. `wheels` are the joints of wheels that
    /// descriptions of the robots name.
    ///
    /// # Errors
    /// If it is neither.
    pub fn open(
        path: &Path,
        map: Option<TopicMap>,
        wheels: Vec<WheelJoints>,
    ) -> Result<Self, InputError> {
        let (folder, first) = if path.is_dir() {
            let first = next_part(path, None)?.ok_or_else(|| {
                let problem = "contains no MCAP file";
                let remedy = "start the recorder first: ros2 bag record -s mcap";
                InputError::file(path, problem, remedy)
            })?;
            (Some(path.to_owned()), first)
        } else {
            (None, path.to_owned())
        };
        begins_like_mcap(&first)?;
        let name = path.display().to_string();
        let whole = path.to_owned();
        let background = Background::start(&name, move |outlet| {
            let sink = |followed| outlet.followed(followed);
            let follower = RefCell::new(Follower::new(&whole, map, wheels, sink));
            let bag = BagFiles {
                folder,
                outlet,
                follower: &follower,
            };
            match bag.follow(first) {
                Ok(()) => follower.borrow_mut().finish(),
                Err(error) => outlet.fail(error),
            }
        })?;
        Ok(Self { name, background })
    }
}

impl Source for Growing {
    fn name(&self) -> &str {
        &self.name
    }

    fn hear(&mut self, wait: Duration) -> Result<Heard, InputError> {
        self.background.hear(wait)
    }
}

/// Refuses what cannot become an MCAP file.
fn begins_like_mcap(path: &Path) -> Result<(), InputError> {
    let unreadable = |error: std::io::Error| InputError::unreadable(path, &error);
    let mut head = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    let mut begin = file.take(MAGIC.len() as u64);
    begin.read_to_end(&mut head).map_err(unreadable)?;
    if MAGIC.starts_with(&head) {
        return Ok(());
    }
    let problem = "is not an MCAP file, and no other can be read as it grows";
    let remedy = "record MCAP (ros2 bag record -s mcap), or wait until the recording is complete";
    Err(InputError::file(path, problem, remedy))
}

/// Whether a file is a complete MCAP file.
fn ends_like_mcap(path: &Path) -> bool {
    let end = |file: &mut File| -> std::io::Result<Vec<u8>> {
        let mut tail = Vec::new();
        file.seek(SeekFrom::End(-(MAGIC.len() as i64)))?;
        file.read_to_end(&mut tail)?;
        Ok(tail)
    };
    let whole = File::open(path).and_then(|mut file| {
        let length = file.metadata()?.len();
        Ok((length, end(&mut file)?))
    });
    whole.is_ok_and(|(length, tail)| length > MAGIC.len() as u64 && tail == MAGIC)
}

/// The files of a bag.
struct BagFiles<'a, 'b> {
    /// Where the next file is, if there may be one.
    folder: Option<PathBuf>,
    outlet: &'a Outlet,
    follower: &'a RefCell<Follower<'b>>,
}

impl BagFiles<'_, '_> {
    /// Reads one file after the other.
    fn follow(&self, first: PathBuf) -> Result<(), InputError> {
        let mut next = Some(first);
        while let Some(part) = next {
            let over = self.read(&part)?;
            next = match over {
                _ if self.is_over() => None,
                Over::BegunAnew => {
                    let name = part.display();
                    self.outlet
                        .say(&format!("{name}: begun anew; read from its beginning"));
                    Some(part)
                }
                _ => self.after(&part)?,
            };
        }
        Ok(())
    }

    fn is_over(&self) -> bool {
        self.outlet.is_closed() || self.follower.borrow().has_failed()
    }

    /// Reads a file to its end, which may not be written yet.
    fn read(&self, part: &Path) -> Result<Over, InputError> {
        let file = File::open(part).map_err(|error| InputError::unreadable(part, &error))?;
        let mut over = Over::No;
        let mut passed_on = Instant::now();
        let mut idle = || {
            if passed_on.elapsed() >= PASSING_ON {
                self.follower.borrow_mut().idle();
                passed_on = Instant::now();
            }
            let next = self.next(part);
            self.follower.borrow().has_failed() || next.is_ok_and(|next| next.is_some())
        };
        let waiting = Waiting::new(file, self.outlet, &mut idle, &mut over);
        let loss = Follower::read(self.follower, BufReader::new(waiting), part)?;
        if loss.any() && !self.is_over() && over != Over::BegunAnew {
            self.outlet.say(&format!("{}: {loss}", part.display()));
        }
        Ok(over)
    }

    /// The file after a complete one, once it is there; none where there will be no other.
    fn after(&self, part: &Path) -> Result<Option<PathBuf>, InputError> {
        let began = Instant::now();
        while let Some(folder) = &self.folder
            && !self.is_over()
        {
            // Looked for before the file, so that none can begin in between.
            let is_complete = folder.join(DESCRIPTION).exists();
            let next = self.next(part)?;
            if next.is_some() || is_complete || began.elapsed() > NEXT_WITHIN {
                return Ok(next);
            }
            self.follower.borrow_mut().idle();
            self.outlet.wait(LOOKING);
        }
        Ok(None)
    }

    fn next(&self, part: &Path) -> Result<Option<PathBuf>, InputError> {
        let folder = self.folder.as_ref();
        folder.map_or(Ok(None), |folder| next_part(folder, Some(part)))
    }
}
