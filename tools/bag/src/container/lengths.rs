//! Validation of the length fields inside an MCAP record.
//!
//! The `mcap` crate allocates as much as a length field claims (up to 4 GiB) before it reads the
//! text, and does not check that the last twelve bytes of an attachment exist. Damaged length fields
//! are therefore rejected here before the crate parses the record.

use mcap::records::op;

/// Whether every text of the record ends inside it. Always true for records without texts.
pub(super) fn are_valid(opcode: u8, data: &[u8]) -> bool {
    let (fixed_bytes, texts, has_map) = match opcode {
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::ATTACHMENT => (16, 2, false),
        op::METADATA => (0, 1, true),
        op::CHUNK => (28, 1, false),
        _ => return true,
    };
    let after = data
        .get(fixed_bytes..)
        .and_then(|rest| (0..texts).try_fold(rest, |rest, _| text(rest)));
    match after {
        // Length of the content (8 bytes) and checksum (4 bytes).
        Some(rest) if opcode == op::ATTACHMENT => rest.len() >= 12,
        Some(rest) if has_map => map_fits(rest).is_some(),
        Some(_) => true,
        None => false,
    }
}

/// A length field of four bytes, and the data after it.
fn length(data: &[u8]) -> Option<(usize, &[u8])> {
    let (length, rest) = data.split_first_chunk()?;
    Some((usize::try_from(u32::from_le_bytes(*length)).ok()?, rest))
}

/// The data after a text.
fn text(data: &[u8]) -> Option<&[u8]> {
    let (length, rest) = length(data)?;
    rest.get(length..)
}

/// Whether all texts of a map (length in bytes, then texts) end inside it.
fn map_fits(data: &[u8]) -> Option<()> {
    let (bytes, mut rest) = length(data)?;
    let end = rest.len().checked_sub(bytes)?;
    while rest.len() > end {
        rest = text(rest)?;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Found by fuzzing: the crate panicked on an attachment that ends inside the length field of
    /// its content.
    #[test]
    fn rejects_an_attachment_too_short_for_its_checksum() {
        let attachment = |tail: usize| [&[0; 16][..], &[0; 8], &vec![0; tail]].concat();
        assert!(are_valid(op::ATTACHMENT, &attachment(12)));
        assert!(!are_valid(op::ATTACHMENT, &attachment(11)));
        assert!(mcap::parse_record(op::ATTACHMENT, &attachment(12)).is_ok());
    }

    #[test]
    fn rejects_a_text_longer_than_its_record() {
        let schema = |length: u32| [&[1, 0][..], &length.to_le_bytes(), b"abc", &[0; 4]].concat();
        assert!(are_valid(op::SCHEMA, &schema(3)));
        assert!(!are_valid(op::SCHEMA, &schema(0x7200_0000)));
        let metadata = |length: u8| [0, 0, 0, 0, 5, 0, 0, 0, length, 0, 0, 0, b'x'];
        assert!(are_valid(op::METADATA, &metadata(1)));
        assert!(!are_valid(op::METADATA, &metadata(200)));
    }
}
