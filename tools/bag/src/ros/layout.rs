//! Fields of a message of any type, from the definition (`.msg` text) that a bag has of it.

use std::collections::BTreeMap;

/// Longer definitions (bytes) are not read.
const MOST_BYTES: usize = 256 << 10;
/// Most fields of a type with all types that it contains.
const MOST_FIELDS: usize = 4096;

/// The fields of a message type and of all types that it contains.
#[derive(Debug)]
pub struct Layout {
    /// The fields of each type; the message itself is the first.
    pub(super) types: Vec<Vec<Field>>,
}

/// A field of a message.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    pub(super) count: Count,
}

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A whole number of so many bytes.
    Whole {
        bytes: usize,
        signed: bool,
    },
    /// A floating-point number of so many bytes.
    Real {
        bytes: usize,
    },
    /// One byte that is no number.
    Bool,
    /// Seconds and nanoseconds, 32 bits each.
    Time,
    Text,
    /// The type of this index.
    Message(usize),
}

/// How many values a field holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    /// The message says how many.
    Any,
}

/// Longer names (bytes) are none of a field.
const MOST_NAME_BYTES: usize = 256;

/// One type of a definition, with the text of its fields.
struct TypeSection<'a> {
    /// Package and type, such as `std_msgs/Header`.
    name: String,
    lines: Vec<&'a str>,
}

impl Layout {
    /// Parses a definition of the type `name` (such as `std_msgs/msg/Int32`), in the form of ROS 1 or ROS 2. `None` if it is
    /// none, contains a type that it does not define, or is too long.
    pub fn parse(name: &str, text: &str) -> Option<Self> {
        if text.len() > MOST_BYTES {
            return None;
        }
        let sections = sections(name, text);
        let mut indices = BTreeMap::new();
        // No type contains itself.
        for (index, section) in sections.iter().enumerate().skip(1) {
            indices.entry(section.name.as_str()).or_insert(index);
        }
        let mut types = Vec::new();
        let mut fields = 0;
        for section in &sections {
            let own: Option<Vec<Field>> = section
                .lines
                .iter()
                .filter_map(|line| field(line))
                .map(|(of, name)| typed(of, name, section, &indices))
                .collect();
            let own = own?;
            fields += own.len();
            if fields > MOST_FIELDS {
                return None;
            }
            types.push(own);
        }
        Some(Self { types })
    }

    /// The layout of a type that needs no definition: one number of `std_msgs`.
    pub fn known(name: &str) -> Option<Self> {
        let number = name.strip_prefix("std_msgs/msg/")?.to_lowercase();
        number_of(&number)?;
        Self::parse(name, &format!("{number} data"))
    }

    /// Whether it has a list of bytes that is called `data`, as images and compressed messages have.
    pub fn has_raw_data(&self) -> bool {
        let is_raw = |field: &Field| {
            let are_bytes = matches!(field.kind, Kind::Whole { bytes: 1, .. });
            field.count == Count::Any && are_bytes && field.name == "data"
        };
        self.types.iter().flatten().any(is_raw)
    }
}

/// The types of a definition; the first is its own.
fn sections<'a>(name: &str, text: &'a str) -> Vec<TypeSection<'a>> {
    let mut sections = vec![TypeSection {
        name: without_msg(name),
        lines: Vec::new(),
    }];
    for line in text.lines() {
        if let Some(name) = line.trim().strip_prefix("MSG:") {
            sections.push(TypeSection {
                name: without_msg(name.trim()),
                lines: Vec::new(),
            });
        } else if let Some(last) = sections.last_mut()
            && !line.starts_with("====")
        {
            last.lines.push(line);
        }
    }
    sections
}

fn without_msg(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Type and name of the field that a line declares; `None` for comments and constants.
fn field(line: &str) -> Option<(&str, &str)> {
    let line = line.trim();
    if line.starts_with('#') {
        return None;
    }
    let (of, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let (name, rest) = rest.split_at_checked(end.unwrap_or(rest.len()))?;
    let is_constant = rest.trim_start().starts_with('=');
    (!is_constant && !name.is_empty()).then_some((of, name))
}

/// The field of a type as it is written, such as `float64[9]`. `None` if the type is not known, or the name too long.
fn typed(
    of: &str,
    name: &str,
    section: &TypeSection<'_>,
    indices: &BTreeMap<&str, usize>,
) -> Option<Field> {
    if name.len() > MOST_NAME_BYTES {
        return None;
    }
    let (of, count) = match of.split_once('[') {
        None => (of, Count::One),
        Some((of, count)) => {
            let count = count.strip_suffix(']')?;
            let is_any = count.is_empty() || count.starts_with("<=");
            let fixed = || count.parse().ok().map(Count::Fixed);
            let count = if is_any { Some(Count::Any) } else { fixed() };
            (of, count?)
        }
    };
    Some(Field {
        name: name.to_owned(),
        kind: kind(of, section, indices)?,
        count,
    })
}

fn kind(of: &str, section: &TypeSection<'_>, indices: &BTreeMap<&str, usize>) -> Option<Kind> {
    if let Some(number) = number_of(of) {
        return Some(number);
    }
    match of {
        "bool" => return Some(Kind::Bool),
        "time" | "duration" => return Some(Kind::Time),
        _ if of == "string" || of.starts_with("string<=") => return Some(Kind::Text),
        _ => {}
    }
    let of = without_msg(of);
    let package = section.name.split('/').next().unwrap_or_default();
    let beside = format!("{package}/{of}");
    let names = [of.as_str(), beside.as_str()];
    let named = names.iter().find_map(|name| indices.get(name));
    let header = || (of == "Header").then(|| indices.get("std_msgs/Header"))?;
    if let Some(index) = named.or_else(header) {
        return Some(Kind::Message(*index));
    }
    let is_time = matches!(
        of.as_str(),
        "builtin_interfaces/Time" | "builtin_interfaces/Duration"
    );
    is_time.then_some(Kind::Time)
}

/// The kind of a number's type.
fn number_of(of: &str) -> Option<Kind> {
    let whole = |bytes, signed| Some(Kind::Whole { bytes, signed });
    match of {
        "int8" => whole(1, true),
        "uint8" | "byte" | "char" => whole(1, false),
        "int16" => whole(2, true),
        "uint16" => whole(2, false),
        "int32" => whole(4, true),
        "uint32" => whole(4, false),
        "int64" => whole(8, true),
        "uint64" => whole(8, false),
        "float32" => Some(Kind::Real { bytes: 4 }),
        "float64" => Some(Kind::Real { bytes: 8 }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_told_from_constants_and_comments() {
        let text = "# of a base\nint32 LEFT=1\nuint8 OFF = 0 # off\nstring WHO=a b\n\
            int32[<=4] counts # so many\nstring<=10 name\nfloat32 speed 0.5\nHeader header\nOwn[2] own\n\
            ================\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\n================\nMSG: a/Own\nbool on\n";
        let layout = Layout::parse("a/msg/Base", text).unwrap();
        let own: Vec<(&str, Kind, Count)> = layout.types[0]
            .iter()
            .map(|field| (field.name.as_str(), field.kind, field.count))
            .collect();
        let whole = Kind::Whole {
            bytes: 4,
            signed: true,
        };
        assert_eq!(
            own,
            [
                ("counts", whole, Count::Any),
                ("name", Kind::Text, Count::One),
                ("speed", Kind::Real { bytes: 4 }, Count::One),
                ("header", Kind::Message(1), Count::One),
                ("own", Kind::Message(2), Count::Fixed(2)),
            ]
        );
    }

    #[test]
    fn a_type_without_its_definition_is_none() {
        assert!(Layout::parse("a/msg/Base", "b/Other other").is_none());
        assert!(Layout::parse("a/msg/Base", "wstring name").is_none());
        assert!(Layout::known("std_msgs/msg/UInt16").is_some());
        assert!(Layout::known("std_msgs/msg/String").is_none());
    }
}
