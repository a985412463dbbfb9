//! The attribute `#[compared]`, with which tests compare steps with steps that are derived without looking for their structure.

use proc_macro::TokenStream;
use sve_compiler::{Settings, expand};

/// Derives what `#[variational]` derives, and each rule `R` once more without its structure, as the rule `Unstructured<R>`.
#[proc_macro_attribute]
pub fn compared(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        unstructured: true,
        ..Settings::default()
    };
    expand(&attribute.into(), &item.into(), settings).into()
}
