//! `impl Scene`: the loops of a scene.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};
use syn::Type;

use super::super::code::total;
use super::super::function::Formulas;
use super::super::{attributes, ident, verbatim};
use super::kinetic::kinetic;
use super::nodes::{contribution, node};
use super::tables::tables;
use super::walk::{Action, Leaf, Walk};
use crate::model::scene::{Each, Head, SumId};
use crate::scene::{Coefficient, Derived, Kinetic, Root, Summand, Term};

/// `is_implicit` is true if a rule of the block joins all sites.
pub(super) fn scene(
    derived: &Derived,
    is_implicit: bool,
    self_ty: &Type,
    formulas: Formulas<'_>,
) -> TokenStream {
    let (private, attributes) = (formulas.private, attributes());
    let size = Literal::usize_unsuffixed(derived.scene.row.len());
    let tables = tables(derived, formulas);
    let impulses = contributions(derived, "Impulses", self_ty, formulas);
    let loops = Loops { derived, formulas };
    let instances = loops.instances();
    let kinetic = match &derived.kinetic {
        Kinetic::Masses(masses) => loops.components("masses", masses),
        Kinetic::Sites { terms, is_affine } => kinetic(derived, terms, *is_affine, formulas),
    };
    let has_forces = !derived.scene.forces.is_empty();
    let forces = has_forces.then(|| {
        let frictions = loops.components("frictions", &derived.frictions);
        let forces = loops.forces();
        quote!(#frictions #forces)
    });
    let has_in_drifts = loops.has_in_drifts();
    let lagrangian = loops.lagrangian();
    let processes = loops.processes();
    let midpoint = is_implicit.then(|| {
        quote! {
            fn midpoint(
                &self,
                step: #private::scene::MidpointStep<'_, Self::Row>,
            ) -> ::core::result::Result<(), #private::StepError> {
                #private::scene::midpoint(self, step)
            }
        }
    });
    quote! {
        #impulses
        #attributes
        impl #private::scene::Scene for #self_ty {
            type Row = [f64; #size];
            #tables
            #instances
            #kinetic
            #forces
            #has_in_drifts
            #midpoint
            #lagrangian
            #processes
        }
    }
}

/// The values that the loops add to each node: the impulses of a scene, or the bounds of their
/// slopes.
pub(super) fn contributions(
    derived: &Derived,
    what: &str,
    self_ty: &Type,
    formulas: Formulas<'_>,
) -> TokenStream {
    let (private, attributes, what) = (formulas.private, attributes(), ident(what));
    let size = Literal::usize_unsuffixed(derived.scene.row.len());
    let counts = derived.node.counts.map(Literal::usize_unsuffixed);
    let (node, contribution) = (node(derived, formulas), contribution(derived, formulas));
    let loops = Loops { derived, formulas };
    let (nest, totals, in_drifts) = (loops.nest(), loops.totals(), loops.in_drifts());
    quote! {
        #attributes
        impl #private::scene::Contributions<#private::scene::#what> for #self_ty {
            type Numbers = [f64; #size];
            type Counts = #private::scene::Counts<#(#counts),*>;
            #node
            #contribution
            #nest
            #totals
            #in_drifts
        }
    }
}

/// The functions with loops as they are written.
pub(super) struct Loops<'a> {
    pub(super) derived: &'a Derived,
    pub(super) formulas: Formulas<'a>,
}

impl Loops<'_> {
    /// The loops of a root around summands.
    pub(super) fn loops(&self, root: usize, leaves: Vec<Leaf>) -> TokenStream {
        let Root { sum, function, .. } = &self.derived.roots[root];
        Walk::new(self.derived, self.formulas, function, leaves).root(*sum)
    }

    /// A `match` over the roots that `wanted` accepts, with loops around the summands of terms.
    fn by_root(&self, wanted: impl Fn(&Root) -> bool, leaf: impl Fn(usize) -> Leaf) -> TokenStream {
        let arms = self.derived.roots.iter().enumerate();
        let arms = arms
            .filter(|(_, root)| wanted(root))
            .filter_map(|(root, _)| {
                let terms = self.derived.terms.iter().enumerate();
                let terms: Vec<usize> = terms.filter(|t| t.1.root == root).map(|t| t.0).collect();
                if terms.is_empty() {
                    return None;
                }
                let each = terms
                    .iter()
                    .find_map(|&term| self.derived.terms[term].increment);
                let offset = each.map(|each| self.offset(each));
                let body = self.loops(root, terms.into_iter().map(&leaf).collect());
                let root = Literal::usize_unsuffixed(root);
                Some(quote!(#root => { #offset #body }))
            });
        quote! {
            match number {
                #(#arms)*
                _ => {}
            }
            ::core::result::Result::Ok(())
        }
    }

    /// The number of the first process of a function that returns a `Vec`.
    pub(super) fn offset(&self, each: usize) -> TokenStream {
        let component = self.derived.each[each].component;
        let (count, name) = (self.count(each - component), format_ident!("offset_{each}"));
        let component = Literal::i64_suffixed(component as i64);
        quote!(let #name: i64 = { #count } + #component;)
    }

    /// The number of the listed processes and of those of the first components of functions that
    /// return a `Vec`.
    fn count(&self, components: usize) -> TokenStream {
        let listed = Literal::i64_suffixed(self.derived.listed as i64);
        let mut code = quote!(let mut count = #listed;);
        for &Each { sum, .. } in &self.derived.each[..components] {
            let mut roots = self.derived.roots.iter();
            let function = roots.find(|root| root.sum == Some(sum));
            let function = function.map_or("", |root| &root.function);
            let count = self.rounds(function, sum, &mut code);
            code.extend(quote!(count += #count;));
        }
        quote!(#code count)
    }

    fn instances(&self) -> TokenStream {
        let private = self.formulas.private;
        let body = self.by_root(
            |root| root.is_stream,
            |term| Leaf {
                sum: self.derived.terms[term].sum,
                values: Vec::new(),
                conditions: Vec::new(),
                action: Action::Visit(term),
            },
        );
        quote! {
            fn instances(
                &self,
                number: usize,
                n: usize,
                to: &mut #private::scene::Instances,
            ) -> ::core::result::Result<(), #private::scene::Stop> {
                #body
            }
        }
    }

    fn nest(&self) -> TokenStream {
        let private = self.formulas.private;
        let body = self.by_root(|_| true, |term| self.impulses(&self.derived.terms[term]));
        quote! {
            #[inline(always)]
            fn nest(
                &self,
                number: usize,
                h: f64,
                time: f64,
                dw: &[f64],
                q: &[Self::Numbers],
                to: &mut [Self::Numbers],
            ) -> ::core::result::Result<(), #private::scene::IndexError> {
                let n = q.len();
                let to = &mut to[..n];
                #body
            }
        }
    }

    /// The impulses of a term, added to its sites.
    pub(super) fn impulses(&self, term: &Term) -> Leaf {
        let receivers: Vec<usize> = term.receivers(self.formulas.arena).collect();
        let impulses = receivers.iter().flat_map(|&site| &term.impulses[site]);
        let conditions = receivers.iter().filter_map(|&at| term.conditions.get(at));
        Leaf {
            sum: term.sum,
            values: impulses.copied().collect(),
            conditions: conditions.flatten().copied().collect(),
            action: Action::AddRows(receivers.iter().map(|&at| term.sites[at]).collect()),
        }
    }

    /// A function that adds a number of each component of each site.
    fn components(&self, name: &str, components: &[Coefficient]) -> TokenStream {
        let (private, name) = (self.formulas.private, ident(name));
        let roots = 0..self.derived.roots.len();
        let loops = roots.map(|root| {
            let of_root = components.iter().filter(|of| of.root == root);
            let leaves = of_root.map(|of| Leaf {
                sum: of.sum,
                values: vec![of.value],
                conditions: Vec::new(),
                action: Action::AddComponent(of.site, of.component),
            });
            self.loops(root, leaves.collect())
        });
        quote! {
            fn #name(
                &self,
                n: usize,
                to: &mut [Self::Row],
            ) -> ::core::result::Result<(), #private::scene::IndexError> {
                let to = &mut to[..n];
                #({ #loops })*
                ::core::result::Result::Ok(())
            }
        }
    }

    /// The names of the forces, each with the number of its entries.
    fn forces(&self) -> TokenStream {
        let private = self.formulas.private;
        let forces = self.derived.scene.forces.iter().filter_map(|force| {
            let sum = force.components.iter().flatten().next()?;
            let mut code = TokenStream::new();
            let count = self.rounds(&force.name, *sum, &mut code)?;
            let name = verbatim(&force.name);
            Some(quote!({ #code visit(#name, #count); }))
        });
        quote! {
            fn forces(
                &self,
                n: usize,
                visit: &mut dyn ::core::ops::FnMut(&'static str, i64),
            ) -> ::core::result::Result<(), #private::scene::IndexError> {
                #(#forces)*
                ::core::result::Result::Ok(())
            }
        }
    }

    /// The number of rounds of a loop, after `code` that finds its bounds.
    pub(super) fn rounds(
        &self,
        function: &str,
        sum: SumId,
        code: &mut TokenStream,
    ) -> Option<TokenStream> {
        let mut walk = Walk::new(self.derived, self.formulas, function, Vec::new());
        let Head::For { from, to, .. } = self.derived.scene.sums[sum.0].head else {
            return None;
        };
        let [from, to] = [from, to].map(|bound| walk.integer(bound, code));
        Some(quote!(i64::max(0, i64::saturating_sub(#to, #from))))
    }

    /// The totals, if there are any.
    fn totals(&self) -> Option<TokenStream> {
        let private = self.formulas.private;
        let count = self.derived.totals.len();
        let totals = self.derived.totals.iter().map(|of| {
            let place = total(of.number);
            let loops = self.values(&of.summands);
            quote! {
                let total = {
                    let mut value = #private::scene::PartialSums::default();
                    #loops
                    value.total()
                };
                #place = total;
            }
        });
        (count > 0).then(|| {
            let count = Literal::usize_unsuffixed(count);
            quote! {
                const TOTALS: usize = #count;
                fn totals(
                    &self,
                    time: f64,
                    q: &[Self::Numbers],
                    dw: &mut [f64],
                ) -> ::core::result::Result<(), #private::scene::IndexError> {
                    let n = q.len();
                    #(#totals)*
                    ::core::result::Result::Ok(())
                }
            }
        })
    }

    /// The loops that add summands to `value`.
    fn values(&self, summands: &[Summand]) -> TokenStream {
        let roots = 0..self.derived.roots.len();
        let loops = roots.map(|root| {
            let of_root = summands.iter().filter(|s| s.root == root);
            let leaves = of_root.map(Leaf::value);
            self.loops(root, leaves.collect())
        });
        quote!(#({ #loops })*)
    }

    fn lagrangian(&self) -> TokenStream {
        let private = self.formulas.private;
        let loops = self.values(&self.derived.lagrangian);
        let totals = (!self.derived.totals.is_empty()).then(|| {
            let count = self.derived.listed + self.derived.totals.len();
            let count = Literal::usize_unsuffixed(count);
            quote! {
                let mut dw = [0f64; #count];
                #private::scene::Contributions::<#private::scene::Impulses>::totals(
                    self, time, q, &mut dw,
                )?;
            }
        });
        quote! {
            fn lagrangian(
                &self,
                time: f64,
                q: &[Self::Row],
                v: &[Self::Row],
            ) -> ::core::result::Result<f64, #private::scene::IndexError> {
                let n = q.len();
                #totals
                let mut value = #private::scene::PartialSums::default();
                #loops
                ::core::result::Result::Ok(value.total())
            }
        }
    }

    fn processes(&self) -> TokenStream {
        let private = self.formulas.private;
        let count = self.count(self.derived.each.len());
        quote! {
            fn processes(
                &self,
                n: usize,
            ) -> ::core::result::Result<usize, #private::scene::IndexError> {
                let count: i64 = { #count };
                ::core::result::Result::Ok(count as usize)
            }
        }
    }
}
