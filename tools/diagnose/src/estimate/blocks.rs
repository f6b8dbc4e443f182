//! Blocks of time: the pieces whose spread says how well an estimate is known.

/// Shortest block (s), and how many a run has.
const BLOCK_S: f64 = 2.5;
const BLOCKS: [f64; 2] = [10.0, 16.0];

/// The blocks of one run among those of all runs.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Blocks {
    /// First and last row that is compared (s).
    pub(crate) span_s: [f64; 2],
    /// Number of the first block among all.
    pub(crate) first: usize,
    pub(crate) count: usize,
}

impl Blocks {
    pub(crate) fn new(span_s: [f64; 2], first: usize) -> Self {
        let [from_s, to_s] = span_s;
        Self {
            span_s,
            first,
            count: ((to_s - from_s) / BLOCK_S).clamp(BLOCKS[0], BLOCKS[1]) as usize,
        }
    }

    /// Block of a time within this run.
    pub(crate) fn of(&self, time_s: f64) -> usize {
        let [from_s, to_s] = self.span_s;
        let share = (time_s - from_s) / (to_s - from_s).max(1e-9);
        ((share * self.count as f64) as usize).min(self.count - 1)
    }

    /// Middle of a block within this run (s).
    pub(crate) fn middle_s(&self, block: usize) -> f64 {
        let [from_s, to_s] = self.span_s;
        from_s + (to_s - from_s) * (block as f64 + 0.5) / self.count as f64
    }

    pub(crate) fn end(&self) -> usize {
        self.first + self.count
    }
}

/// Number of blocks of all runs.
pub(crate) fn total(mut runs: impl DoubleEndedIterator<Item = Blocks>) -> usize {
    runs.next_back().map_or(0, |last| last.end())
}

/// Run to which each block belongs.
pub(crate) fn run_of(runs: impl Iterator<Item = Blocks>) -> Vec<usize> {
    let runs = runs.enumerate();
    runs.flat_map(|(run, blocks)| vec![run; blocks.count])
        .collect()
}
