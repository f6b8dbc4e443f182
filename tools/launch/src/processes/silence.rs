//! Detection of processes that hang: they show no sign of life for too long.

use std::time::{Duration, Instant};

/// How long a process has been silent.
///
/// Time counts only while the launcher looks: on a machine that stood still, nobody was silent.
#[derive(Debug)]
pub(super) struct Silence {
    beats: u32,
    silent: Duration,
    looked: Instant,
}

/// Longest time that counts between two looks.
const LOOK_INTERVAL: Duration = Duration::from_millis(200);

impl Silence {
    /// The silence of a process that starts at `now`.
    pub(super) fn new(now: Instant) -> Self {
        Self {
            beats: 0,
            silent: Duration::ZERO,
            looked: now,
        }
    }

    /// Looks at the signs of life at `now`: their count. Returns how long the process has been
    /// silent.
    pub(super) fn look(&mut self, beats: u32, now: Instant) -> Duration {
        let passed = now.duration_since(self.looked).min(LOOK_INTERVAL);
        self.looked = now;
        self.silent = if beats == self.beats {
            self.silent + passed
        } else {
            Duration::ZERO
        };
        self.beats = beats;
        self.silent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silence_grows_until_the_next_sign_of_life() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut silence = Silence::new(start);
        assert_eq!(silence.look(1, at(100)), Duration::ZERO);
        assert_eq!(silence.look(1, at(200)), Duration::from_millis(100));
        assert_eq!(silence.look(1, at(300)), Duration::from_millis(200));
        assert_eq!(silence.look(2, at(400)), Duration::ZERO);
    }

    #[test]
    fn a_machine_that_stood_still_makes_nobody_silent() {
        let start = Instant::now();
        let mut silence = Silence::new(start);
        silence.look(1, start);
        let silent = silence.look(1, start + Duration::from_secs(3600));
        assert_eq!(silent, LOOK_INTERVAL);
    }
}
