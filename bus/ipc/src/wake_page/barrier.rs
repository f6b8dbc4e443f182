//! Barrier of the lockstep: the plant begins a round, all agents answer it, the last one wakes the
//! plant.
//!
//! One system call wakes all agents and one wakes the plant, whatever the number of robots.

use std::time::Duration;

use super::layout::NO_MORE_ROUNDS;
use super::page::{WakePage, wait_at_least};
use super::stage::Stage;
use super::sync::{Ordering, wait, wake_all};

impl WakePage {
    /// Plant: begins round `epoch`, never 0 or `u32::MAX`, and wakes all agents.
    pub fn begin_round(&self, epoch: u32) {
        let header = self.header();
        header.answers.0.store(0, Ordering::Release);
        header.epoch.0.store(epoch, Ordering::Release);
        wake_all(&header.epoch.0);
    }

    /// Plant: waits for the answers of all agents, at most for `timeout`. Returns whether all have
    /// answered.
    pub fn wait_answers(&self, timeout: Duration) -> bool {
        wait_at_least(&self.header().answers.0, self.local_agents(), timeout)
    }

    /// Plant: the first robot that has not answered round `epoch`.
    pub fn first_unanswered(&self, epoch: u32) -> Option<usize> {
        (0..self.mapping.robots()).find(|&robot| {
            let slot = self.mapping.slot(robot);
            slot.remote.load(Ordering::Acquire) == 0
                && slot.answered.load(Ordering::Acquire) != epoch
        })
    }

    /// Agent: waits for a round other than `last`, at most for `timeout`. Returns `None` if there
    /// is none in time, or if the run is over.
    pub fn wait_round(&self, last: u32, timeout: Duration) -> Option<u32> {
        let word = &self.header().epoch.0;
        if word.load(Ordering::Acquire) == last && self.stage() < Stage::Over {
            wait(word, last, timeout);
        }
        let epoch = word.load(Ordering::Acquire);
        (epoch != last && epoch != NO_MORE_ROUNDS).then_some(epoch)
    }

    /// Agent: answers round `epoch`. The last answer wakes the plant.
    pub fn answer(&self, robot: usize, epoch: u32) {
        let answers = &self.header().answers.0;
        let slot = self.mapping.slot(robot);
        slot.answered.store(epoch, Ordering::Release);
        let before = answers.fetch_add(1, Ordering::AcqRel);
        if before + 1 == self.local_agents() {
            wake_all(answers);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thousand_rounds_pass_between_two_mappings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wake_page");
        let plant = WakePage::create(&path, 2).unwrap();
        let timeout = Duration::from_secs(10);
        std::thread::scope(|scope| {
            for robot in 0..2 {
                let agent = WakePage::open(&path).unwrap();
                scope.spawn(move || {
                    let mut last = 0;
                    while agent.stage() < Stage::Over {
                        if let Some(epoch) = agent.wait_round(last, timeout) {
                            last = epoch;
                            agent.answer(robot, epoch);
                        }
                    }
                });
            }
            for epoch in 1..1000 {
                plant.begin_round(epoch);
                while !plant.wait_answers(timeout) {}
                assert_eq!(plant.first_unanswered(epoch), None);
            }
            plant.advance(Stage::Over);
        });
    }

    #[test]
    fn agents_on_other_hosts_are_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let page = WakePage::create(&folder.path().join("wake_page"), 3).unwrap();
        page.set_local(&[1]);
        assert_eq!(
            [0, 1, 2].map(|robot| page.is_local(robot)),
            [false, true, false]
        );
        page.begin_round(7);
        assert_eq!(page.first_unanswered(7), Some(1));
        page.answer(1, 7);
        assert!(page.wait_answers(Duration::from_millis(5)));
        assert_eq!(page.first_unanswered(7), None);
    }

    #[test]
    fn a_missing_answer_ends_the_wait_and_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let page = WakePage::create(&folder.path().join("wake_page"), 3).unwrap();
        page.begin_round(7);
        page.answer(0, 7);
        page.answer(2, 7);
        assert!(!page.wait_answers(Duration::from_millis(5)));
        assert_eq!(page.first_unanswered(7), Some(1));
    }
}
