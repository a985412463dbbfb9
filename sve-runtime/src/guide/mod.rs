#![doc = include_str!("links.md")]
#![doc = include_str!("../../docs/guide/README.md")]
// The pages lie in the folder `docs/guide` of this package, so that they can be read in the
// repository. Their links are reference links, which they define at their ends as links between
// files. Markdown takes the first of two definitions, so the definitions of `links.md`, which stand
// before each page, make them links between modules.

/// Declares a module for each page.
macro_rules! pages {
    ($($(#[$condition:meta])* $page:ident)*) => {
        $(
            #[doc = include_str!("links.md")]
            #[doc = include_str!(concat!("../../docs/guide/", stringify!($page), ".md"))]
            $(#[$condition])*
            pub mod $page {}
        )*
    };
}

pages! {
    first_system
    langevin
    noise_terms
    rules
    block
    scenes
    constraints_and_rotations
    degenerate
    inputs
    time_scales
    failures
    python_module
    claims
    macro_tour
    not_planned
}

// The programs of these pages need features. The pages are always shown, and tested if the features
// are enabled.
pages! {
    #[cfg(any(not(doctest), feature = "serde"))]
    trajectories
    #[cfg(any(not(doctest), feature = "ensemble"))]
    derivatives
    #[cfg(any(not(doctest), feature = "ensemble"))]
    events
    #[cfg(any(not(doctest), all(feature = "checkpoint", feature = "plot")))]
    ensembles
    #[cfg(any(not(doctest), feature = "study"))]
    work_precision
    #[cfg(any(not(doctest), feature = "npy"))]
    python
}
