//! The settings of an expansion.

/// The settings of an expansion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// True if steps of many states at once are derived, too, for ensembles.
    pub lanes: bool,
    /// True if each rule is derived a second time without its structure. Tests and benchmarks
    /// compare the two.
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
