//! Implementations of a scene without bodies, which are emitted after an error so that uses of the
//! system give no further errors.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::Type;

use super::super::attributes;
use super::system::{implementation, kind, reference};

/// Implementations without bodies, for a configuration of these entries and for some types of rules
/// with their plan. A reference to a type that holds inputs is no system.
pub(in super::super) fn placeholders(
    [private, runtime]: [&TokenStream; 2],
    (self_ty, entry): (&Type, TokenStream),
    rules: &[TokenStream],
    plan: &TokenStream,
    has_inputs: bool,
) -> TokenStream {
    let attributes = attributes();
    let fail = quote!(::core::unreachable!("the macro reported an error"));
    let numbers = quote!(::core::mem::size_of::<#entry>() / ::core::mem::size_of::<f64>());
    let row = quote!([f64; #numbers]);
    let result = |ok: TokenStream, error: &str| {
        let error = super::super::ident(error);
        quote!(::core::result::Result<#ok, #private::scene::#error>)
    };
    let (checked, number) = (
        result(quote!(()), "IndexError"),
        result(quote!(f64), "IndexError"),
    );
    let (count, visited) = (
        result(quote!(usize), "IndexError"),
        result(quote!(()), "Stop"),
    );
    let own = kind(private, &entry, &quote!(Self));
    let reference = (!has_inputs).then(|| reference(private, &entry, self_ty));
    let zero = Literal::usize_unsuffixed(0);
    let rules = rules.iter();
    let rules = rules.map(|rule| implementation([private, runtime], self_ty, [rule, plan, &fail]));
    quote! {
        #attributes
        impl #private::AnySystem for #self_ty {
            #own
            const NAMES: #private::Names =
                #private::Names { parameters: &[], coordinates: &[], momenta: &[] };
            const FORMULAS_HASH: u64 = 0;
            fn target(&self) -> &Self { self }
            fn visit_parameters(&self, _: &mut dyn ::core::ops::FnMut(f64)) {}
        }
        #reference
        #attributes
        impl #private::Separable for #self_ty {}
        #attributes
        impl #private::QuadraticKineticEnergy for #self_ty {}
        #attributes
        impl #private::scene::Contributions<#private::scene::Impulses> for #self_ty {
            type Numbers = #row;
            type Counts = #private::scene::Counts<#zero, #zero, #zero>;
            fn node(&self, _: f64, _: f64, _: &[f64], _: &impl #private::scene::Reads<#row>) -> #row { #fail }
            fn contribution(&self, _: usize, _: f64, _: f64, _: &[f64], _: &#private::scene::Streams<'_, #row>, _: &mut [#row]) { #fail }
            fn nest(&self, _: usize, _: f64, _: f64, _: &[f64], _: &[#row], _: &mut [#row]) -> #checked { #fail }
        }
        #attributes
        impl #private::scene::Scene for #self_ty {
            type Row = #row;
            const LOOPS: &'static [#private::scene::Loop] = &[];
            const TERMS: &'static [#private::scene::Term] = &[];
            const PAIRS: &'static [#private::scene::Pair] = &[];
            const NODE_PAIRS: usize = 0;
            const READS_TIME: bool = false;
            fn instances(&self, _: usize, _: usize, _: &mut #private::scene::Instances) -> #visited { #fail }
            fn masses(&self, _: usize, _: &mut [#row]) -> #checked { #fail }
            fn lagrangian(&self, _: f64, _: &[#row], _: &[#row]) -> #number { #fail }
            fn processes(&self, _: usize) -> #count { #fail }
        }
        #(#rules)*
    }
}
