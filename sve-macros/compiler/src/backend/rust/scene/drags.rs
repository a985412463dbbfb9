//! Forces and noises that act in drifts, since they depend on velocities or momenta: loops as they
//! are written.

use proc_macro2::TokenStream;
use quote::quote;

use super::super::ident;
use super::loops::Loops;
use crate::scene::Term;

impl Loops<'_> {
    /// True if there are such forces and noises.
    pub(super) fn has_in_drifts(&self) -> Option<TokenStream> {
        let has_drags = !self.derived.drags.is_empty();
        let has_h1 = self.derived.h1.iter().any(|terms| !terms.is_empty());
        (has_drags || has_h1).then(|| {
            quote! {
                const HAS_DRAGS: bool = #has_drags;
                const HAS_H1: bool = #has_h1;
            }
        })
    }

    /// The parts of drifts, as far as there are any: the impulses of forces of velocities, and the
    /// impulses and displacements of all H₁.
    pub(super) fn in_drifts(&self) -> TokenStream {
        let private = self.formulas.private;
        let drags = &self.derived.drags;
        let [kicks, shifts] = &self.derived.h1;
        let parts = [
            ("Drags", "v", drags),
            ("Kicks", "p", kicks),
            ("Shifts", "p", shifts),
        ];
        let parts = parts.into_iter().filter(|part| !part.2.is_empty());
        let arms: Vec<_> = parts.map(|part| self.added(part)).collect();
        if arms.is_empty() {
            return TokenStream::new();
        }
        quote! {
            fn in_drift(
                &self,
                part: #private::scene::InDrift,
                h: f64,
                time: f64,
                dw: &[f64],
                q: &[Self::Numbers],
                of: &[Self::Numbers],
                to: &mut [Self::Numbers],
            ) -> ::core::result::Result<(), #private::scene::IndexError> {
                let n = q.len();
                let (to, of) = (&mut to[..n], &of[..n]);
                match part {
                    #(#arms)*
                    // a part that the scene does not have
                    #[allow(unreachable_patterns)]
                    _ => {}
                }
                ::core::result::Result::Ok(())
            }
        }
    }

    /// An arm that adds the values of terms to sites. It reads velocities or momenta, `of`.
    fn added(&self, (part, of, terms): (&str, &str, &Vec<Term>)) -> TokenStream {
        let private = self.formulas.private;
        let (part, of) = (ident(part), ident(of));
        let loops = (0..self.derived.roots.len()).map(|root| {
            let of_root: Vec<&Term> = terms.iter().filter(|term| term.root == root).collect();
            let each = of_root.iter().find_map(|term| term.increment);
            let offset = each.map(|each| self.offset(each));
            let leaves = of_root.into_iter().map(|term| self.impulses(term));
            let loops = self.loops(root, leaves.collect());
            quote!(#offset #loops)
        });
        quote! {
            #private::scene::InDrift::#part => {
                let #of = of;
                #({ #loops })*
            }
        }
    }
}
