//! Attributes that derive more or less than `#[variational]`, for tests:
//!
//! | attribute | steps | their derivatives | in lanes | steps without structure |
//! | --- | --- | --- | --- | --- |
//! | `#[compared]` | yes | yes | yes | yes |
//! | `#[compared_with_derivatives]` | yes | yes | yes | with their derivatives |
//! | `#[stepped]` | yes | no | no | no |
//!
//! A step without structure ignores the structure of its equations. It belongs to the rule
//! `Unstructured<R>`. Derivatives and lanes are most of the code of a large system, so a system of
//! which tests only make single steps is `#[stepped]`.

use proc_macro::TokenStream;
use sve_compiler::{Derivatives, Settings, expand};

/// Derives all that `#[variational]` derives, and steps without structure.
#[proc_macro_attribute]
pub fn compared(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        derivatives: Derivatives::OfStructuredSteps,
        unstructured: true,
        ..Settings::default()
    };
    expand(&attribute.into(), &item.into(), settings).into()
}

/// Derives all that `#[variational]` derives, and steps without structure with their derivatives.
#[proc_macro_attribute]
pub fn compared_with_derivatives(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        unstructured: true,
        ..Settings::default()
    };
    expand(&attribute.into(), &item.into(), settings).into()
}

/// Derives what `#[variational]` derives except steps in lanes and the derivatives of steps.
#[proc_macro_attribute]
pub fn stepped(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let settings = Settings {
        lanes: false,
        derivatives: Derivatives::OfNoStep,
        ..Settings::default()
    };
    expand(&attribute.into(), &item.into(), settings).into()
}
