//! Signs of life: every process of a run counts up a word of its own while it makes progress, so
//! that the launcher sees which one hangs. The counts of its deadlines stand beside it, so that they
//! survive its death.

use super::layout::DEADLINE_WORDS;
use super::page::WakePage;
use super::sync::{AtomicI64, AtomicU32, Ordering};

/// A process of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Member {
    /// The plant.
    Plant,
    /// The agent of a robot.
    Agent(usize),
    /// The recorder.
    Recorder,
}

impl WakePage {
    /// Shows that the process lives and makes progress.
    pub fn beat(&self, member: Member) {
        let beats = self.beats_of(member);
        // Only this process writes the word.
        beats.store(
            beats.load(Ordering::Relaxed).wrapping_add(1),
            Ordering::Relaxed,
        );
    }

    /// How often the process has shown that it lives; wraps around.
    pub fn beats(&self, member: Member) -> u32 {
        self.beats_of(member).load(Ordering::Relaxed)
    }

    fn beats_of(&self, member: Member) -> &AtomicU32 {
        match member {
            Member::Plant => &self.header().plant.0.beats,
            Member::Agent(robot) => &self.mapping.slot(robot).signs.beats,
            Member::Recorder => &self.header().recorder.0.beats,
        }
    }

    /// Publishes the deadline counts of a process on the wall clock, one row for each of its loops.
    pub fn publish_deadlines(&self, member: Member, loops: &[[i64; DEADLINE_WORDS]]) {
        for (words, values) in self.deadlines_of(member).iter().zip(loops) {
            for (word, &value) in words.iter().zip(values) {
                word.store(value, Ordering::Relaxed);
            }
        }
    }

    /// The deadline counts that a process published last. Those of a process that still runs may be
    /// of two ticks.
    pub fn deadlines(&self, member: Member) -> Vec<[i64; DEADLINE_WORDS]> {
        let load = |words: &[AtomicI64; DEADLINE_WORDS]| {
            words.each_ref().map(|word| word.load(Ordering::Relaxed))
        };
        self.deadlines_of(member).iter().map(load).collect()
    }

    fn deadlines_of(&self, member: Member) -> &[[AtomicI64; DEADLINE_WORDS]] {
        match member {
            Member::Plant => &self.header().plant.0.deadlines,
            Member::Agent(robot) => &self.mapping.slot(robot).signs.deadlines,
            Member::Recorder => &self.header().recorder.0.deadlines,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_process_has_signs_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let page = WakePage::create(&folder.path().join("wake_page"), 2).unwrap();
        let members = [
            Member::Plant,
            Member::Recorder,
            Member::Agent(0),
            Member::Agent(1),
        ];
        for (beats, &member) in (1..).zip(&members) {
            (0..beats).for_each(|_| page.beat(member));
            page.publish_deadlines(member, &[[i64::from(beats); 4]; 2]);
        }
        for (beats, &member) in (1..).zip(&members) {
            assert_eq!(page.beats(member), beats);
            let deadlines = page.deadlines(member);
            assert!(
                deadlines
                    .iter()
                    .all(|&counts| counts == [i64::from(beats); 4])
            );
        }
        assert_eq!(
            members.map(|member| page.deadlines(member).len()),
            [1, 0, 2, 2]
        );
    }
}
