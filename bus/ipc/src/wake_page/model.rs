//! Model check of the page's protocols: loom tries the orders of the steps of a few threads.
//!
//!     cargo test -p slipstream-ipc --features loom --lib wake_page::model
//!
//! Of several loads of a word, loom notes only the last one as a step that a store may precede. The
//! owner of a word that others read therefore changes it by a read-modify-write.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on says so and stops"
)]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use loom::model::Builder;
use loom::sync::atomic::Ordering;
use loom::thread;

use super::layout::CHECKPOINT_WORDS;
use super::page::WakePage;
use super::stage::Stage;

/// A wait that only a wake-up ends: whoever is not woken is a deadlock.
const FOR_EVER: Duration = Duration::MAX;

/// Tries the orders with at most `preemptions` involuntary switches between threads, or all.
fn check(
    preemptions: Option<usize>,
    protocol: impl Fn(Arc<WakePage>) + Send + Sync + 'static,
    robots: usize,
) {
    let mut builder = Builder::new();
    builder.preemption_bound = preemptions;
    builder.check(move || {
        let page = WakePage::create(Path::new(""), robots).unwrap();
        protocol(Arc::new(page));
    });
}

/// An agent: answers every round until the run is over, and returns the last one.
fn agent(page: &WakePage, robot: usize, timeout: Duration) -> u32 {
    let mut last = 0;
    loop {
        if let Some(epoch) = page.wait_round(last, timeout) {
            assert_eq!(epoch, last + 1, "a round is missed");
            last = epoch;
            page.answer(robot, epoch);
        } else if page.stage() >= Stage::Over {
            return last;
        }
    }
}

/// The plant: two rounds, each of which every agent answers once.
fn plant(page: &WakePage, robots: u32, timeout: Duration) {
    for epoch in 1..=2 {
        page.begin_round(epoch);
        while !page.wait_answers(timeout) {}
        assert_eq!(page.header().answers.0.load(Ordering::SeqCst), robots);
        assert_eq!(page.first_unanswered(epoch), None);
    }
    page.advance(Stage::Over);
}

/// Two rounds of a plant and `robots` agents.
fn two_rounds(preemptions: usize, robots: usize, timeout: Duration) {
    let protocol = move |page: Arc<WakePage>| {
        let agents: Vec<_> = (0..robots)
            .map(|robot| {
                let page = Arc::clone(&page);
                thread::spawn(move || agent(&page, robot, timeout))
            })
            .collect();
        plant(&page, robots as u32, timeout);
        for agent in agents {
            assert_eq!(agent.join().unwrap(), 2, "the last round was not seen");
        }
    };
    check(Some(preemptions), protocol, robots);
}

#[test]
fn no_wake_up_of_the_barrier_is_lost_and_no_answer_counts_twice() {
    two_rounds(2, 2, FOR_EVER);
}

#[test]
fn a_wait_that_returns_early_does_no_harm() {
    two_rounds(2, 1, Duration::ZERO);
}

#[test]
fn no_agent_sleeps_on_when_the_run_is_over() {
    let protocol = |page: Arc<WakePage>| {
        let waiting = Arc::clone(&page);
        let agent = thread::spawn(move || agent(&waiting, 0, FOR_EVER));
        page.advance(Stage::Over);
        assert_eq!(agent.join().unwrap(), 0);
    };
    check(Some(4), protocol, 1);
}

#[test]
fn whoever_waits_for_a_stage_is_woken() {
    let protocol = |page: Arc<WakePage>| {
        let waiting = Arc::clone(&page);
        let process = thread::spawn(move || {
            waiting.signal_ready();
            while !waiting.wait_stage(Stage::Running, FOR_EVER) {}
        });
        while !page.wait_ready(1, FOR_EVER) {}
        page.advance(Stage::Services);
        page.advance(Stage::Running);
        process.join().unwrap();
    };
    check(Some(3), protocol, 1);
}

#[test]
fn a_checkpoint_that_is_read_while_it_is_written_is_whole_or_none() {
    let protocol = |page: Arc<WakePage>| {
        let written = Arc::clone(&page);
        let writer = thread::spawn(move || {
            written.store_checkpoint(0, [1; CHECKPOINT_WORDS]);
            written.store_checkpoint(0, [2; CHECKPOINT_WORDS]);
        });
        if let Some(words) = page.checkpoint(0) {
            assert!(words.iter().all(|&word| word == words[0]), "{words:?}");
        }
        writer.join().unwrap();
        assert_eq!(page.checkpoint(0), Some([2; CHECKPOINT_WORDS]));
    };
    check(None, protocol, 1);
}
