//! Tests of the pipeline as a whole.

mod absent;
mod costs;
mod growth;
mod large_input;
mod limits;
mod mistakes;
mod readable;
mod robustness;
mod scheme;
mod zero;

use proc_macro2::TokenStream;

use crate::Settings;

/// The expansion with steps in lanes.
pub(crate) fn expand(attribute: &TokenStream, item: &TokenStream) -> TokenStream {
    crate::expand(attribute, item, Settings::default())
}
