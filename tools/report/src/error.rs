//! Why a figure could not be drawn.

/// A figure could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("a figure could not be drawn: {0}")]
pub struct PictureError(String);

/// What the drawing library returns.
pub(crate) type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

impl From<DrawError> for PictureError {
    fn from(error: DrawError) -> Self {
        Self(error.to_string())
    }
}
