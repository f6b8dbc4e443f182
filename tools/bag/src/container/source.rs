//! Bags by their container, recognised by its first bytes: MCAP, SQLite, ROS 1, WPILib; each also compressed as a whole.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;

use super::chunk::MAX_CHUNK_BYTES;
use super::file::open_file;
use super::item::{Item, Undecodable, Visit, VisitResult, Wanted};
use super::loss::Loss;
use super::summary::Summary;
use super::{mcap as mcap_file, ros1, sqlite, wpilog};
use crate::output::temporary_file;
use crate::text_file::refuse_pointer;

/// A bag that can be read from its beginning as often as needed.
pub trait Bag {
    /// Reads the whole bag and calls `visit` with each item; of topics that are not wanted, messages are only counted.
    /// Returns what could not be read.
    ///
    /// # Errors
    /// If it is not a bag, or the operating system does not read it.
    fn scan(&self, wanted: &Wanted<'_>, visit: &mut Visit<'_>) -> Result<Loss, InputError>;
}

/// What holds the messages of a bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Container {
    /// MCAP.
    Mcap,
    /// An SQLite database.
    Sqlite,
    /// A ROS 1 bag.
    Ros1,
    /// A WPILib data log.
    Wpilog,
}

/// First bytes of what Zstandard compressed.
const ZSTD_MAGIC: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];
/// So many bytes tell the container.
const HEAD_BYTES: u64 = 64;

impl Container {
    /// The container of a file that begins with these bytes. What is none of the others is taken for MCAP, whose
    /// reader says what is wrong.
    fn of(head: &[u8]) -> Self {
        if head.starts_with(sqlite::MAGIC) {
            Self::Sqlite
        } else if head.starts_with(b"#ROSBAG") {
            Self::Ros1
        } else if head.starts_with(wpilog::MAGIC) {
            Self::Wpilog
        } else {
            Self::Mcap
        }
    }
}

/// Whether a file begins like a bag.
///
/// # Errors
/// If the operating system does not read it.
pub fn is_bag(path: &Path) -> Result<bool, InputError> {
    let (file, _) = open_file(path)?;
    let head = head(file).map_err(|e| InputError::unreadable(path, &e))?;
    let magics = [mcap::MAGIC, ZSTD_MAGIC];
    let begins = magics.iter().any(|magic| head.starts_with(magic));
    Ok(begins || Container::of(&head) != Container::Mcap)
}

/// A file with a bag.
#[derive(Debug)]
pub struct BagFile {
    path: PathBuf,
    /// What the file holds, once it is decompressed.
    pub container: Container,
    /// Whether the file as a whole is compressed (Zstandard).
    is_compressed: bool,
}

impl BagFile {
    /// Recognises a file by its first bytes.
    ///
    /// # Errors
    /// If the operating system does not read it, or it is a pointer of Git LFS.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        let (file, _) = open_file(path)?;
        let head = head(file).map_err(|e| InputError::unreadable(path, &e))?;
        refuse_pointer(&head, path)?;
        let mut bag = Self {
            path: path.to_owned(),
            container: Container::of(&head),
            is_compressed: head.starts_with(ZSTD_MAGIC),
        };
        if bag.is_compressed {
            let (source, _) = bag.source()?;
            // A damaged file is found by the reader of its container.
            bag.container = Container::of(&self::head(source).unwrap_or_default());
        }
        Ok(bag)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The decompressed bytes of the file, and how many there are: at least so many, if it is compressed.
    pub fn source(&self) -> Result<(Box<dyn Read>, u64), InputError> {
        let (file, size) = open_file(&self.path)?;
        if !self.is_compressed {
            return Ok((Box::new(file), size));
        }
        let decoder = zstd::Decoder::with_buffer(file);
        let decoder = decoder.map_err(|e| InputError::unreadable(&self.path, &e))?;
        Ok((Box::new(UntilDamage(decoder)), size))
    }

    /// The index of an MCAP file; `None` if it has none.
    pub fn summary(&self) -> Option<Summary> {
        let (mut file, _) = open_file(&self.path).ok()?;
        (self.container == Container::Mcap && !self.is_compressed)
            .then(|| Summary::read(&mut file))
            .flatten()
    }

    fn scan_database(
        &self,
        wanted: &Wanted<'_>,
        visit: &mut Visit<'_>,
    ) -> Result<Loss, InputError> {
        if !self.is_compressed {
            return sqlite::read_database(&sqlite::open(&self.path)?, &self.path, wanted, visit);
        }
        let unreadable = |e: std::io::Error| InputError::unreadable(&self.path, &e);
        let (mut whole, name) = temporary_file().map_err(unreadable)?;
        std::io::copy(&mut self.source()?.0, &mut whole).map_err(unreadable)?;
        let database = sqlite::open(name.path())?;
        // The open database needs no name any more.
        drop(name);
        sqlite::read_database(&database, &self.path, wanted, visit)
    }
}

impl Bag for BagFile {
    fn scan(&self, wanted: &Wanted<'_>, visit: &mut Visit<'_>) -> Result<Loss, InputError> {
        if self.container == Container::Sqlite {
            return self.scan_database(wanted, &mut unpacked(visit));
        }
        if self.container == Container::Mcap && !self.is_compressed {
            return mcap_file::read_file(&self.path, wanted, &mut unpacked(visit));
        }
        let (mut source, size) = self.source()?;
        let visit = &mut unpacked(visit);
        match self.container {
            Container::Ros1 => ros1::read_ros1(&mut source, size, &self.path, wanted, visit),
            Container::Wpilog => wpilog::read_wpilog(&mut source, size, &self.path, wanted, visit),
            _ => mcap_file::read_wanted(source, size, &self.path, wanted, visit),
        }
    }
}

/// A bag in memory; `path` is used in errors only.
#[derive(Debug)]
pub struct BagBytes<'a> {
    /// All bytes.
    pub content: &'a [u8],
    /// What errors call it.
    pub path: &'a Path,
}

impl BagBytes<'_> {
    /// What the bytes hold.
    pub fn container(&self) -> Container {
        Container::of(self.content)
    }
}

impl Bag for BagBytes<'_> {
    fn scan(&self, wanted: &Wanted<'_>, visit: &mut Visit<'_>) -> Result<Loss, InputError> {
        let Self { mut content, path } = *self;
        let size = content.len() as u64;
        let visit = &mut unpacked(visit);
        match self.container() {
            Container::Mcap => mcap_file::read_wanted(content, size, path, wanted, visit),
            Container::Ros1 => ros1::read_ros1(&mut content, size, path, wanted, visit),
            Container::Wpilog => wpilog::read_wpilog(&mut content, size, path, wanted, visit),
            Container::Sqlite => {
                sqlite::read_database(&sqlite::from_bytes(content, path)?, path, wanted, visit)
            }
        }
    }
}

/// Reads an MCAP file whose `source` waits for what is not written yet.
///
/// # Errors
/// If it is not an MCAP file, or reading fails.
pub fn read_growing(
    source: impl Read,
    path: &Path,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    // However long a record may be: its end will come.
    mcap_file::read_wanted(source, u64::MAX, path, &|_| true, &mut unpacked(visit))
}

/// The first bytes of a source.
fn head(source: impl Read) -> std::io::Result<Vec<u8>> {
    let mut head = Vec::new();
    source.take(HEAD_BYTES).read_to_end(&mut head)?;
    Ok(head)
}

/// A source that ends where its compression is damaged.
struct UntilDamage(zstd::Decoder<'static, BufReader<File>>);

impl Read for UntilDamage {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        Ok(self.0.read(bytes).unwrap_or(0))
    }
}

/// Passes items on, with messages that are compressed one by one (a mode of rosbag2) decompressed. A message in CDR does
/// not begin like a compressed one.
fn unpacked<'a>(visit: &'a mut Visit<'_>) -> impl FnMut(Item<'_>) -> VisitResult + 'a {
    let mut whole = Vec::new();
    move |item| {
        let Item::Message {
            id,
            channel,
            log_time_ns,
            data,
        } = item
        else {
            return visit(item);
        };
        if channel.encoding != "cdr" || !data.starts_with(ZSTD_MAGIC) {
            return visit(item);
        }
        whole.clear();
        let decoder = zstd::Decoder::new(data).map_err(|_| Undecodable)?;
        let read = decoder.take(MAX_CHUNK_BYTES).read_to_end(&mut whole);
        read.map_err(|_| Undecodable)?;
        visit(Item::Message {
            id,
            channel,
            log_time_ns,
            data: &whole,
        })
    }
}
