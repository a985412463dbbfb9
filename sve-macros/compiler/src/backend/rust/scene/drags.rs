//! Forces and noises that act in drifts, since they depend on velocities or momenta: loops as they
//! are written.

use proc_macro2::TokenStream;
use quote::quote;

use super::super::ident;
use super::loops::Loops;
use crate::scene::Term;

impl Loops<'_> {
    /// The impulses of forces of velocities, and the impulses and displacements of all H₁, as far as
    /// there are any.
    pub(super) fn in_drifts(&self) -> TokenStream {
        let drags = &self.derived.drags;
        let [kicks, shifts] = &self.derived.h1;
        let drags = (!drags.is_empty()).then(|| {
            let drags = self.added("drags", "v", drags);
            quote!(const HAS_DRAGS: bool = true; #drags)
        });
        let h1 = (!kicks.is_empty() || !shifts.is_empty()).then(|| {
            let kicks = self.added("h1_kicks", "p", kicks);
            let shifts = self.added("h1_shifts", "p", shifts);
            quote!(const HAS_H1: bool = true; #kicks #shifts)
        });
        quote!(#drags #h1)
    }

    /// A function that adds the values of terms to sites. It reads velocities or momenta, `of`.
    fn added(&self, name: &str, of: &str, terms: &[Term]) -> TokenStream {
        let private = self.formulas.private;
        let (name, of) = (ident(name), ident(of));
        let loops = (0..self.derived.roots.len()).map(|root| {
            let of_root: Vec<&Term> = terms.iter().filter(|term| term.root == root).collect();
            let each = of_root.iter().find_map(|term| term.increment);
            let offset = each.map(|each| self.offset(each));
            let leaves = of_root.into_iter().map(|term| self.impulses(term));
            let loops = self.loops(root, leaves.collect());
            quote!(#offset #loops)
        });
        quote! {
            fn #name(
                &self,
                h: f64,
                time: f64,
                dw: &[f64],
                q: &[Self::Row],
                #of: &[Self::Row],
                to: &mut [Self::Row],
            ) -> ::core::result::Result<(), #private::scene::IndexError> {
                let n = q.len();
                let (to, #of) = (&mut to[..n], &#of[..n]);
                #({ #loops })*
                ::core::result::Result::Ok(())
            }
        }
    }
}
