//! Reader of ROS 2 bags in SQLite databases, the storage of rosbag2 up to ROS 2 Humble.
//!
//! A database from a stranger is opened read-only, without functions that its schema could call and with a limit on the
//! size of a cell. A damaged one is read as far as its pages allow: where rows cannot be read, reading goes on after them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};
use slipstream_bus::InputError;

use super::chunk::MAX_CHUNK_BYTES;
use super::item::{ChannelInfo, Item, Undecodable, Visit, Wanted};
use super::loss::Loss;

/// First bytes of every database.
pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";

/// Opens a database file.
///
/// # Errors
/// If the operating system or SQLite does not open it.
pub(super) fn open(path: &Path) -> Result<Connection, InputError> {
    // Without "immutable", SQLite would put files beside the database. With a write-ahead log, which a recorder that
    // was killed leaves behind, it has to.
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    let has_log = std::fs::metadata(log).is_ok_and(|log| log.len() > 0);
    let name = path.to_string_lossy().replace('%', "%25");
    let name = name.replace('?', "%3f").replace('#', "%23");
    let mode = if has_log { "mode=ro" } else { "immutable=1" };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
    let opened = Connection::open_with_flags(format!("file:{name}?{mode}"), flags);
    opened.map_err(|error| unusable(path, &error))
}

/// A database in memory, from the content of its file.
///
/// # Errors
/// If SQLite does not accept it.
pub(super) fn from_bytes(content: &[u8], path: &Path) -> Result<Connection, InputError> {
    let open = || {
        let mut database = Connection::open_in_memory()?;
        database.deserialize_read_exact("main", content, content.len(), true)?;
        Ok(database)
    };
    open().map_err(|error| unusable(path, &error))
}

/// Reads all messages and calls `visit` with each item; of topics that are not wanted, rows are only counted. `path` is used in errors only.
///
/// # Errors
/// If the database is not a ROS 2 bag. Damage is not an error but a [`Loss`].
pub(super) fn read_database(
    database: &Connection,
    path: &Path,
    wanted: &Wanted<'_>,
    visit: &mut Visit<'_>,
) -> Result<Loss, InputError> {
    let unusable = |error: rusqlite::Error| unusable(path, &error);
    restrict(database).map_err(unusable)?;
    let tables = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages') \
                  AND sql NOT LIKE '%virtual%'";
    let tables: u32 = database
        .query_row(tables, [], |row| row.get(0))
        .map_err(unusable)?;
    if tables != 2 {
        let problem = "is an SQLite database without the tables of a ROS 2 bag";
        return Err(InputError::file(
            path,
            problem,
            "give the database that rosbag2 wrote",
        ));
    }
    let topics = topics(database, wanted).map_err(unusable)?;
    for (&id, (channel, _)) in &topics {
        // Whoever does not want a topic says so of its messages.
        let _ = visit(Item::Channel { id, channel });
    }
    let query = query(&topics);
    let mut loss = Loss::default();
    let mut last = i64::MIN;
    while !matches!(
        messages_after(database, &query, &mut last, &topics, visit, &mut loss),
        Ok(RowsEnd::Complete)
    ) {
        let Some(next) = first_readable_after(database, last) else {
            loss.truncated = true;
            break;
        };
        loss.damaged_chunks += 1;
        loss.messages_in_damaged_chunks += next.abs_diff(last.max(0)).saturating_sub(1);
        last = next - 1;
    }
    Ok(loss)
}

fn unusable(path: &Path, error: &rusqlite::Error) -> InputError {
    let remedy = "give a complete file that rosbag2 wrote";
    let error = error.to_string().replace('\n', " ");
    InputError::file(
        path,
        format!("SQLite cannot read the database: {error}"),
        remedy,
    )
}

/// Forbids what a bag does not need, and lets a database be read that is shorter than its header says.
fn restrict(database: &Connection) -> rusqlite::Result<()> {
    let bytes = i32::try_from(MAX_CHUNK_BYTES).unwrap_or(i32::MAX);
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, bytes)?;
    database.execute_batch(
        "PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON; PRAGMA writable_schema = ON;",
    )
}

/// The topics by their number, and whether their messages are wanted.
type WantedTopics = BTreeMap<u32, (Arc<ChannelInfo>, bool)>;

/// Encoding and bytes of a definition, by the name of its type.
type Definitions = BTreeMap<String, Arc<(String, Vec<u8>)>>;

/// The topics of a database.
fn topics(database: &Connection, wanted: &Wanted<'_>) -> rusqlite::Result<WantedTopics> {
    let definitions = definitions(database).unwrap_or_default();
    let mut statement =
        database.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let rows = statement.query_map([], |row| {
        let schema: String = row.get(2)?;
        let definition = definitions.get(&schema).cloned();
        let channel = ChannelInfo {
            topic: row.get(1)?,
            schema,
            encoding: row.get(3)?,
            definition: definition.unwrap_or_default(),
            metadata: BTreeMap::new(),
        };
        let is_wanted = wanted(&channel);
        Ok((row.get(0)?, (Arc::new(channel), is_wanted)))
    })?;
    rows.collect()
}

/// Encoding and bytes of the definitions of types by their names, which rosbag2 writes since ROS 2 Iron.
fn definitions(database: &Connection) -> rusqlite::Result<Definitions> {
    let query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions LIMIT 10000";
    let mut statement = database.prepare(query)?;
    let rows = statement.query_map([], |row| {
        let text: String = row.get(2)?;
        Ok((row.get(0)?, Arc::new((row.get(1)?, text.into_bytes()))))
    })?;
    rows.collect()
}

/// The query for all rows after one. The data of unwanted topics, which may be long, stay on the disk.
fn query(topics: &WantedTopics) -> String {
    let unwanted = topics.iter().filter(|(_, (_, is_wanted))| !is_wanted);
    let unwanted: Vec<String> = unwanted.map(|(id, _)| id.to_string()).collect();
    let unwanted = unwanted.join(", ");
    format!(
        "SELECT rowid, topic_id, timestamp, CASE WHEN topic_id IN ({unwanted}) THEN 0 ELSE data END FROM messages \
         WHERE rowid > ? ORDER BY rowid"
    )
}

/// How the rows ended.
enum RowsEnd {
    Complete,
    Damaged,
}

/// Visits the messages after row `last`, and keeps in `last` the row that was visited last.
fn messages_after(
    database: &Connection,
    query: &str,
    last: &mut i64,
    topics: &WantedTopics,
    visit: &mut Visit<'_>,
    loss: &mut Loss,
) -> rusqlite::Result<RowsEnd> {
    let mut statement = database.prepare(query)?;
    let mut rows = statement.query([*last])?;
    while let Some(row) = rows.next()? {
        let id = row.get(0)?;
        if id <= *last {
            return Ok(RowsEnd::Damaged);
        }
        *last = id;
        let visited = match (row.get_ref(1)?, row.get_ref(2)?, row.get_ref(3)?) {
            (ValueRef::Integer(topic), ValueRef::Integer(time_ns), ValueRef::Blob(data)) => {
                let id = u32::try_from(topic).map_err(|_| Undecodable);
                let time_ns = u64::try_from(time_ns).map_err(|_| Undecodable);
                id.and_then(|id| {
                    let (channel, _) = topics.get(&id).ok_or(Undecodable)?;
                    visit(Item::Message {
                        id,
                        channel,
                        log_time_ns: time_ns?,
                        data,
                    })
                })
            }
            (ValueRef::Integer(topic), _, ValueRef::Integer(_)) => {
                let channel = u32::try_from(topic).ok().and_then(|id| topics.get(&id));
                let unwanted = channel.filter(|(_, is_wanted)| !is_wanted);
                unwanted.ok_or(Undecodable).and_then(|(channel, _)| {
                    visit(Item::Unwanted {
                        channel,
                        messages: 1,
                    })
                })
            }
            _ => Err(Undecodable),
        };
        match visited {
            Ok(()) => loss.messages_read += 1,
            Err(Undecodable) => loss.undecodable_messages += 1,
        }
    }
    Ok(RowsEnd::Complete)
}

/// The first row after `last` that can be read, where the next one cannot; `None` if there is none.
fn first_readable_after(database: &Connection, last: i64) -> Option<i64> {
    let first_after = |row_before: i64| -> Option<i64> {
        let query =
            "SELECT rowid, length(data) FROM messages WHERE rowid > ? ORDER BY rowid LIMIT 1";
        let row: rusqlite::Result<(i64, i64)> =
            database.query_row(query, [row_before], |row| Ok((row.get(0)?, row.get(1)?)));
        row.ok().map(|(id, _)| id).filter(|id| *id > row_before)
    };
    // Rows are numbered from 1 on. So many are skipped at most.
    const MOST: u32 = 40;
    let base = last.max(0);
    let power = (0..MOST).find(|power| first_after(base + (1 << power)).is_some())?;
    // Between half of it and it lies the end of the damage.
    let (mut unreadable, mut readable) = (base + (1 << power) / 2, base + (1 << power));
    while readable - unreadable > 1 {
        let middle = i64::midpoint(unreadable, readable);
        match first_after(middle) {
            Some(_) => readable = middle,
            None => unreadable = middle,
        }
    }
    first_after(readable).filter(|next| *next > last)
}
