//! Stages of a run, in their order.

/// How far a run has come. A run never returns to an earlier stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Stage {
    /// The processes are being started.
    Starting = 0,
    /// The plant has created all services.
    Services = 1,
    /// All processes are connected.
    Running = 2,
    /// The plant has made its last step.
    Over = 3,
    /// Only the recorder is left: it may close the file.
    Drained = 4,
}

impl Stage {
    /// The stage of a number; numbers that no stage has count as the last stage.
    pub(super) fn from_number(number: u32) -> Self {
        match number {
            0 => Self::Starting,
            1 => Self::Services,
            2 => Self::Running,
            3 => Self::Over,
            _ => Self::Drained,
        }
    }
}
