//! Reader of MCAP files that slipstream wrote. The channel metadata says which stream a channel holds.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use slipstream_bag::ros::MessageType;
use slipstream_bag::ros::time::s_from_ns;
use slipstream_bag::{ChannelInfo, Item, Loss, Result, Summary, VisitResult, read_bag};
use slipstream_bus::InputError;

use crate::decode::{LinksBuilder, RoundTripsBuilder, StreamBuilder};
use crate::import::{Import, Spooled};
use crate::recording::{Recording, is_robot_name};
use crate::rows::{Disk, SpooledRecording};
use crate::table::StreamKind;
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics::{self, StreamMetadata};

/// Reads an MCAP file that slipstream wrote, from any source of `size` bytes; it may be truncated or
/// damaged. [`Import::warnings`] and [`Import::loss`] say what was lost. `path` is used in errors and
/// for the recording's name only.
///
/// # Errors
/// If it is not an MCAP file, if slipstream did not write it, or if its description is invalid.
pub fn read_mcap_from(source: impl Read, size: u64, path: &Path) -> Result<Import> {
    let spooled = read_own(source, size, path)?;
    let problem = "no channel says which stream it holds";
    let remedy = "give a file that slipstream wrote";
    let spooled = spooled.ok_or_else(|| InputError::file(path, problem, remedy))?;
    spooled.load()
}

/// As [`read_mcap_from`], but returns `None` for a bag that slipstream did not write.
pub(crate) fn read_own(source: impl Read, size: u64, path: &Path) -> Result<Option<Spooled>> {
    let mut loader = Loader::default();
    let loss = read_bag(source, size, path, &mut |item| loader.visit(item))?;
    if !loader.is_own {
        return Ok(None);
    }
    loader.finish(loss, path).map(Some)
}

/// Whether the index of a file says that slipstream wrote it.
pub(crate) fn is_own(summary: &Summary) -> bool {
    let is_named = |name: &String| name == topics::FILE_METADATA;
    let mut channels = summary.channels.values();
    summary.metadata.iter().any(is_named) || channels.any(|channel| is_stream(channel))
}

/// Whether a channel holds, or shows, a stream in slipstream's own layout.
pub(crate) fn is_stream(channel: &ChannelInfo) -> bool {
    topics::is_view(&channel.metadata) || StreamMetadata::from_map(&channel.metadata).is_some()
}

/// Where the messages of a channel go. `rows` tells lossless rows from standard messages.
#[derive(Debug, Clone, Copy)]
enum Route {
    /// Nowhere: another channel holds the same stream.
    View,
    /// Nowhere: [`Recording`] cannot represent them.
    LeftOut,
    /// To a robot's stream.
    Stream { builder: usize, rows: bool },
    /// To the position messages.
    Links { rows: bool },
    /// To the round trips.
    RoundTrips { rows: bool },
}

/// The contents of a file as far as they have been read.
#[derive(Debug, Default)]
pub(super) struct Loader {
    /// Where the rows go.
    pub(super) disk: Disk,
    /// Whether slipstream wrote the file.
    is_own: bool,
    /// Text of the attached `recording.toml`.
    description: Option<String>,
    /// Text of the attached `robot.toml`.
    model: Option<String>,
    /// By channel id.
    routes: Vec<Route>,
    pub(super) streams: Vec<StreamBuilder>,
    pub(super) links: Option<LinksBuilder>,
    pub(super) round_trips: Option<RoundTripsBuilder>,
    /// Number of messages that [`Recording`] cannot represent, by topic.
    left_out: BTreeMap<String, u64>,
    pub(super) warnings: Vec<String>,
}

impl Loader {
    pub(super) fn visit(&mut self, item: Item<'_>) -> VisitResult {
        match item {
            Item::Channel { id, channel } => {
                let route = self.route_of(channel);
                let index = id as usize;
                if self.routes.len() <= index {
                    self.routes.resize(index + 1, Route::View);
                }
                if let Some(slot) = self.routes.get_mut(index) {
                    *slot = route;
                }
            }
            Item::Message {
                id, channel, data, ..
            } => return self.message(id, channel, data),
            Item::Unwanted { .. } => {}
            Item::Attachment { name, data } => {
                let text = || String::from_utf8_lossy(data).into_owned();
                match name {
                    topics::DESCRIPTION => self.description = Some(text()),
                    topics::MODEL => self.model = Some(text()),
                    _ => {}
                }
            }
            Item::Metadata { name } => self.is_own |= name == topics::FILE_METADATA,
        }
        Ok(())
    }

    fn message(&mut self, id: u32, channel: &Arc<ChannelInfo>, data: &[u8]) -> VisitResult {
        let route = self.routes.get(id as usize).copied();
        match route.unwrap_or(Route::View) {
            Route::View => Ok(()),
            Route::LeftOut => {
                // Not `entry`, which would allocate a key for every message.
                match self.left_out.get_mut(&channel.topic) {
                    Some(count) => *count += 1,
                    None => {
                        self.left_out.insert(channel.topic.clone(), 1);
                    }
                }
                Ok(())
            }
            Route::Stream { builder, rows } => match self.streams.get_mut(builder) {
                Some(stream) if rows => stream.push_row(data),
                Some(stream) => {
                    let t_s = |t_ns: Option<i64>| s_from_ns(t_ns.unwrap_or_default());
                    stream.push_message(channel, data, t_s)
                }
                None => Ok(()),
            },
            Route::Links { rows } => match &mut self.links {
                Some(links) if rows => links.push_row(data),
                Some(links) => links.push_message(data),
                None => Ok(()),
            },
            Route::RoundTrips { rows } => match &mut self.round_trips {
                Some(trips) if rows => trips.push_row(data),
                Some(trips) => trips.push_message(data),
                None => Ok(()),
            },
        }
    }

    /// Decides where the messages of a new channel go.
    fn route_of(&mut self, channel: &ChannelInfo) -> Route {
        if topics::is_view(&channel.metadata) {
            self.is_own = true;
            return Route::View;
        }
        let Some(metadata) = StreamMetadata::from_map(&channel.metadata) else {
            return Route::LeftOut;
        };
        self.is_own = true;
        let rows = channel.schema == MessageType::Row.name();
        match self.open(&metadata, rows) {
            Ok(route) => route,
            Err(problem) => {
                let topic = &channel.topic;
                self.warnings
                    .push(format!("topic {topic}: {problem}; ignored"));
                Route::LeftOut
            }
        }
    }

    /// Creates the builder of a stream.
    fn open(
        &mut self,
        metadata: &StreamMetadata,
        rows: bool,
    ) -> std::result::Result<Route, String> {
        match metadata.stream.as_str() {
            topics::LINK_STREAM if self.links.is_none() => {
                let with_velocity = metadata.columns.iter().any(|column| column == "v_m_s");
                self.links = Some(LinksBuilder::new(
                    &self.disk,
                    with_velocity,
                    &metadata.unknown,
                ));
                Ok(Route::Links { rows })
            }
            topics::ROUND_TRIP_STREAM if self.round_trips.is_none() => {
                self.round_trips = Some(RoundTripsBuilder::new(&self.disk, &metadata.unknown));
                Ok(Route::RoundTrips { rows })
            }
            stream => {
                let (robot, kind) = stream.rsplit_once('/').unwrap_or(("", stream));
                let kind = StreamKind::from_name(kind).filter(|_| is_robot_name(robot));
                let Some(kind) = kind else {
                    return Err(format!(
                        "holds the stream {stream}, which the format does not define"
                    ));
                };
                let is_same = |s: &StreamBuilder| s.robot == robot && s.kind == kind;
                if self.streams.iter().any(is_same) {
                    return Err(format!("an earlier topic already holds {stream}"));
                }
                let (columns, unknown) = (&metadata.columns, &metadata.unknown);
                let stream = StreamBuilder::new(&self.disk, robot, kind, columns, unknown)?;
                self.streams.push(stream);
                Ok(Route::Stream {
                    builder: self.streams.len() - 1,
                    rows,
                })
            }
        }
    }

    fn finish(mut self, loss: Loss, path: &Path) -> Result<Spooled> {
        let mut warnings = std::mem::take(&mut self.warnings);
        if loss.any() {
            warnings.insert(0, format!("{}: {loss}", path.display()));
        }
        let description = describe(&self, path, &mut warnings)?;
        let mut recording = SpooledRecording::new(description, self.disk);
        for stream in self.streams {
            stream.finish(&mut recording, &mut warnings);
        }
        if let Some(links) = self.links {
            let (spool, with_velocity) = links.finish(&mut warnings);
            recording.store_links(spool, with_velocity);
        }
        if let Some(trips) = self.round_trips {
            recording.store_round_trips(trips.finish(&mut warnings));
        }
        recording.disk.check()?;
        Ok(Spooled {
            recording,
            guesses: Vec::new(),
            warnings,
            on_model: Vec::new(),
            loss: Some(loss),
            left_out: self.left_out,
        })
    }
}

/// The recording without rows.
pub(super) fn describe(
    loader: &Loader,
    path: &Path,
    warnings: &mut Vec<String>,
) -> Result<Recording> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy());
    let stem = stem.unwrap_or_default();
    // In errors, an attachment is named as a file inside the MCAP file.
    let mut description = match &loader.description {
        Some(text) => recording_toml::parse(text, &path.join(topics::DESCRIPTION), &stem)?,
        None => {
            warnings.push(format!("{}: the description is missing", path.display()));
            Recording {
                name: stem.into_owned(),
                ..Recording::default()
            }
        }
    };
    if let Some(text) = &loader.model {
        description.model = Some(robot_toml::parse(text, &path.join(topics::MODEL))?);
    }
    Ok(description)
}
