//! `impl AnySystem` and `impl Rule` of a scene.

use std::hash::Hasher as _;

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::Type;
use twox_hash::XxHash64;

use super::super::function::Formulas;
use super::super::inputs::named;
use super::super::plan::operations;
use super::super::system::constant_check;
use super::super::{attributes, documented, ident, number, rule_type, verbatim};
use crate::catalogue::{Nodes, Rule};
use crate::explain::SceneTexts;
use crate::model::Meaning;
use crate::model::scene::Row;
use crate::program::Operations;
use crate::scene::{Derived, Kinetic, is_implicit};
use crate::syntax::parse::Annotated;

/// The data that the implementations share.
pub(super) struct Context<'a> {
    pub(super) derived: &'a Derived,
    pub(super) block: &'a Annotated,
    pub(super) formulas: Formulas<'a>,
    pub(super) texts: &'a SceneTexts,
    /// The type whose steps are derived.
    pub(super) self_ty: Type,
}

impl Context<'_> {
    /// The user's type.
    pub(super) fn user_ty(&self) -> &Type {
        &self.block.item.self_ty
    }

    /// The implementations of what all systems have, for the system and for a reference to it.
    pub(super) fn system(&self) -> TokenStream {
        let (private, self_ty, attributes) = (self.formulas.private, &self.self_ty, attributes());
        let user_ty = self.user_ty();
        let doc = documented(&[("The system:", &self.texts.system())]);
        let site = self.site();
        let kind = kind(private, &site, &quote!(Self));
        let [coordinates, momenta] = ["q", "p"].map(|letter| self.names(letter));
        let mut hash = XxHash64::default();
        hash.write(self.texts.formulas().as_bytes());
        let hash = Literal::u64_unsuffixed(hash.finish());
        let visited = self.derived.scene.symbols.meanings().iter();
        let visited = visited.filter_map(|meaning| match meaning {
            Meaning::Parameter { access, .. } => Some(number(access, private)),
            _ => None,
        });
        let functions = self.block.noises.iter().chain(&self.block.forces);
        let functions = functions.chain(&self.block.symmetries);
        let functions = functions.chain([&self.block.lagrangian]);
        let functions = functions.map(|function| &function.name);
        let constants = self.derived.scene.constants.iter();
        let constants = constants.map(|(path, value)| constant_check(path, *value));
        let is_quadratic = match self.derived.kinetic {
            Kinetic::Masses(_) => true,
            Kinetic::Sites { is_affine, .. } => is_affine,
        };
        let quadratic = is_quadratic.then(|| {
            quote! {
                #attributes
                impl #private::QuadraticKineticEnergy for #self_ty {}
            }
        });
        let is_alone = self.block.inputs.is_none();
        let reference = is_alone.then(|| reference(private, &site, user_ty));
        quote! {
            #attributes
            const _: () = { #(let _ = <#user_ty>::#functions;)* };
            #(#constants)*
            #doc
            #attributes
            impl #private::AnySystem for #self_ty {
                #kind
                const NAMES: #private::Names = #private::Names {
                    parameters: &[],
                    coordinates: &[#(#coordinates),*],
                    momenta: &[#(#momenta),*],
                };
                const FORMULAS_HASH: u64 = #hash;
                fn target(&self) -> &Self { self }
                fn visit_parameters(&self, visit: &mut dyn ::core::ops::FnMut(f64)) {
                    #(visit(#visited);)*
                }
            }
            #reference
            #attributes
            impl #private::Separable for #self_ty {}
            #quadratic
        }
    }

    /// The type of a site.
    pub(super) fn site(&self) -> TokenStream {
        match self.derived.scene.row {
            Row::Number => quote!(f64),
            Row::Array(size) => {
                let size = Literal::usize_unsuffixed(size);
                quote!([f64; #size])
            }
            Row::Vector(size) => {
                let (size, runtime) = (Literal::usize_unsuffixed(size), self.runtime());
                quote!(#runtime::nalgebra::SVector<f64, #size>)
            }
        }
    }

    /// The names of the numbers of a site.
    fn names(&self, letter: &str) -> Vec<String> {
        let row = self.derived.scene.row;
        let name = |component: usize| match (row, ["x", "y", "z"].get(component)) {
            (Row::Number, _) => letter.to_owned(),
            (Row::Vector(1..=3), Some(name)) => format!("{letter}.{name}"),
            _ => format!("{letter}[{component}]"),
        };
        (0..row.len()).map(name).collect()
    }

    /// The implementation of a rule: its shears and its plan.
    pub(super) fn rule(&self, rule: Rule) -> TokenStream {
        let (private, self_ty) = (self.formulas.private, &self.self_ty);
        let runtime = self.runtime();
        let ty = rule_type(rule, &runtime);
        let plan = self.plan(rule);
        let shears = shears(rule).into_iter().map(|(kind, part)| {
            let kind = super::super::ident(kind);
            let part = part.map(Literal::f64_suffixed);
            let part = part.map(|part| quote!((#part)));
            quote!(#private::Shear::#kind #part)
        });
        let walk = quote!(mode.shears(&[#(#shears),*], h, dw));
        implementation([private, &runtime], self_ty, [&ty, &plan, &walk])
    }

    fn runtime(&self) -> TokenStream {
        let runtime = &self.block.arguments.runtime;
        quote!(#runtime)
    }

    fn plan(&self, rule: Rule) -> TokenStream {
        let (private, self_ty) = (self.formulas.private, self.user_ty());
        let system = quote!(#self_ty).to_string();
        let (name, order) = (rule.name(), rule.order);
        let scene = &self.derived.scene;
        let is_noisy = !scene.noises.is_empty() || scene.forces.iter().any(|f| f.is_noise);
        let noises = match self.derived.each.as_slice() {
            [] => {
                let listed = Literal::usize_unsuffixed(self.derived.listed);
                quote!(#listed)
            }
            _ => quote!(#private::Plan::OF_STATE),
        };
        let strong = match self.derived.pair(self.formulas.arena) {
            _ if !is_noisy => quote!(Deterministic),
            None => quote!(One),
            Some([a, b]) => quote!(Half { pair: (#a, #b) }),
        };
        let weak_order = if is_noisy { 1 } else { order };
        let node = self.formulas.operations(&self.derived.node.impulse);
        let [none, step] = [Operations::default(), node].map(|count| operations(private, &count));
        let blocks = self.texts.blocks(rule, &self.derived.kinetic);
        let blocks = blocks.into_iter().map(|(kind, unknowns)| {
            let kind = ident(kind);
            quote! {
                #private::Block {
                    kind: #private::BlockKind::#kind,
                    unknowns: &[#unknowns],
                    nonzeros: 0,
                    band: ::core::option::Option::None,
                }
            }
        });
        let conserved = self.derived.momenta.iter();
        let conserved = conserved.map(|momentum| format!("{}_momentum", momentum.name));
        let [action, equations] = self.texts.step(rule);
        let texts = [
            &self.texts.system(),
            &self.texts.motion,
            &action,
            &equations,
        ];
        let [terms, motion, action, equations] = texts.map(|text| verbatim(text));
        quote! {
            #private::Plan {
                system: #system,
                rule: #name,
                substeps: ::core::option::Option::None,
                degrees_of_freedom: #private::Plan::OF_STATE,
                noises: #noises,
                blocks: &[#(#blocks),*],
                deterministic_order: #order,
                strong_order: #private::StrongOrder::#strong,
                weak_order: #weak_order,
                conserved: &[#(#conserved),*],
                in_lanes: false,
                degenerate: ::core::option::Option::None,
                prepare: #none,
                step: #step,
                carried: #none,
                iteration: #none,
                formulas: #private::Formulas {
                    system: #terms,
                    motion: #motion,
                    action: #action,
                    step: #equations,
                },
            }
        }
    }
}

/// The shears of a step of a rule with nodes at the ends: an impulse with the weight w at
/// `q₀ + c (q₁ − q₀)` is a kick by `w (1 − c)` before the drift and by `w c` after it.
fn shears(rule: Rule) -> Vec<(&'static str, Option<f64>)> {
    if is_implicit(rule) {
        return vec![("Midpoint", None)];
    }
    let nodes = match rule.nodes {
        Nodes::One { c } => vec![(1.0, c)],
        Nodes::Ends => vec![(0.5, 0.0), (0.5, 1.0)],
        Nodes::Gauss { .. } | Nodes::Taylor => Vec::new(),
    };
    let before = nodes.iter().map(|&(w, c)| ("Kick", w * (1.0 - c)));
    let after = nodes.iter().map(|&(w, c)| ("Kick", w * c));
    let all = before.chain([("Drift", 1.0)]).chain(after);
    let all = all.filter(|shear| shear.1 != 0.0);
    all.map(|(kind, part)| (kind, Some(part))).collect()
}

/// The types of a system with these sites.
pub(super) fn kind(private: &TokenStream, site: &TokenStream, target: &TokenStream) -> TokenStream {
    quote! {
        type Configuration = ::std::vec::Vec<#site>;
        type Target = #target;
        type Stepped = #target;
        type Kind = #private::scene::Scenes;
        type StateLanes = ();
    }
}

/// The implementation for a reference to a system.
pub(super) fn reference(private: &TokenStream, site: &TokenStream, user_ty: &Type) -> TokenStream {
    let (user_ty, lifetimes) = named(user_ty, false);
    let (attributes, kind) = (attributes(), kind(private, site, &user_ty));
    quote! {
        #attributes
        impl<#(#lifetimes),*> #private::AnySystem for &#user_ty {
            #kind
            fn target(&self) -> &#user_ty { self }
        }
    }
}

/// The implementation of a rule of this type, with its plan and the body of its walk.
pub(super) fn implementation(
    [private, runtime]: [&TokenStream; 2],
    self_ty: &Type,
    [rule, plan, walk]: [&TokenStream; 3],
) -> TokenStream {
    let attributes = attributes();
    // the bound of `walk` takes no `'_`
    let (self_ty, lifetimes) = named(self_ty, false);
    quote! {
        #attributes
        impl<#(#lifetimes),*> #runtime::Rule<#self_ty> for #rule {
            type Increments = [f64];
            type Prepared = ();
            type Memory = ();
            const STAGES: usize = 1;
            const SUBSTEPS: usize = 1;
            const PLAN: &'static #private::Plan = &#plan;
            const HAS_INCREMENTS: bool = false;
            fn prepare(_: &#self_ty, _: f64) {}
            fn walk<__M: #private::Mode<#self_ty, [f64]>>(
                _: #private::Walker<'_, #self_ty, Self>,
                _: &(),
                _: &mut (),
                h: f64,
                dw: &__M::Increments,
                mode: &mut __M,
            ) -> ::core::result::Result<(), __M::Failure> {
                #walk
            }
        }
    }
}
