//! What viewers need: where to look, and a layout.

use std::path::Path;

use slipstream_live::layout;

use crate::exit::Error;
use crate::output_file;

/// Where viewers find a run or a recording.
pub(crate) const ADDRESS: &str = "127.0.0.1:8765";

/// Where to look, in a line.
pub(crate) fn invitation(address: &str) -> String {
    format!(
        "Viewers: ws://{address}, in Foxglove by Open connection → Foxglove WebSocket. Ctrl-C ends it."
    )
}

/// Writes a layout for these robots.
pub(crate) fn write_layout(file: &Path, robots: &[&str]) -> Result<(), Error> {
    output_file::write_json(file, &layout(robots))
}
