//! Checkpoint of an agent, guarded by a version counter: a restarted agent continues from it.

use super::layout::CHECKPOINT_WORDS;
use super::page::WakePage;
use super::sync::Ordering;

impl WakePage {
    /// Agent: stores its checkpoint.
    pub fn store_checkpoint(&self, robot: usize, checkpoint: [u64; CHECKPOINT_WORDS]) {
        let slot = self.mapping.slot(robot);
        let writing = slot.version.fetch_or(1, Ordering::SeqCst) | 1;
        for (word, value) in slot.checkpoint.iter().zip(checkpoint) {
            word.store(value, Ordering::SeqCst);
        }
        slot.version
            .store(writing.wrapping_add(1), Ordering::SeqCst);
    }

    /// Agent: the checkpoint that an earlier agent of this robot left; `None` if there is none, if
    /// that agent died while writing it, or if it is being written.
    pub fn checkpoint(&self, robot: usize) -> Option<[u64; CHECKPOINT_WORDS]> {
        let slot = self.mapping.slot(robot);
        let version = slot.version.load(Ordering::SeqCst);
        if version == 0 || !version.is_multiple_of(2) {
            return None;
        }
        let words = slot.checkpoint.each_ref();
        let checkpoint = words.map(|word| word.load(Ordering::SeqCst));
        // Another version now: words of two checkpoints.
        (slot.version.load(Ordering::SeqCst) == version).then_some(checkpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_that_is_half_written_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let page = WakePage::create(&folder.path().join("wake_page"), 1).unwrap();
        assert_eq!(page.checkpoint(0), None);
        page.store_checkpoint(0, [1, 2, 3, 4, 5, 6]);
        assert_eq!(page.checkpoint(0), Some([1, 2, 3, 4, 5, 6]));
        let version = &page.mapping.slot(0).version;
        version.fetch_add(1, Ordering::SeqCst);
        assert_eq!(page.checkpoint(0), None);
    }
}
