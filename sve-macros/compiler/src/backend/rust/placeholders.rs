//! Implementations without bodies, which are emitted after an error so that the compiler reports no
//! consequences of it.
//!
//! Sizes come from the signatures, by the compiler where they are not literal.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{ToTokens, quote};
use syn::{
    Expr, FnArg, GenericParam, ImplItem, ImplItemFn, ItemImpl, Lit, ReturnType, Type, parse_quote,
};

use super::configuration::{is_vector_or_nested, stored};
use super::implementation::Implementation;
use super::inputs::{Holder, Holds, held};
use crate::catalogue::Rule;
use crate::errors::Errors;
use crate::syntax::arguments::Arguments;
use crate::syntax::inputs::last_input;
use crate::syntax::parse::{is_f64, is_this};
use crate::syntax::signature::{entry_of_slice, is_rotation};

/// Implementations without bodies for every rule that the attribute names.
pub(crate) fn placeholders(block: &ItemImpl, attribute: &TokenStream) -> TokenStream {
    let rules = if block.attrs.iter().any(is_this) {
        // the rules of the other attribute are meant too
        Rule::all_with_options()
    } else {
        rules(attribute)
    };
    implementations(block, attribute, &rules)
}

fn implementations(block: &ItemImpl, attribute: &TokenStream, rules: &[Rule]) -> TokenStream {
    let (user_ty, inputs) = (&*block.self_ty, inputs_type(block));
    let is_scaled = inputs.is_none() && has_time_scale(block);
    let self_ty: &Type = &if inputs.is_some() || is_scaled {
        held(user_ty)
    } else {
        user_ty.clone()
    };
    let runtime = runtime(attribute);
    let private = quote!(#runtime::__private);
    let attributes = super::attributes();
    let within = |implementations: TokenStream, is_scene: bool| match holder(
        &private,
        (user_ty, inputs),
        is_scaled,
        is_scene,
    ) {
        Some(holder) => holder.print(&implementations),
        None => implementations,
    };
    let (generics, _, clause) = block.generics.split_for_impl();
    // no constant is computed from a generic parameter other than a lifetime
    let mut generic = block.generics.params.iter();
    let is_generic = generic.any(|parameter| !matches!(parameter, GenericParam::Lifetime(_)));
    if let Some(entry) = coordinates_type(block).and_then(entry_of_slice)
        && !is_generic
    {
        let rules = rules.iter().map(|rule| super::rule_type(*rule, &runtime));
        let rules: Vec<TokenStream> = rules.collect();
        let site = site(entry);
        let result = quote!(::core::result::Result<f64, #private::StepError>);
        let momenta = momenta(block, &private, [&quote!(::std::vec::Vec<#site>), &result]);
        let (of, plan) = ((self_ty, site), plan(&private));
        let has_inputs = inputs.is_some();
        let paths = [&private, &runtime];
        let scene = super::scene::placeholders(paths, of, &rules, &plan, has_inputs);
        let scene = within(scene, true);
        return quote!(#scene #momenta);
    }
    let with_rotations = configuration_with_rotations(block, &private).filter(|_| !is_generic);
    let n = match &with_rotations {
        Some(ty) => quote!({ <#ty as #private::FixedSize>::DEGREES_OF_FREEDOM }),
        None => coordinates(block, is_generic),
    };
    let m = processes(block, is_generic);
    let fail = quote!(::core::unreachable!("the macro reported an error"));
    let written = coordinates_type(block).filter(|ty| !is_generic && is_vector_or_nested(ty));
    let written = with_rotations.or_else(|| written.map(|ty| quote!(#ty)));
    let configuration = written.as_ref().map(|ty| quote!(, #ty));
    let whole = written.unwrap_or_else(|| quote!([f64; #n]));
    let momenta = momenta(block, &private, [&whole, &quote!(f64)]);
    let rules = rules.iter().map(|rule| {
        let rule = super::rule_type(*rule, &runtime);
        let header = quote!(impl #generics #private::StepEquations<#rule> for #self_ty #clause);
        step(&private, header, [&n, &m])
    });
    let rate =
        is_scaled.then(|| super::time_scale::implementation(self_ty, &whole, &private, &fail));
    let implementations = quote! {
        #rate
        #attributes
        impl #generics #private::System for #self_ty #clause {
            type Dims = #private::Dims<#n, #m #configuration>;
            type Itself = Self;
            const AFFINE_MOMENTUM: bool = true;
            type EulerNumbers = ();
            const PARAMETERS: &'static [&'static str] = &[];
            fn itself(&self) -> &Self { self }
            fn lagrangian_jet(&self, time: f64, q: &#private::FlatOf<Self>, v: &[f64; #n]) -> #private::LagrangianJet<#n> { #fail }
            fn noise_jets(&self, time: f64, q: &#private::FlatOf<Self>, p: &[f64; #n]) -> [#private::NoiseJet<#n>; #m] { #fail }
        }
        #attributes
        impl #generics #private::StartOfStep for #self_ty #clause {}
        #attributes
        impl #generics #private::Separable for #self_ty #clause {}
        #attributes
        impl #generics #private::QuadraticKineticEnergy for #self_ty #clause {}
        #(#rules)*
    };
    let implementations = within(implementations, false);
    quote!(#implementations #momenta)
}

/// The equations of a step with so many coordinates and processes.
fn step(private: &TokenStream, header: TokenStream, [n, m]: [&dyn ToTokens; 2]) -> TokenStream {
    let (none, nothing) = (Literal::usize_unsuffixed(0), quote!(()));
    let fail = quote!(::core::unreachable!("the macro reported an error"));
    let implementation = Implementation {
        private,
        doc: TokenStream::new(),
        header,
        sizes: [n, m, &none],
        types: [
            quote!(#private::FlatStateOf<Self>),
            nothing.clone(),
            nothing,
        ],
        plan: plan(private),
        returns: quote!(Increment),
        more: TokenStream::new(),
        prepare: TokenStream::new(),
        start: fail.clone(),
        increment: fail.clone(),
        linearise: fail,
        increment_doc: TokenStream::new(),
    };
    implementation.print()
}

/// The type that holds inputs or an energy beside the system, if the block has any.
fn holder<'a>(
    private: &'a TokenStream,
    (user_ty, inputs): (&'a Type, Option<&'a Type>),
    is_scaled: bool,
    is_scene: bool,
) -> Option<Holder<'a>> {
    let (count, holds) = match inputs {
        Some(input) => (
            quote!({ ::core::mem::size_of::<#input>() / ::core::mem::size_of::<f64>() }),
            Holds::Inputs {
                input,
                numbers: quote!(::core::unreachable!("the macro reported an error")),
                is_scene,
            },
        ),
        None if is_scaled => (quote!(1), Holds::Energy),
        None => return None,
    };
    Some(Holder {
        private,
        user_ty,
        count,
        holds,
    })
}

/// The type of the inputs; `None` also for a generic block, whose error is that it is generic.
fn inputs_type(block: &ItemImpl) -> Option<&Type> {
    let others = |f: &ImplItemFn| {
        let has = |role: &str| f.attrs.iter().any(|a| a.path().is_ident(role));
        let is_read_with_velocity = f.sig.ident == "lagrangian" || has("force") || has("h1");
        (is_read_with_velocity.then_some(2)).or_else(|| has("gamma").then_some(1))
    };
    let mut functions = functions(block).filter(|_| block.generics.params.is_empty());
    functions.find_map(|f| last_input(f, others(f)?))
}

/// Returns whether a function has the attribute of a time scale, which no scene has.
fn has_time_scale(block: &ItemImpl) -> bool {
    let has = |f: &ImplItemFn| f.attrs.iter().any(|a| a.path().is_ident("time_scale"));
    let is_scene = coordinates_type(block).is_some_and(|ty| entry_of_slice(ty).is_some());
    block.generics.params.is_empty() && !is_scene && functions(block).any(has)
}

/// The type of a site of a scene: the written one, or a number if no site has that type.
fn site(entry: &Type) -> TokenStream {
    let is_site = match entry {
        Type::Array(array) => is_f64(&array.elem),
        other => is_f64(other) || is_vector_or_nested(other),
    };
    if is_site { quote!(#entry) } else { quote!(f64) }
}

/// A plan of nothing.
fn plan(private: &TokenStream) -> TokenStream {
    let operations =
        quote!(#private::Operations { arithmetic: 0, transcendental: 0, angle_additions: 0 });
    quote! {
        #private::Plan {
            system: "",
            rule: "",
            substeps: ::core::option::Option::None,
            degrees_of_freedom: 0,
            noises: 0,
            blocks: &[],
            deterministic_order: 0,
            strong_order: #private::StrongOrder::Deterministic,
            weak_order: 0,
            conserved: &[],
            in_lanes: false,
            degenerate: ::core::option::Option::None,
            prepare: #operations,
            step: #operations,
            carried: #operations,
            iteration: #operations,
            formulas: #private::Formulas { system: "", motion: "", action: "", step: "" },
        }
    }
}

/// The functions that symmetries would give.
fn momenta(
    block: &ItemImpl,
    private: &TokenStream,
    [configuration, result]: [&TokenStream; 2],
) -> TokenStream {
    let self_ty = &block.self_ty;
    let attributes = super::attributes();
    let (generics, _, clause) = block.generics.split_for_impl();
    let is_symmetry = |f: &&ImplItemFn| f.attrs.iter().any(|a| a.path().is_ident("symmetry"));
    let is_free = |name: &Ident| functions(block).all(|f| f.sig.ident != *name);
    let functions = functions(block).filter(is_symmetry).filter_map(|f| {
        let (visibility, name) = (&f.vis, super::momentum_name(&f.sig.ident));
        is_free(&name).then(|| {
            quote! {
                #visibility fn #name(&self, state: &#private::State<#configuration>) -> #result {
                    ::core::unreachable!("the macro reported an error")
                }
            }
        })
    });
    quote! {
        #attributes
        #[allow(dead_code)]
        impl #generics #self_ty #clause { #(#functions)* }
    }
}

/// The rules that the attribute names; all of them where it has a mistake, since any may have been
/// meant.
fn rules(attribute: &TokenStream) -> Vec<Rule> {
    let mut errors = Errors::new();
    let arguments = Arguments::read(attribute.clone(), &mut errors);
    match errors.finish(arguments) {
        Ok(arguments) => arguments.rules.iter().map(|listed| listed.rule).collect(),
        Err(_) => Rule::all_with_options(),
    }
}

/// The path after `crate =`, or the usual one.
fn runtime(attribute: &TokenStream) -> TokenStream {
    let mut tokens = attribute
        .clone()
        .into_iter()
        .skip_while(|t| t.to_string() != "crate")
        .skip(2);
    let path: TokenStream = tokens
        .by_ref()
        .take_while(|t| t.to_string() != ",")
        .collect();
    match syn::parse2::<syn::Path>(path) {
        Ok(path) => quote!(#path),
        Err(_) => quote!(::sve_runtime),
    }
}

fn functions(block: &ItemImpl) -> impl Iterator<Item = &ImplItemFn> {
    block.items.iter().filter_map(|item| match item {
        ImplItem::Fn(function) => Some(function),
        _ => None,
    })
}

fn coordinates(block: &ItemImpl, is_generic: bool) -> TokenStream {
    match coordinates_type(block) {
        Some(ty) => size(&[ty], is_generic),
        None => quote!(1),
    }
}

/// The type of a configuration with rotations; nothing if the Lagrangian has no argument that is a
/// rotation.
fn configuration_with_rotations(block: &ItemImpl, private: &TokenStream) -> Option<TokenStream> {
    let lagrangian = functions(block).find(|f| f.sig.ident == "lagrangian")?;
    let types: Vec<&Type> = lagrangian
        .sig
        .inputs
        .iter()
        .filter_map(|input| match input {
            FnArg::Typed(argument) => Some(&*argument.ty),
            FnArg::Receiver(_) => None,
        })
        .collect();
    let at = types.iter().position(|ty| is_rotation(ty))?;
    let rotation = stored(types[at], private);
    match types[..at].last() {
        Some(vector) if is_f64_array_or_vector(vector) => Some(quote!((#vector, #rotation))),
        _ => Some(rotation),
    }
}

/// Returns whether a type is a configuration in a vector space other than a number.
fn is_f64_array_or_vector(ty: &Type) -> bool {
    matches!(ty, Type::Array(_)) || is_vector_or_nested(ty)
}

/// The type of the velocity. The configuration has the same type.
fn coordinates_type(block: &ItemImpl) -> Option<&Type> {
    let lagrangian = functions(block).find(|f| f.sig.ident == "lagrangian")?;
    let behind = usize::from(last_input(lagrangian, 2).is_some());
    match lagrangian.sig.inputs.iter().rev().nth(behind) {
        Some(FnArg::Typed(argument)) => Some(&argument.ty),
        _ => None,
    }
}

fn processes(block: &ItemImpl, is_generic: bool) -> TokenStream {
    let is_noise = |f: &&ImplItemFn| {
        f.attrs
            .iter()
            .any(|a| a.path().is_ident("gamma") || a.path().is_ident("h1"))
    };
    let is_noise_force = |f: &&ImplItemFn| {
        f.attrs.iter().any(|a| {
            a.path().is_ident("force") && a.parse_args::<Ident>().is_ok_and(|word| word == "noise")
        })
    };
    let number: Type = parse_quote!(f64);
    let forces = functions(block).filter(is_noise_force).map(|_| &number);
    let outputs: Vec<&Type> = functions(block)
        .filter(is_noise)
        .filter_map(|f| match &f.sig.output {
            ReturnType::Type(_, ty) => Some(&**ty),
            ReturnType::Default => None,
        })
        .chain(forces)
        .collect();
    size(&outputs, is_generic)
}

/// Numbers in some types, as a constant argument. In a block that is generic, a length is a literal
/// or a name.
fn size(types: &[&Type], is_generic: bool) -> TokenStream {
    let literal: Option<usize> = types.iter().map(|ty| entries(ty)).sum();
    if let Some(n) = literal {
        let n = Literal::usize_unsuffixed(n);
        return quote!(#n);
    }
    if is_generic {
        return match types {
            [Type::Array(array)] if is_f64(&array.elem) && matches!(array.len, Expr::Path(_)) => {
                array.len.to_token_stream()
            }
            _ => quote!(1),
        };
    }
    let types = types.iter().map(|ty| match ty {
        Type::Reference(reference) => &*reference.elem,
        other => *other,
    });
    if types.clone().any(|ty| matches!(ty, Type::Slice(_))) {
        // it has no size
        return quote!(1);
    }
    quote!({ #(::core::mem::size_of::<#types>() / ::core::mem::size_of::<f64>())+* })
}

/// Numbers in a type with literal lengths.
fn entries(ty: &Type) -> Option<usize> {
    match ty {
        Type::Array(array) => match &array.len {
            Expr::Lit(length) => match &length.lit {
                Lit::Int(n) => n
                    .base10_parse::<usize>()
                    .ok()?
                    .checked_mul(entries(&array.elem)?),
                _ => None,
            },
            _ => None,
        },
        _ => is_f64(ty).then_some(1),
    }
}
