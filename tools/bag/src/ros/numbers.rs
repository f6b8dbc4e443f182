//! The numbers in a message of any type, by the paths of their fields.

use super::Encoding;
use super::layout::{Count, Field, Kind, Layout};

/// Of a longer list, so many first elements are told.
const MOST_ELEMENTS: usize = 16;
/// Deepest nesting of types.
const MOST_DEPTH: usize = 16;

/// A number in a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// What it is.
    pub value: f64,
    /// Whether its type has whole numbers alone.
    pub is_whole: bool,
}

/// Whoever takes the numbers: path, such as `header.stamp.sec` or `data[0]`, and value.
pub type Take<'a> = dyn FnMut(&str, Number) + 'a;

impl Layout {
    /// Calls `take` with each number of a message. Time is bounded by the length of the message.
    ///
    /// # Errors
    /// If the bytes are not a message of this type.
    pub fn numbers(
        &self,
        encoding: Encoding,
        bytes: &[u8],
        take: &mut Take<'_>,
    ) -> Result<(), String> {
        let (body, is_big_endian) = match (encoding, bytes) {
            (Encoding::Ros1, _) => (bytes, false),
            (Encoding::Cdr, [_, 0, _, _, body @ ..]) => (body, true),
            (Encoding::Cdr, [_, 1, _, _, body @ ..]) => (body, false),
            (Encoding::Cdr, _) => return Err("is not plain CDR".to_owned()),
        };
        let mut walk = MessageWalk {
            layout: self,
            body,
            at: 0,
            is_aligned: encoding == Encoding::Cdr,
            is_big_endian,
            steps_left: MOST_STEPS + bytes.len().saturating_mul(2),
            path: String::new(),
            take,
        };
        walk.message(0, 0, true).ok_or_else(|| {
            format!(
                "is not a message of its type: it ends or repeats at byte {}",
                walk.at
            )
        })
    }

    /// The paths of all fields with numbers; of lists, that of the list. At most a thousand.
    pub fn number_paths(&self) -> Vec<String> {
        let mut paths = FieldPaths {
            found: Vec::new(),
            steps_left: MOST_STEPS,
        };
        self.add_paths(0, 0, "", &mut paths);
        paths.found
    }

    fn add_paths(&self, index: usize, depth: usize, before: &str, paths: &mut FieldPaths) {
        const MOST_PATHS: usize = 1000;
        for field in self.types.get(index).into_iter().flatten() {
            let is_full = paths.found.len() >= MOST_PATHS || paths.steps_left == 0;
            if depth > MOST_DEPTH || is_full {
                return;
            }
            paths.steps_left -= 1;
            let path = format!("{before}{}", field.name);
            match field.kind {
                Kind::Whole { .. } | Kind::Real { .. } => paths.found.push(path),
                Kind::Message(inner) => {
                    self.add_paths(inner, depth + 1, &format!("{path}."), paths);
                }
                Kind::Bool | Kind::Time | Kind::Text => {}
            }
        }
    }
}

/// A message may have so many fields and elements, and two more for each of its bytes.
const MOST_STEPS: usize = 10_000;

/// The paths of fields being collected.
struct FieldPaths {
    found: Vec<String>,
    /// Types that contain others many times may have fields without end.
    steps_left: usize,
}

/// A message being read, field by field. `None` means that it is not a message of its type.
struct MessageWalk<'a, 't> {
    layout: &'a Layout,
    body: &'a [u8],
    /// Place in the body (bytes).
    at: usize,
    /// Whether a number stands at a multiple of its size.
    is_aligned: bool,
    is_big_endian: bool,
    /// Empty types take no bytes, and may repeat without end.
    steps_left: usize,
    path: String,
    take: &'a mut Take<'t>,
}

impl MessageWalk<'_, '_> {
    fn message(&mut self, index: usize, depth: usize, is_told: bool) -> Option<()> {
        if depth > MOST_DEPTH {
            return None;
        }
        let layout = self.layout;
        let fields = layout.types.get(index)?;
        if fields.is_empty() && self.is_aligned {
            // CDR has no empty messages: a byte stands for one.
            self.skip(1)?;
        }
        for field in fields {
            let length = self.path.len();
            if is_told {
                if length > 0 {
                    self.path.push('.');
                }
                self.path.push_str(&field.name);
            }
            self.field(field, depth, is_told)?;
            self.path.truncate(length);
        }
        Some(())
    }

    fn field(&mut self, field: &Field, depth: usize, is_told: bool) -> Option<()> {
        let count = match field.count {
            Count::One => return self.value(field.kind, depth, is_told),
            Count::Fixed(count) => count,
            Count::Any => usize::try_from(self.unsigned(4)?).ok()?,
        };
        let length = self.path.len();
        let told = if is_told { count.min(MOST_ELEMENTS) } else { 0 };
        for i in 0..told {
            self.path.push_str(&format!("[{i}]"));
            self.value(field.kind, depth, true)?;
            self.path.truncate(length);
        }
        let others = count - told;
        match size_of(field.kind) {
            Some(_) if others == 0 => {}
            Some(size) => {
                self.align(size.min(8));
                self.skip(others.checked_mul(size)?)?;
            }
            None => {
                for _ in 0..others {
                    self.value(field.kind, depth, false)?;
                }
            }
        }
        Some(())
    }

    fn value(&mut self, kind: Kind, depth: usize, is_told: bool) -> Option<()> {
        self.steps_left = self.steps_left.checked_sub(1)?;
        match kind {
            Kind::Whole { bytes, signed } => {
                let bits = self.unsigned(bytes)?;
                let unused = 64 - 8 * u32::try_from(bytes).ok()?;
                let value = match signed {
                    true => ((bits << unused) as i64 >> unused) as f64,
                    false => bits as f64,
                };
                self.tell(value, true, is_told);
            }
            Kind::Real { bytes } => {
                let bits = self.unsigned(bytes)?;
                let value = match u32::try_from(bits) {
                    Ok(bits) if bytes == 4 => f64::from(f32::from_bits(bits)),
                    _ => f64::from_bits(bits),
                };
                self.tell(value, false, is_told);
            }
            Kind::Bool => self.skip(1)?,
            Kind::Time => self.time(is_told)?,
            Kind::Text => {
                let length = usize::try_from(self.unsigned(4)?).ok()?;
                self.skip(length)?;
            }
            Kind::Message(index) => self.message(index, depth + 1, is_told)?,
        }
        Some(())
    }

    /// Seconds and nanoseconds; both are told as those of ROS 2.
    fn time(&mut self, is_told: bool) -> Option<()> {
        let length = self.path.len();
        for part in [".sec", ".nanosec"] {
            let bits = self.unsigned(4)?;
            self.path.push_str(part);
            self.tell(bits as f64, true, is_told);
            self.path.truncate(length);
        }
        Some(())
    }

    fn tell(&mut self, value: f64, is_whole: bool, is_told: bool) {
        if is_told {
            (self.take)(&self.path, Number { value, is_whole });
        }
    }

    /// The next number of so many bytes.
    fn unsigned(&mut self, bytes: usize) -> Option<u64> {
        self.align(bytes);
        let end = self.at.checked_add(bytes)?;
        let taken = self.body.get(self.at..end)?;
        self.at = end;
        let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Some(match self.is_big_endian {
            true => taken.iter().fold(0, join),
            false => taken.iter().rev().fold(0, join),
        })
    }

    fn align(&mut self, size: usize) {
        if self.is_aligned {
            self.at = self.at.next_multiple_of(size);
        }
    }

    fn skip(&mut self, bytes: usize) -> Option<()> {
        let end = self.at.checked_add(bytes)?;
        self.body.get(self.at..end)?;
        self.at = end;
        Some(())
    }
}

/// Bytes of a value, if they are the same for all.
fn size_of(kind: Kind) -> Option<usize> {
    match kind {
        Kind::Whole { bytes, .. } | Kind::Real { bytes } => Some(bytes),
        Kind::Bool => Some(1),
        Kind::Time | Kind::Text | Kind::Message(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "std_msgs/Header header\nuint8 kind\nint16[] counts\nfloat64 speed\nOwn[2] own\n\
        ====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ====\nMSG: a/Own\nuint32 ticks\n";

    fn told(encoding: Encoding, bytes: &[u8]) -> Result<Vec<(String, f64)>, String> {
        let layout = Layout::parse("a/msg/Base", TEXT).unwrap();
        let mut told = Vec::new();
        let mut take = |path: &str, number: Number| told.push((path.to_owned(), number.value));
        layout.numbers(encoding, bytes, &mut take)?;
        Ok(told)
    }

    /// The message in CDR, each part with the bytes that align it.
    fn message() -> Vec<u8> {
        let parts: [&[u8]; 11] = [
            &[0, 1, 0, 0],
            &7_u32.to_le_bytes(),
            &9_u32.to_le_bytes(),
            &[2, 0, 0, 0, b'a', 0],
            &[5, 0],
            &1_u32.to_le_bytes(),
            &(-3_i16).to_le_bytes(),
            &[0; 2],
            &0.5_f64.to_le_bytes(),
            &4_000_000_000_u32.to_le_bytes(),
            &1_u32.to_le_bytes(),
        ];
        parts.concat()
    }

    #[test]
    fn numbers_have_the_paths_of_their_fields() {
        let expected = [
            ("header.stamp.sec", 7.0),
            ("header.stamp.nanosec", 9.0),
            ("kind", 5.0),
            ("counts[0]", -3.0),
            ("speed", 0.5),
            ("own[0].ticks", 4e9),
            ("own[1].ticks", 1.0),
        ];
        let expected = expected.map(|(path, value)| (path.to_owned(), value));
        assert_eq!(told(Encoding::Cdr, &message()).unwrap(), expected);
    }

    #[test]
    fn what_ends_early_is_no_message() {
        let whole = message();
        for length in 0..whole.len() {
            assert!(told(Encoding::Cdr, &whole[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn types_that_contain_each_other_many_times_end() {
        let mut text = String::new();
        for level in 0..16 {
            for field in 0..16 {
                text.push_str(&format!("a/T{level} f{field}\n"));
            }
            text.push_str(&format!("====\nMSG: a/T{level}\n"));
        }
        text.push_str("string end\n");
        let layout = Layout::parse("a/msg/Base", &text).unwrap();
        assert!(layout.number_paths().is_empty());
    }

    #[test]
    fn a_type_that_repeats_without_bytes_ends() {
        let text = "Own[1000000000] own\n====\nMSG: a/Own\n";
        let layout = Layout::parse("a/msg/Base", text).unwrap();
        assert!(layout.numbers(Encoding::Ros1, &[], &mut |_, _| {}).is_err());
    }
}
