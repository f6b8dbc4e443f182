//! Columns that are fields of ROS messages, as `rostopic echo -p`, bagpy, PlotJuggler and others name them:
//! `field.pose.pose.position.x`, `pose.pose.position.x`, `/odom/pose/pose/position/x`.

use super::called::{COMMANDS, REFERENCES};
use super::columns::Columns;
use super::guessed::{Guessed, OF_ODOMETRY};
use super::joints;
use super::times;
use super::units::words;
use crate::foreign_csv::entry::{ColumnEntry, Source, TimeEntry};
use crate::table::StreamKind;

/// Words in names of poses that nobody measured.
const NOT_MEASURED: [&str; 4] = ["goal", "target", "waypoint", "initialpose"];
/// Words between the name of a message and its fields.
const NESTED: [&str; 3] = ["pose", "twist", "transform"];

/// One message of a file: the words before its fields, and where they are.
struct MessageWords<'a> {
    columns: &'a Columns<'a>,
    prefix: Vec<String>,
    /// The words of the file's name.
    file: Vec<String>,
}

/// The streams of the messages. `file` is the file's name, which may tell what they are.
pub(super) fn guess(columns: &Columns<'_>, file: &str) -> Vec<Guessed> {
    let mut messages: Vec<MessageWords<'_>> = Vec::new();
    for prefix in columns.words.iter().filter_map(|name| prefix_of(name)) {
        if messages.iter().all(|message| message.prefix != prefix) {
            messages.push(MessageWords {
                columns,
                prefix,
                file: words(file),
            });
        }
    }
    // The first pose is taken.
    messages.sort_by_key(|message| !message.is_called(&REFERENCES));
    let of_file = times::of_file(columns);
    // Messages with stamps and messages without are on one clock only by the time of the file.
    let all_have_stamps = messages.iter().all(|message| message.stamp().is_some());
    let may_stamp = all_have_stamps || of_file.is_none();
    let streams = messages.iter().flat_map(|message| {
        let stamp = message.stamp().filter(|_| may_stamp);
        let time = stamp.or_else(|| of_file.clone());
        time.map_or_else(Vec::new, |time| message.streams(&time))
    });
    let wheels = joints::guess(columns, |name| {
        let stamp = times::of_message(columns, |prefix| name.starts_with(without_nested(prefix)));
        stamp.filter(|_| may_stamp).or_else(|| of_file.clone())
    });
    let mut guessed: Vec<Guessed> = Vec::new();
    for new in streams.chain(wheels) {
        match guessed.iter_mut().find(|old| old.kind == new.kind) {
            // A pose of its own outweighs that of odometry.
            Some(old) if old.note.is_some() && new.note.is_none() => *old = new,
            Some(_) => {}
            None => guessed.push(new),
        }
    }
    guessed
}

/// Words of a field of a message.
const FIELDS: [&str; 14] = [
    "position x",
    "position y",
    "point x",
    "point y",
    "translation x",
    "translation y",
    "orientation z",
    "rotation z",
    "linear x",
    "angular z",
    "angular velocity z",
    "linear acceleration x",
    "linear acceleration y",
    "header stamp",
];

/// The words before the field of a message; `None` if the name is none.
fn prefix_of(name: &[String]) -> Option<Vec<String>> {
    let mut fields = FIELDS
        .iter()
        .map(|field| field.split(' ').collect::<Vec<_>>());
    let field = fields.find(|field| name.ends_with_words(field))?;
    Some(without_nested(name.get(..name.len() - field.len())?).to_vec())
}

/// The words before `pose`, `twist` and `transform`.
fn without_nested(words: &[String]) -> &[String] {
    let is_nested = |word: &&String| NESTED.contains(&word.as_str());
    let nested = words.iter().rev().take_while(is_nested).count();
    words.get(..words.len() - nested).unwrap_or_default()
}

trait EndsWith {
    fn ends_with_words(&self, end: &[&str]) -> bool;
}

impl EndsWith for [String] {
    fn ends_with_words(&self, end: &[&str]) -> bool {
        let start = self.len().checked_sub(end.len());
        start
            .and_then(|start| self.get(start..))
            .is_some_and(|own| own == end)
    }
}

impl MessageWords<'_> {
    /// The column of a field.
    fn find(&self, field: &str) -> Option<ColumnEntry> {
        let field: Vec<&str> = field.split(' ').collect();
        let is_it = |name: &Vec<String>| {
            let before = name.len().checked_sub(field.len());
            let before = before.and_then(|end| name.get(..end)).unwrap_or_default();
            name.ends_with_words(&field) && without_nested(before) == self.prefix
        };
        let index = self.columns.words.iter().position(is_it)?;
        Some(self.columns.entry(index, 1.0))
    }

    fn stamp(&self) -> Option<TimeEntry> {
        times::of_message(self.columns, |prefix| without_nested(prefix) == self.prefix)
    }

    /// Whether the message, or the file, has one of these words in its name.
    fn is_called(&self, called: &[&str]) -> bool {
        let mut own = self.prefix.iter().chain(&self.file);
        own.any(|word| called.contains(&word.as_str()))
    }

    fn one(&self, field: &str) -> Option<Source<ColumnEntry>> {
        self.find(field).map(Source::One)
    }

    /// A stream with those columns that there are; `None` if there are none.
    fn guessed(
        &self,
        kind: StreamKind,
        time: &TimeEntry,
        columns: &[(&'static str, Option<Source<ColumnEntry>>)],
    ) -> Option<Guessed> {
        let present = columns.iter();
        let present: Vec<_> = present
            .filter_map(|(name, own)| Some((*name, own.clone()?)))
            .collect();
        (!present.is_empty()).then(|| Guessed::new(kind, time.clone(), present))
    }

    fn streams(&self, time: &TimeEntry) -> Vec<Guessed> {
        let rate = self.one("angular velocity z");
        let is_measured = rate.is_none() && !self.is_called(&NOT_MEASURED);
        let pose = self.pose(time).filter(|_| is_measured);
        let is_odometry = self.one("linear x").is_some()
            && (pose.is_some() || self.is_called(&["odom", "odometry"]));
        if self.is_called(&REFERENCES) {
            return pose.into_iter().collect();
        }
        let imu = self.guessed(
            StreamKind::Imu,
            time,
            &[
                ("ax_m_s2", self.one("linear acceleration x")),
                ("ay_m_s2", self.one("linear acceleration y")),
                ("gz_rad_s", rate),
            ],
        );
        let note = |pose: Guessed| match is_odometry {
            true => pose.with_note(OF_ODOMETRY),
            false => pose,
        };
        let all = [self.twist(time, is_odometry), pose.map(note), imu];
        all.into_iter().flatten().collect()
    }

    /// A command, or what an odometry tells. Twists without stamps are commands.
    fn twist(&self, time: &TimeEntry, is_odometry: bool) -> Option<Guessed> {
        let (v, w) = (self.one("linear x")?, self.one("angular z"));
        let is_command = self.is_called(&COMMANDS) || self.stamp().is_none();
        let kind = match is_command && !is_odometry {
            true if w.is_none() => return None,
            true => StreamKind::Command,
            false => StreamKind::Odometry,
        };
        self.guessed(kind, time, &[("v_m_s", Some(v)), ("w_rad_s", w)])
    }

    fn pose(&self, time: &TimeEntry) -> Option<Guessed> {
        let mut places = ["position", "translation", "point"].into_iter();
        let place = |name: &str| {
            Some([
                self.one(&format!("{name} x"))?,
                self.one(&format!("{name} y"))?,
            ])
        };
        let [x, y] = places.find_map(place)?;
        let mut columns = vec![("x_m", x), ("y_m", y)];
        let mut turns = ["orientation", "rotation"].into_iter();
        let turn = |name: &str| {
            let [x, y, z, w] =
                ["x", "y", "z", "w"].map(|axis| self.find(&format!("{name} {axis}")));
            Some(Source::Quaternion([x, y], [z?, w?]))
        };
        columns.extend(turns.find_map(turn).map(|yaw| ("yaw_rad", yaw)));
        Some(Guessed::new(StreamKind::Pose, time.clone(), columns))
    }
}
