//! The files of the shards of a study or trial.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use slipstream_bus::InputError;

/// The version of a format.
#[derive(Deserialize)]
struct Format {
    format: u32,
}

/// Reads files, each with its name. `what` is what they hold, such as `a study`; `command` wrote them.
///
/// # Errors
/// A file that cannot be read or holds something else.
pub(crate) fn read<T: DeserializeOwned>(
    paths: &[PathBuf],
    what: &str,
    command: &str,
) -> Result<Vec<(String, T)>, InputError> {
    let remedy = format!("give files that `{command}` wrote");
    let one = |path: &PathBuf| {
        let place = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| {
            InputError::new(&place, format!("cannot be read: {error}"), &remedy)
        })?;
        let not_one = |error: serde_json::Error| {
            let place = format!("{place}:{}", error.line());
            InputError::new(place, format!("is not {what}: {error}"), &remedy)
        };
        let answer = serde_json::from_str(&text).map_err(not_one)?;
        let Format { format } = serde_json::from_str(&text).map_err(not_one)?;
        if format != 1 {
            let problem = format!("format is {format}");
            return Err(InputError::new(
                place,
                problem,
                "this program reads format 1",
            ));
        }
        Ok((place, answer))
    };
    paths.iter().map(one).collect()
}

/// The answer in a file, if it is the one that is asked for and need not be computed again.
pub(crate) fn kept<T: DeserializeOwned>(
    path: Option<&Path>,
    is_it: impl Fn(&T) -> bool,
) -> Option<T> {
    let text = std::fs::read_to_string(path?).ok()?;
    serde_json::from_str(&text).ok().filter(is_it)
}
