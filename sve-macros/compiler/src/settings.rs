//! The settings of an expansion.

/// The settings of an expansion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// True if steps of many states at once are derived, too, for ensembles.
    pub lanes: bool,
    /// Whether each rule is derived a second time without its structure, which tests and benchmarks compare with the first one.
    pub unstructured: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            lanes: true,
            unstructured: false,
        }
    }
}
