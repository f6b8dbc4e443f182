//! Frames of a robot's bridge.

use slipstream_live::source::frame::{Frame, binary, text};

/// A frame as text, and the same bytes as a binary one.
pub(crate) fn frame(bytes: &[u8]) {
    if let Ok(Frame::Message { data, .. }) = binary(bytes) {
        assert_eq!(data.len() + 13, bytes.len(), "all bytes after the head");
    }
    match text(&String::from_utf8_lossy(bytes)) {
        Ok(Frame::Message { .. }) => panic!("no text is a message"),
        Ok(_) => {}
        Err(garbled) => assert!(!garbled.in_words().is_empty()),
    }
}
