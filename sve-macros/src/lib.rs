//! placeholder
use proc_macro::TokenStream;
/// placeholder
#[proc_macro_attribute]
pub fn variational(_attribute: TokenStream, item: TokenStream) -> TokenStream {
    item
}
