//! Files that are attached to a recording, such as the experiment of a run and the models of its robots.

use std::collections::BTreeMap;
use std::path::Path;

use slipstream_bag::{Bag as _, BagFile, Item, Result};

/// The texts that are attached to a file of a run, by their names: `experiment.toml`, and `simulated.r1.toml` or
/// `nominal.r1.toml` of each robot.
///
/// # Errors
/// If the file cannot be read or is no bag.
pub fn attached(recording: &Path) -> Result<BTreeMap<String, String>> {
    let mut texts = BTreeMap::new();
    BagFile::open(recording)?.scan(&|_| false, &mut |item| {
        if let Item::Attachment { name, data } = item {
            let text = String::from_utf8_lossy(data).into_owned();
            texts.insert(name.to_owned(), text);
        }
        Ok(())
    })?;
    Ok(texts)
}
