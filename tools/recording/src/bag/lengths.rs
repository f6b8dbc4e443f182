//! Whether the lengths inside a record fit into it.
//!
//! The `mcap` crate makes room for as much as a text's length claims (up to 4 GiB) before it looks
//! for the text, and takes an attachment's last twelve bytes for granted. A damaged length must do
//! no harm: it is looked at here first.

use mcap::records::op;

/// Whether every text of the record ends inside it. Records without texts always fit.
pub(crate) fn fit(opcode: u8, data: &[u8]) -> bool {
    let (skip, texts, map) = match opcode {
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::ATTACHMENT => (16, 2, false),
        op::METADATA => (0, 1, true),
        op::CHUNK => (28, 1, false),
        _ => return true,
    };
    let after = data
        .get(skip..)
        .and_then(|rest| (0..texts).try_fold(rest, |rest, _| text(rest)));
    match after {
        // The content's length and its checksum.
        Some(rest) if opcode == op::ATTACHMENT => rest.len() >= 12,
        Some(rest) if map => map_fits(rest).is_some(),
        Some(_) => true,
        None => false,
    }
}

/// What follows a length of four bytes.
fn length(data: &[u8]) -> Option<(usize, &[u8])> {
    let (length, rest) = data.split_first_chunk()?;
    Some((usize::try_from(u32::from_le_bytes(*length)).ok()?, rest))
}

/// What follows a text.
fn text(data: &[u8]) -> Option<&[u8]> {
    let (length, rest) = length(data)?;
    rest.get(length..)
}

/// A map has its length in bytes, then texts.
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

    /// Found by fuzzing: the crate panicked on an attachment that ends within its content's length.
    #[test]
    fn an_attachment_without_room_for_its_checksum_does_not_fit() {
        let attachment = |tail: usize| [&[0; 16][..], &[0; 8], &vec![0; tail]].concat();
        assert!(fit(op::ATTACHMENT, &attachment(12)));
        assert!(!fit(op::ATTACHMENT, &attachment(11)));
        assert!(mcap::parse_record(op::ATTACHMENT, &attachment(12)).is_ok());
    }

    #[test]
    fn a_text_longer_than_its_record_does_not_fit() {
        let schema = |length: u32| [&[1, 0][..], &length.to_le_bytes(), b"abc", &[0; 4]].concat();
        assert!(fit(op::SCHEMA, &schema(3)));
        assert!(!fit(op::SCHEMA, &schema(0x7200_0000)));
        let metadata = |length: u8| [0, 0, 0, 0, 5, 0, 0, 0, length, 0, 0, 0, b'x'];
        assert!(fit(op::METADATA, &metadata(1)));
        assert!(!fit(op::METADATA, &metadata(200)));
    }
}
