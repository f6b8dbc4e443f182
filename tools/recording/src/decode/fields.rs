//! Chosen numbers in messages of any type whose definition is known.

use slipstream_bag::ros::{Encoding, Layout};
use slipstream_bag::{ChannelInfo, Undecodable};

/// The fields of the messages of a channel. `None` if its encoding or the definition of its type is not known.
pub(crate) fn layout_of(channel: &ChannelInfo) -> Option<Layout> {
    Encoding::of(&channel.encoding)?;
    let (form, text) = &*channel.definition;
    match form.as_str() {
        // Some writers leave the definition empty.
        "ros2msg" | "ros1msg" if !text.is_empty() => {
            let text = std::str::from_utf8(text).ok()?;
            Layout::parse(&channel.schema, text)
        }
        _ => Layout::known(&channel.schema),
    }
}

/// Time stamp of a message, from the numbers of `header.stamp` or `stamp`.
#[derive(Debug, Default)]
pub(crate) struct Stamp {
    ns: Option<i64>,
}

impl Stamp {
    /// Takes a number. Returns whether it is of the header.
    pub(crate) fn add(&mut self, path: &str, value: f64) -> bool {
        let unit_ns = match path.strip_prefix("header.").unwrap_or(path) {
            "stamp.sec" => 1_000_000_000,
            "stamp.nanosec" => 1,
            _ => return path.starts_with("header."),
        };
        let part_ns = (value as i64).saturating_mul(unit_ns);
        self.ns = Some(self.ns.unwrap_or_default().saturating_add(part_ns));
        true
    }

    /// The time (ns); `None` if the message has none.
    pub(crate) fn ns(&self) -> Option<i64> {
        self.ns
    }
}

/// Reads chosen fields.
#[derive(Debug)]
pub(crate) struct Fields {
    layout: Layout,
    encoding: Encoding,
    /// Paths of the fields, right and left. Of several on a side the mean counts.
    paths: [Vec<String>; 2],
}

impl Fields {
    /// The fields of a channel's messages with these paths, right and left; `None` if its definition is not known.
    pub(crate) fn new(channel: &ChannelInfo, paths: [Vec<String>; 2]) -> Option<Self> {
        Some(Self {
            layout: layout_of(channel)?,
            encoding: Encoding::of(&channel.encoding)?,
            paths,
        })
    }

    /// The stamp of a message (ns), if it has one, and its values right and left; NaN where it has none.
    ///
    /// # Errors
    /// If the message is not of the type of the channel.
    pub(crate) fn read(&self, data: &[u8]) -> Result<(Option<i64>, [f64; 2]), Undecodable> {
        let mut stamp = Stamp::default();
        let mut sums = [[0.0; 2]; 2];
        self.layout
            .numbers(self.encoding, data, &mut |path, number| {
                stamp.add(path, number.value);
                for ([sum, found], paths) in sums.iter_mut().zip(&self.paths) {
                    if paths.iter().any(|own| own == path) {
                        *sum += number.value;
                        *found += 1.0;
                    }
                }
            })
            .map_err(|_| Undecodable)?;
        let mut values = [f64::NAN; 2];
        for ((value, [sum, found]), paths) in values.iter_mut().zip(sums).zip(&self.paths) {
            if found > 0.0 && found == paths.len() as f64 {
                *value = sum / found;
            }
        }
        Ok((stamp.ns(), values))
    }
}
