//! The settings of an expansion.

/// The settings of an expansion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// True if steps of many states at once are derived, too, for ensembles.
    pub lanes: bool,
    /// The steps whose derivatives are derived, for tangent maps and gradients.
    pub derivatives: Derivatives,
    /// True if each rule is derived a second time without its structure. Tests and benchmarks
    /// compare the two.
    pub unstructured: bool,
}

/// The steps whose derivatives are derived. Tests that make single steps of large systems leave
/// them out, since they are most of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// All steps.
    OfAllSteps,
    /// All steps but those without structure.
    OfStructuredSteps,
    /// No step.
    OfNoStep,
}

impl Derivatives {
    /// True if the derivatives of a step are derived.
    pub(crate) fn include(self, is_unstructured: bool) -> bool {
        match self {
            Self::OfAllSteps => true,
            Self::OfStructuredSteps => !is_unstructured,
            Self::OfNoStep => false,
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            lanes: true,
            derivatives: Derivatives::OfAllSteps,
            unstructured: false,
        }
    }
}
