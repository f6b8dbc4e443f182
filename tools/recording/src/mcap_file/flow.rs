//! Messages of slipstream's own files, as they come and without an end.

use std::path::Path;

use slipstream_bag::{Item, Result, VisitResult};

use super::reader::{Loader, describe};
use crate::rows::{Disk, SpooledRecording};

/// The streams of a file that does not end.
#[derive(Default)]
pub(crate) struct OwnFlow(Loader);

impl OwnFlow {
    /// Takes an item.
    pub(crate) fn take(&mut self, item: Item<'_>) -> VisitResult {
        self.0.visit(item)
    }

    /// The rows so far, with the description so far.
    ///
    /// # Errors
    /// If the description is invalid.
    pub(crate) fn pass_on(
        &mut self,
        path: &Path,
        notes: &mut Vec<String>,
    ) -> Result<SpooledRecording> {
        let Self(loader) = self;
        notes.append(&mut loader.warnings);
        let description = describe(loader, path, notes)?;
        let next = Disk::default();
        let disk = std::mem::replace(&mut loader.disk, next.clone());
        let mut recording = SpooledRecording::new(description, disk);
        for stream in &mut loader.streams {
            stream.pass_on(&mut recording, notes, &next);
        }
        if let Some(links) = &mut loader.links {
            let (spool, with_velocity) = links.pass_on(notes, &next);
            recording.store_links(spool, with_velocity);
        }
        if let Some(trips) = &mut loader.round_trips {
            recording.store_round_trips(trips.pass_on(notes, &next));
        }
        Ok(recording)
    }
}
