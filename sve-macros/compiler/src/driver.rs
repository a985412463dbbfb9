//! The whole pipeline, a line a stage: attribute → block → model → action → equations → scheme → tokens.

mod nodes;

use std::collections::BTreeSet;

use proc_macro2::{Span, TokenStream, TokenTree};
use quote::quote;
use syn::ItemImpl;

use self::nodes::Nodes;
use crate::algebra::Arena;
use crate::backend::rust::{self, Context, Derived};
use crate::discretise::equations;
use crate::discretise::tangent;
use crate::errors::Errors;
use crate::explain;
use crate::interpret;
use crate::rules::weak2::{self, Potential};
use crate::rules::{Rule, RuleOption, action, applicable};
use crate::structure::{self, Degenerate};
use crate::syntax::arguments::ListedRule;
use crate::syntax::nesting;
use crate::syntax::parse::{self, Annotated};
use crate::syntax::recovery;
use crate::syntax::roles;
use crate::system::constraints;
use crate::system::degeneracy::{self, brackets};
use crate::system::energy;
use crate::system::euler;
use crate::system::mechanics::{self, Mechanics};
use crate::system::model::{Meaning, Model};
use crate::system::symmetry::{self, MomentumMap};

/// What an expansion is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Whether steps of many states at once are derived too, for ensembles.
    pub lanes: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { lanes: true }
    }
}

/// The expansion of the attribute: the user's block as it was, and the derived implementations or the errors.
pub fn expand(attribute: &TokenStream, item: &TokenStream, settings: Settings) -> TokenStream {
    expand_within(attribute, item, settings, WORK)
}

/// The expansion with another bound on the work of each stage.
pub(crate) fn expand_within(
    attribute: &TokenStream,
    item: &TokenStream,
    settings: Settings,
    work: usize,
) -> TokenStream {
    if let Err(error) = nesting::check(attribute).and_then(|()| nesting::check(item)) {
        return error.into_compile_error();
    }
    let block = match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(block) => block,
        Err(error) => {
            let is_impl = |t: TokenTree| matches!(t, TokenTree::Ident(word) if word == "impl");
            let error = if item.clone().into_iter().any(is_impl) {
                error
            } else {
                let message = "`#[variational]` belongs on the `impl` block that holds the Lagrangian, `impl MySystem { fn lagrangian(…) … }`";
                syn::Error::new(error.span(), message)
            };
            let error = error.into_compile_error();
            return quote!(#item #error);
        }
    };
    let plain = roles::without_roles(item);
    let mut mistaken = BTreeSet::new();
    match derive(attribute.clone(), block, settings, work, &mut mistaken) {
        Ok(derived) => quote! {
            // `&self` is what this macro asks for
            #[allow(clippy::trivially_copy_pass_by_ref, clippy::large_types_passed_by_value, clippy::unused_self)]
            #plain
            #derived
        },
        Err(error) => after_mistakes(&error, attribute, item, &mistaken),
    }
}

/// The errors, beside a block that gives no errors of its own in the functions and constants of these names.
fn after_mistakes(
    error: &syn::Error,
    attribute: &TokenStream,
    item: &TokenStream,
    mistaken: &BTreeSet<String>,
) -> TokenStream {
    let error = error.to_compile_error();
    match syn::parse2::<ItemImpl>(item.clone()) {
        Ok(mut block) => {
            recovery::remove_mistakes(&mut block, mistaken);
            let placeholders = rust::placeholders(&block, attribute);
            recovery::remove_attributes(&mut block);
            quote!(#error #block #placeholders)
        }
        Err(_) => error,
    }
}

/// The derived implementations; or the errors, and in `mistaken` the names of functions and constants that have some.
fn derive(
    attribute: TokenStream,
    item: ItemImpl,
    settings: Settings,
    work: usize,
    mistaken: &mut BTreeSet<String>,
) -> syn::Result<TokenStream> {
    let mut arena = Arena::new();
    let mut errors = Errors::new();
    let read = parse::annotated(attribute, item, &mut errors).and_then(|block| {
        let model = interpret::interpret(&block, &mut arena, &mut errors)?;
        Some((block, model))
    });
    mistaken.clone_from(errors.places());
    let Some((block, mut model)) = errors.finish(read)? else {
        return Err(syn::Error::new(
            Span::call_site(),
            "this block cannot be read",
        ));
    };
    applicable::check(&block, &model)?;
    check_size(&block, &model)?;
    arena.grant(work);
    let (mut mechanics, degeneracy) = {
        let budget = Budget::new(&block, &model, work);
        let mechanics = budget.stage(&mut arena, |arena| mechanics::mechanics(&model, arena))?;
        let degeneracy = budget.stage(&mut arena, |arena| {
            degeneracy::classify(&block, &model, &mechanics, arena)
        })??;
        (mechanics, degeneracy)
    };
    if let Some(degeneracy) = degeneracy {
        applicable::check_degenerate(&block, &degeneracy)?;
        let budget = Budget::new(&block, &model, work);
        mechanics.commutation = budget.stage(&mut arena, |arena| {
            brackets::commutation(&degeneracy, &model, &mechanics, arena)
        })?;
        model.degeneracy = Some(degeneracy);
    }
    constraints::check_momentum(&block, &model, &mechanics)?;
    if constraints::with_tangent_noises(&block, &mut model, &mechanics, &mut arena)? {
        let budget = Budget::new(&block, &model, work);
        mechanics = budget.stage(&mut arena, |arena| mechanics::mechanics(&model, arena))?;
    }
    let budget = Budget::new(&block, &model, work);
    budget.stage(&mut arena, |arena| {
        constraints::check(&block, &model, &mut mechanics, arena)
    })??;
    let mut momenta =
        budget.stage(&mut arena, |arena| symmetry::check(&block, &model, arena))??;
    restrict_to_nodes(&mut momenta, &block, &model, &arena);
    // Rules with a potential come last: what is made for it must not change the order of terms in others, and so their rounding.
    let has_potential = |listed: &&ListedRule| listed.rule.options.contain(RuleOption::Weak2);
    let (with, without): (Vec<_>, Vec<_>) = block.arguments.rules.iter().partition(has_potential);
    let mut steps = steps(&without, &vec![None; without.len()], &budget, &mut arena)?;
    let mut nodes = Nodes::new(&budget, &mechanics, &mut arena)?;
    let potentials = potentials(&with, &budget, &mechanics, &mut arena)?;
    steps.extend(self::steps(&with, &potentials, &budget, &mut arena)?);
    nodes.correct(&with, &potentials, &budget, &mechanics, &mut arena)?;
    budget.stage(&mut arena, |arena| {
        mechanics.differentiate_constraints(&model, arena);
    })?;
    // what is left to do is in proportion to what has been built
    arena.grant(usize::MAX);
    let about = explain::system(&model, &mechanics, &momenta, &arena);
    let mut weak_order = |rule| weak2::weak_order(rule, &model, &mechanics, &mut arena);
    let weak_orders: Vec<u32> = steps.iter().map(|step| weak_order(step.rule)).collect();
    let rules = block.arguments.rules.iter().map(|listed| listed.rule);
    let of_stages = rules.filter(|rule| rule.stages().is_some());
    let of_stages: Vec<(Rule, u32)> = of_stages.map(|rule| (rule, weak_order(rule))).collect();
    mechanics.stabilise(&mut arena);
    nodes.stabilise(&mut arena);
    let energy = (settings.lanes)
        .then(|| energy::energy(&model, &mechanics, &mut arena))
        .flatten();
    let euler = euler::euler(&model, &mechanics, &mut arena);
    let last = (energy.as_ref(), euler.as_ref(), settings.lanes);
    let mut output = rust::system(&block, &model, &mechanics, last, &about, &arena);
    output.extend(rust::momenta(&block, &model, &momenta, &arena));
    let context = Context {
        settings,
        block: &block,
        model: &model,
        mechanics: &mechanics,
        momenta: &momenta,
        about: &about,
        arena: &arena,
    };
    output.extend(nodes.output(&of_stages, &context));
    for (derived, weak_order) in steps.iter().zip(weak_orders) {
        let Derived {
            rule,
            symbols,
            action,
            scheme,
            ..
        } = derived;
        let texts = explain::step(*rule, &model, &mechanics, action, scheme, symbols, &arena);
        output.extend(rust::rule(&context, derived, weak_order, &texts));
    }
    Ok(output)
}

/// Degenerate Lagrangians: momenta are conserved as affine functions only if the nodes of all rules keep them.
fn restrict_to_nodes(momenta: &mut [MomentumMap], block: &Annotated, model: &Model, arena: &Arena) {
    let Some(degeneracy) = &model.degeneracy else {
        return;
    };
    let rules = block.arguments.rules.iter();
    let nodes = rules.filter_map(|listed| listed.rule.node());
    for (map, generator) in momenta.iter_mut().zip(&model.symmetries) {
        let mut nodes = nodes.clone();
        let is_kept = |node| degeneracy.keeps_momentum(&generator.field, node == 0.5, model, arena);
        map.is_affine &= nodes.all(is_kept);
    }
}

/// Derives the steps of some rules, with the potentials of the option `weak2`.
fn steps(
    rules: &[&ListedRule],
    potentials: &[Option<Potential>],
    budget: &Budget<'_>,
    arena: &mut Arena,
) -> syn::Result<Vec<Derived>> {
    let forms = if budget.block.arguments.derives_unstructured {
        &[false, true][..]
    } else {
        &[false]
    };
    let mut steps = Vec::new();
    for &is_unstructured in forms {
        for (listed, potential) in rules.iter().zip(potentials) {
            // the Gauss rules are derived from one node, and from the whole action for comparison only
            let has_stage_noise = listed.rule.options.contain(RuleOption::StageNoise);
            if listed.rule.stages().is_some() && (!is_unstructured || has_stage_noise) {
                continue;
            }
            arena.grant(budget.work);
            steps.push(step(
                listed.rule,
                potential.as_ref(),
                is_unstructured,
                budget,
                arena,
            )?);
        }
    }
    Ok(steps)
}

/// The potentials of rules with the option `weak2`, or an error at each option that is of no use.
fn potentials(
    rules: &[&ListedRule],
    budget: &Budget<'_>,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> syn::Result<Vec<Option<Potential>>> {
    let mut errors = Errors::new();
    let mut potentials = Vec::new();
    for listed in rules {
        arena.grant(budget.work);
        let takes_h1 = listed
            .rule
            .weak2(listed.rule.options)
            .is_some_and(|w| w.takes_h1);
        let potential = budget.stage(arena, |arena| {
            weak2::potential(budget.model, mechanics, takes_h1, arena)
        })?;
        match potential {
            Ok(potential) => potentials.push(potential),
            Err(obstacle) => errors.push(
                listed.place_of(RuleOption::Weak2),
                obstacle.message(listed.rule),
            ),
        }
    }
    errors.finish(potentials)
}

/// Derives the step of a rule, with the potential of the option `weak2`.
fn step(
    rule: Rule,
    potential: Option<&Potential>,
    is_unstructured: bool,
    budget: &Budget<'_>,
    arena: &mut Arena,
) -> syn::Result<Derived> {
    let mut symbols = budget.model.symbols.clone();
    let (action, scheme) = budget.stage(arena, |arena| {
        let action = action::discretise(rule, budget.model, potential, &mut symbols, arena);
        let equations = equations::equations(&action, &symbols, arena);
        let scheme = if is_unstructured {
            Ok(structure::unstructured(equations, &mut symbols, arena))
        } else {
            structure::analyse(equations, &action, &mut symbols, arena)
        };
        (action, scheme)
    })?;
    let scheme = scheme.map_err(|degenerate| singular(&degenerate, budget.block, &symbols))?;
    let linearisation = budget.stage(arena, |arena| {
        tangent::linearise(&scheme, &action, &symbols, arena)
    })?;
    Ok(Derived {
        rule,
        is_unstructured,
        symbols,
        action,
        scheme,
        linearisation,
    })
}

/// Work that the derivatives may take, and then each rule, in the units of the arena's budget; a unit is some 20 nanoseconds of
/// an optimised build. A dense system of 48 coordinates takes five sixths of it.
const WORK: usize = 200_000_000;

/// Second derivatives of L and of the noises that are written down, zeros included.
const ENTRIES: usize = 200_000;

/// An error where there would be too many second derivatives.
fn check_size(block: &Annotated, model: &Model) -> syn::Result<()> {
    let (n, m) = (model.dof(), model.noises.len());
    let entries = (m + 1).saturating_mul(3 * n * n);
    if entries <= ENTRIES {
        return Ok(());
    }
    let message = format!(
        "this system is too large to unroll: {n} coordinates and {m} noise terms have {entries} second derivatives, and the limit is {ENTRIES}; use fewer of them"
    );
    Err(syn::Error::new(block.lagrangian.name.span(), message))
}

/// The work that is granted to the derivatives, and then to each rule.
struct Budget<'a> {
    block: &'a Annotated,
    model: &'a Model,
    work: usize,
}

impl<'a> Budget<'a> {
    fn new(block: &'a Annotated, model: &'a Model, work: usize) -> Self {
        Self { block, model, work }
    }

    /// Runs a stage. Returns an error if the work that was granted is used up.
    fn stage<T>(&self, arena: &mut Arena, run: impl FnOnce(&mut Arena) -> T) -> syn::Result<T> {
        let result = run(arena);
        if !arena.is_exhausted() {
            return Ok(result);
        }
        let message = format!(
            "this system is too large to unroll: with {} coordinates and {} noise terms its derivatives take more than {} operations of the macro, which is the limit; use fewer coordinates or noise terms, shorter loops, or helpers that are called less often",
            self.model.dof(),
            self.model.noises.len(),
            self.work,
        );
        let place = self.block.lagrangian.name.span();
        Err(syn::Error::new(place, message))
    }
}

/// A structurally singular step: L does not determine some velocities.
fn singular(
    degenerate: &Degenerate,
    block: &Annotated,
    symbols: &crate::system::model::Symbols,
) -> syn::Error {
    let names: Vec<String> = degenerate
        .unknowns
        .iter()
        .map(|&u| match symbols.meaning(u) {
            Meaning::Unknown(unknown) => format!("`{unknown}`"),
            _ => String::new(),
        })
        .collect();
    syn::Error::new(
        block.lagrangian.name.span(),
        format!(
            "this Lagrangian is degenerate: the step's equations do not determine {}; every velocity must occur in L, quadratically or otherwise non-linearly",
            names.join(", ")
        ),
    )
}
