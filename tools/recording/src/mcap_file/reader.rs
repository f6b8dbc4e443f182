//! MCAP files in: our own by what their channels say they carry, others by a map of topics.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use crate::bag::{ChannelInfo, Item, Loss, Visited, read_bag};
use crate::decode::{LinksBuilder, RoundTripsBuilder, StreamBuilder};
use crate::error::{Result, Unusable};
use crate::import::Import;
use crate::recording::{Recording, is_robot_name};
use crate::ros2::time::s_from_ns;
use crate::table::StreamKind;
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics::{self, Carries};

/// The type of rows kept to the digit.
const ROW: &str = "slipstream_msgs/msg/Row";

/// Reads an MCAP file, also a truncated or damaged one, from any source of `size` bytes. What was
/// lost is said in the warnings and in [`Import::loss`]. `path` is only for errors and names.
///
/// # Errors
/// When it is no MCAP file, none of slipstream's, or its description is unusable.
pub fn read_mcap_from(source: impl Read, size: u64, path: &Path) -> Result<Import> {
    let import = read_own(source, size, path)?;
    let not_ours = "no channel says what slipstream should read from it";
    import.ok_or_else(|| Unusable::new(path, not_ours, "give a file that slipstream wrote").into())
}

/// As [`read_mcap_from`]; `None` if it is a bag of someone else.
pub(crate) fn read_own(source: impl Read, size: u64, path: &Path) -> Result<Option<Import>> {
    let mut loading = Loading::default();
    let loss = read_bag(source, size, path, &mut |item| loading.visit(item))?;
    if !loading.ours {
        return Ok(None);
    }
    loading.finish(loss, path).map(Some)
}

/// What to do with the messages of a channel.
#[derive(Debug, Clone, Copy)]
enum Plan {
    /// For other programs: what it says is carried by another channel.
    View,
    /// The in-memory form has no place for it.
    Nothing,
    Stream {
        builder: usize,
        rows: bool,
    },
    Links {
        rows: bool,
    },
    RoundTrips {
        rows: bool,
    },
}

#[derive(Debug, Default)]
struct Loading {
    /// The file says that it is one of ours.
    ours: bool,
    description: Option<String>,
    model: Option<String>,
    /// What to do with each channel, by its number.
    plans: Vec<Plan>,
    streams: Vec<StreamBuilder>,
    links: Option<LinksBuilder>,
    rtt: Option<RoundTripsBuilder>,
    /// Messages that the in-memory form has no place for, by topic.
    left_out: BTreeMap<String, u64>,
    warnings: Vec<String>,
}

impl Loading {
    fn visit(&mut self, item: Item<'_>) -> Visited {
        match item {
            Item::Channel { id, channel } => {
                let plan = self.plan(channel);
                let at = usize::from(id);
                if self.plans.len() <= at {
                    self.plans.resize(at + 1, Plan::View);
                }
                if let Some(place) = self.plans.get_mut(at) {
                    *place = plan;
                }
            }
            Item::Message {
                id, channel, data, ..
            } => return self.message(id, channel, data),
            Item::Attachment { name, data } => {
                let text = || String::from_utf8_lossy(data).into_owned();
                match name {
                    topics::DESCRIPTION => self.description = Some(text()),
                    topics::MODEL => self.model = Some(text()),
                    _ => {}
                }
            }
            Item::Metadata { name } => self.ours |= name == topics::ABOUT,
        }
        Ok(())
    }

    fn message(&mut self, id: u16, channel: &Arc<ChannelInfo>, data: &[u8]) -> Visited {
        let plan = self.plans.get(usize::from(id)).copied();
        match plan.unwrap_or(Plan::View) {
            Plan::View => Ok(()),
            Plan::Nothing => {
                match self.left_out.get_mut(&channel.topic) {
                    Some(count) => *count += 1,
                    None => {
                        self.left_out.insert(channel.topic.clone(), 1);
                    }
                }
                Ok(())
            }
            Plan::Stream { builder, rows } => match self.streams.get_mut(builder) {
                Some(stream) if rows => stream.push_row(data),
                Some(stream) => {
                    let t_s = |t_ns: Option<i64>| s_from_ns(t_ns.unwrap_or_default());
                    stream.push_message(&channel.schema, data, t_s)
                }
                None => Ok(()),
            },
            Plan::Links { rows } => match &mut self.links {
                Some(links) if rows => links.push_row(data),
                Some(links) => links.push_message(data),
                None => Ok(()),
            },
            Plan::RoundTrips { rows } => match &mut self.rtt {
                Some(rtt) if rows => rtt.push_row(data),
                Some(rtt) => rtt.push_message(data),
                None => Ok(()),
            },
        }
    }

    fn plan(&mut self, channel: &ChannelInfo) -> Plan {
        if topics::is_view(&channel.metadata) {
            self.ours = true;
            return Plan::View;
        }
        let Some(carries) = Carries::from_metadata(&channel.metadata) else {
            return Plan::Nothing;
        };
        self.ours = true;
        let rows = channel.schema == ROW;
        match self.open(&carries, rows) {
            Ok(plan) => plan,
            Err(problem) => {
                let topic = &channel.topic;
                self.warnings
                    .push(format!("topic {topic}: {problem}; ignored"));
                Plan::Nothing
            }
        }
    }

    fn open(&mut self, carries: &Carries, rows: bool) -> std::result::Result<Plan, String> {
        match carries.stream.as_str() {
            "links" if self.links.is_none() => {
                let with_velocity = carries.columns.iter().any(|column| column == "v_m_s");
                self.links = Some(LinksBuilder::new(with_velocity, &carries.unknown));
                Ok(Plan::Links { rows })
            }
            "rtt" if self.rtt.is_none() => {
                self.rtt = Some(RoundTripsBuilder::new(&carries.unknown));
                Ok(Plan::RoundTrips { rows })
            }
            stream => {
                let (robot, kind) = stream.rsplit_once('/').unwrap_or(("", stream));
                let kind = StreamKind::from_name(kind).filter(|_| is_robot_name(robot));
                let Some(kind) = kind else {
                    return Err(format!("carries {stream}, which the format does not know"));
                };
                let same = |s: &StreamBuilder| s.robot == robot && s.kind == kind;
                if self.streams.iter().any(same) {
                    return Err(format!("{stream} is carried by an earlier topic already"));
                }
                let stream = StreamBuilder::new(robot, kind, &carries.columns, &carries.unknown)?;
                self.streams.push(stream);
                Ok(Plan::Stream {
                    builder: self.streams.len() - 1,
                    rows,
                })
            }
        }
    }

    fn finish(mut self, loss: Loss, path: &Path) -> Result<Import> {
        let mut warnings = std::mem::take(&mut self.warnings);
        if loss.any() {
            warnings.insert(0, format!("{}: {loss}", path.display()));
        }
        let stem = path.file_stem().map(|stem| stem.to_string_lossy());
        let stem = stem.unwrap_or_default();
        let mut recording = match &self.description {
            Some(text) => recording_toml::parse(text, &inside(path, topics::DESCRIPTION), &stem)?,
            None => {
                warnings.push(format!("{}: its description is missing", path.display()));
                Recording {
                    name: stem.into_owned(),
                    ..Recording::default()
                }
            }
        };
        if let Some(text) = &self.model {
            recording.model = Some(robot_toml::parse(text, &inside(path, topics::MODEL))?);
        }
        for stream in self.streams {
            stream.finish(&mut recording, &mut warnings);
        }
        recording.links = self.links.map(LinksBuilder::finish);
        recording.rtt = self.rtt.map(|rtt| rtt.0);
        Ok(Import {
            recording,
            warnings,
            loss: Some(loss),
            left_out: self.left_out,
        })
    }
}

/// An attachment's place, for errors.
fn inside(path: &Path, attachment: &str) -> std::path::PathBuf {
    path.join(attachment)
}
