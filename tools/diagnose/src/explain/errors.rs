//! What predictions of a run score, and what is drawn of them.

use crate::judge::Score;
use crate::predict::drawn::Drawn;

/// What a run scores, and how its predictions look: times (s) without the origin of the run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Errors {
    pub(crate) score: Score,
    /// Begin, end (s) and score of each window.
    pub(crate) windows: Vec<([f64; 2], Score)>,
    pub(crate) drawn: Drawn,
}

impl Errors {
    /// Adds a row: its stamp (s) and error, and the variances of its sensor and of all noise.
    pub(super) fn add(
        &mut self,
        (stamp_s, channel): (f64, usize),
        error: f64,
        [sensor, expected]: [f64; 2],
    ) {
        self.score.add(channel, error * error, sensor, expected);
        self.drawn.errors[channel].push((stamp_s, error));
    }

    /// Both together.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.score = self.score.and(&other.score);
        self.windows.extend(other.windows);
        self.drawn = self.drawn.and(other.drawn);
        self
    }
}
