//! Questions answered by running: the paper's own experiments against its printed numbers, and
//! what communication delay does to a platoon (Eq. 13 and 14).

pub mod delay;
pub mod reproduce;

use slipstream_launch::{RunError, Unusable};

/// Why a study could not be done.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// What was asked for cannot be used.
    #[error(transparent)]
    Unusable(#[from] Unusable),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A figure could not be drawn.
    #[error(transparent)]
    Picture(#[from] slipstream_report::PictureError),
}
