//! The attribute `#[compared]`: it lets tests compare the steps of a rule with steps that ignore the
//! structure of their equations.

use proc_macro::TokenStream;
use sve_compiler::{Settings, expand};

/// Derives all that `#[variational]` derives. Derives each rule `R` a second time without its
/// structure, for the rule `Unstructured<R>`.
#[proc_macro_attribute]
pub fn compared(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        unstructured: true,
        ..Settings::default()
    };
    expand(&attribute.into(), &item.into(), settings).into()
}
