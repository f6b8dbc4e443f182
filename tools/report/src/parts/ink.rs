//! What a mark shows; its colour and stroke follow from that alone.

/// What a mark shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// The model as it was given.
    Before,
    /// The model with what was found, estimates.
    After,
    /// What was measured.
    Measured,
    /// Something beside which others are seen.
    Context,
    /// The same, dashed.
    ContextDashed,
    /// What nothing explains.
    Disturbance,
    /// Time spent waiting.
    Wait,
}

impl Ink {
    /// Class of a stroke in `style.css`.
    pub(super) fn stroke(self) -> &'static str {
        match self {
            Self::Before => "bf",
            Self::After => "af",
            Self::Measured => "rf",
            Self::Context => "cx",
            Self::ContextDashed => "cx da",
            Self::Disturbance => "ds",
            Self::Wait => "wt",
        }
    }

    /// Class of words in that colour.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Before => "cb",
            Self::After => "ca",
            Self::Measured => "cr",
            Self::Context | Self::ContextDashed => "cm",
            Self::Disturbance => "cd",
            Self::Wait => "cw",
        }
    }
}
