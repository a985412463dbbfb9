//! An inherent function for the momentum of each symmetry.

use proc_macro2::TokenStream;
use quote::quote;

use super::super::momenta::doc;
use super::super::{attributes, momentum_name, verbatim};
use super::loops::Loops;
use super::system::Context;
use super::walk::{Action, Leaf, Walk};

impl Context<'_> {
    /// The functions of the momenta.
    pub(super) fn momenta(&self) -> TokenStream {
        let (derived, formulas, private) = (self.derived, self.formulas, self.formulas.private);
        if derived.momenta.is_empty() {
            return TokenStream::new();
        }
        let (self_ty, site, attributes) = (self.user_ty(), self.site(), attributes());
        let symmetries = self.block.symmetries.iter().zip(&derived.momenta);
        let functions = symmetries.map(|(part, momentum)| {
            let (visibility, function) = (&part.item.vis, momentum_name(&part.name));
            let (name, sums) = (&momentum.name, &momentum.sums);
            let doc = doc(
                name,
                Some(self.texts.momentum(name)),
                true,
                momentum.evidence,
            );
            let mut count = TokenStream::new();
            let entries = Loops { derived, formulas };
            let entries = sums
                .first()
                .and_then(|sum| entries.rounds(name, *sum, &mut count));
            let leaves = momentum.summands.iter().map(|summand| Leaf {
                sum: summand.sum,
                values: vec![summand.value],
                conditions: Vec::new(),
                action: Action::AddValue,
            });
            let mut walk = Walk::new(derived, formulas, name, leaves.collect());
            let loops = sums.iter().map(|sum| walk.root(Some(*sum)));
            let name = verbatim(name);
            quote! {
                #[doc = #doc]
                ///
                /// # Errors
                /// `StepError::Length` if the generator has not an entry for each site, or if there
                /// are not as many momenta, and `StepError::Index`.
                #visibility fn #function(
                    &self,
                    state: &#private::State<::std::vec::Vec<#site>>,
                ) -> ::core::result::Result<f64, #private::StepError> {
                    let entries = |n: usize| { #count ::core::result::Result::Ok(#entries) };
                    #private::scene::momentum(state, #name, entries, |n, time, q, p| {
                        let mut value = #private::scene::PartialSums::default();
                        #({ #loops })*
                        ::core::result::Result::Ok(value)
                    })
                }
            }
        });
        quote! {
            #attributes
            #[allow(dead_code)]
            impl #self_ty {
                #(#functions)*
            }
        }
    }
}
