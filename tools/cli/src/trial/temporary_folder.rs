//! The temporary folder of a trial.

use slipstream_bag::output::OutputFolder;

use crate::exit::Error;

/// A folder that is removed at the end.
pub(super) fn temporary_folder() -> Result<OutputFolder, Error> {
    let name = format!("slipstream-trial-{}", std::process::id());
    Ok(OutputFolder::create(&std::env::temp_dir().join(name))?)
}
