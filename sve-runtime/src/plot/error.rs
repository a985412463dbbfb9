//! Errors of pictures.

use core::fmt;
use std::error::Error;

/// A picture that could not be drawn or written.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// A figure that cannot be drawn, such as one with an axis of no length.
    #[error("the figure cannot be drawn: {0}")]
    Drawing(String),
    /// Two series of a panel that some readers cannot distinguish.
    #[error(
        "“{panel}”: {first} and {second} differ by colours alone that some readers cannot tell apart; give them different symbols, dashes or widths"
    )]
    Indistinct {
        /// Title of the panel.
        panel: String,
        /// Name of a series.
        first: String,
        /// Name of the other series.
        second: String,
    },
    /// A file that could not be written.
    #[error(transparent)]
    File(#[from] std::io::Error),
}

impl PlotError {
    /// Converts an error of the drawing library, whose type depends on the format.
    pub(super) fn drawing(error: impl Into<Box<dyn Error>>) -> Self {
        Self::Drawing(error.into().to_string())
    }
}

/// Prints the message: `main` prints an error that it returns in this form.
impl fmt::Debug for PlotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
