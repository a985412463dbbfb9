//! The settings of an expansion.

/// The settings of an expansion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// True if steps of many states at once are derived, too, for ensembles.
    pub lanes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { lanes: true }
    }
}
