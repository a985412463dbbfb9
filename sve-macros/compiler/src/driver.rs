//! The whole pipeline, a line a stage: attribute → block → model → action → equations → scheme → tokens.

mod nodes;
mod size;

use std::borrow::Cow;
use std::collections::BTreeSet;

use proc_macro2::{Span, TokenStream, TokenTree};
use quote::quote;
use syn::ItemImpl;

use self::size::{Budget, Exhausted, WORK, within_budget};
use crate::algebra::Arena;
use crate::backend::rust::{self, Context, Derived};
use crate::catalogue::{Rule, RuleOption};
use crate::discretise::equations;
use crate::errors::Errors;
use crate::explain;
use crate::interpret;
use crate::linearise;
use crate::model::{Meaning, Model, Symbols};
use crate::rules::weak2::{self, Potential};
use crate::rules::{action, applicable};
use crate::structure::{self, Degenerate, StartTest};
use crate::syntax::arguments::ListedRule;
use crate::syntax::nesting;
use crate::syntax::parse::{self, Annotated};
use crate::syntax::recovery;
use crate::syntax::roles;
use crate::system::constraints;
use crate::system::degeneracy::{self, brackets};
use crate::system::functions;
use crate::system::mechanics::{self, Mechanics};
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
    size::check_entries(&block, &model)?;
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
    let starts = starts(&budget, &mechanics, &arena)?;
    let nodes = nodes::nodes(&starts, &budget, &mechanics)?;
    let steps = steps(&starts, &budget, &mechanics)?;
    // what is left to do is in proportion to what has been built
    arena.grant(usize::MAX);
    let about = explain::system(&model, &mechanics, &momenta, &arena);
    let functions = functions::functions(&model, &mechanics, settings.lanes, &mut arena);
    let start = StartTest::new(&model, &functions.mechanics, &mut arena);
    let context = Context {
        settings,
        block: &block,
        model: &model,
        mechanics: &mechanics,
        momenta: &momenta,
        about: &about,
        arena: &arena,
    };
    let mut output = rust::system(&context, &functions);
    output.extend(rust::start_of_step(&context, &start));
    output.extend(rust::momenta(&block, &model, &momenta, &arena));
    output.extend(nodes.iter().map(|nodes| nodes.output(&context)));
    for derived in &steps {
        let Derived {
            rule,
            symbols,
            action,
            scheme,
            arena,
            ..
        } = derived;
        let texts = explain::step(*rule, &model, &mechanics, action, scheme, symbols, arena);
        let context = Context { arena, ..context };
        output.extend(rust::rule(&context, derived, &texts));
    }
    Ok(rust::bounded(output))
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

/// What the derivation of a rule starts from.
struct Start<'a> {
    listed: &'a ListedRule,
    /// The potential of the option `weak2`, where it changes the step.
    potential: Option<Potential>,
    /// The derivatives, and the potential. Each step is derived in a copy of this arena: the terms of a sum stand in the order in which
    /// their expressions were made, so that in a common arena a rule would change the rounding of other rules.
    arena: Cow<'a, Arena>,
}

/// Returns what the rules start from, or an error at each option `weak2` that is of no use.
fn starts<'a>(
    budget: &Budget<'a>,
    mechanics: &Mechanics,
    arena: &'a Arena,
) -> syn::Result<Vec<Start<'a>>> {
    let mut errors = Errors::new();
    let mut starts = Vec::new();
    for listed in &budget.block.arguments.rules {
        let mut start = Start {
            listed,
            potential: None,
            arena: Cow::Borrowed(arena),
        };
        if listed.rule.options.contain(RuleOption::Weak2) {
            let option = listed.rule.weak2();
            let takes_h1 = option.is_some_and(|option| option.takes_h1);
            let own = start.arena.to_mut();
            own.grant(budget.work);
            let potential = budget.stage(own, |own| {
                weak2::potential(budget.model, mechanics, takes_h1, own)
            })?;
            match potential {
                Ok(potential) => start.potential = potential,
                Err(obstacle) => errors.push(
                    listed.place_of(RuleOption::Weak2),
                    obstacle.message(listed.rule),
                ),
            }
        }
        starts.push(start);
    }
    errors.finish(starts)
}

/// Derives the steps of the rules with few nodes; and, if the attribute asks for steps without structure, those of all rules.
fn steps(
    starts: &[Start<'_>],
    budget: &Budget<'_>,
    mechanics: &Mechanics,
) -> syn::Result<Vec<Derived>> {
    let forms = if budget.block.arguments.derives_unstructured {
        &[false, true][..]
    } else {
        &[false]
    };
    let mut steps = Vec::new();
    for &is_unstructured in forms {
        for start in starts {
            // the Gauss rules are derived from one node, and from the whole action for comparison only
            let rule = start.listed.rule;
            let has_stage_noise = rule.options.contain(RuleOption::StageNoise);
            if rule.stages().is_none() || (is_unstructured && !has_stage_noise) {
                steps.push(step(start, is_unstructured, budget, mechanics)?);
            }
        }
    }
    Ok(steps)
}

/// Derives the step of a listed rule.
fn step(
    start: &Start<'_>,
    is_unstructured: bool,
    budget: &Budget<'_>,
    mechanics: &Mechanics,
) -> syn::Result<Derived> {
    let (rule, potential) = (start.listed.rule, start.potential.as_ref());
    let mut arena = start.arena.clone().into_owned();
    arena.grant(budget.work);
    let derived = derive_step(rule, potential, is_unstructured, budget, mechanics, arena);
    derived.map_err(|obstacle| match obstacle {
        Obstacle::Work => budget.rule_too_large(rule, mechanics, &start.arena),
        Obstacle::Degenerate(degenerate, symbols) => singular(&degenerate, budget.block, &symbols),
    })
}

/// Why a rule has no step.
enum Obstacle {
    /// The work that was granted is used up.
    Work,
    /// The equations do not determine some unknowns, which are named by the symbols.
    Degenerate(Degenerate, Symbols),
}

impl From<Exhausted> for Obstacle {
    fn from(_: Exhausted) -> Self {
        Self::Work
    }
}

/// Derives the step of a rule in an arena that has the derivatives, with the work that is granted to the arena.
fn derive_step(
    rule: Rule,
    potential: Option<&Potential>,
    is_unstructured: bool,
    budget: &Budget<'_>,
    mechanics: &Mechanics,
    mut arena: Arena,
) -> Result<Derived, Obstacle> {
    let mut symbols = budget.model.symbols.clone();
    let (action, scheme) = within_budget(&mut arena, |arena| {
        let action = action::discretise(rule, budget.model, potential, &mut symbols, arena);
        let equations = equations::equations(&action, &symbols, arena);
        let scheme = if is_unstructured {
            Ok(structure::unstructured(equations, &mut symbols, arena))
        } else {
            structure::analyse(equations, &action, &mut symbols, arena)
        };
        (action, scheme)
    })?;
    let scheme = match scheme {
        Ok(scheme) => scheme,
        Err(degenerate) => return Err(Obstacle::Degenerate(degenerate, symbols)),
    };
    let linearisation = within_budget(&mut arena, |arena| {
        linearise::linearise(&scheme, &action, &symbols, arena)
    })?;
    let weak_order = weak2::weak_order(rule, budget.model, mechanics, &mut arena);
    Ok(Derived {
        rule,
        is_unstructured,
        weak_order,
        symbols,
        action,
        scheme,
        linearisation,
        arena,
    })
}

/// A structurally singular step: L does not determine some velocities.
fn singular(degenerate: &Degenerate, block: &Annotated, symbols: &Symbols) -> syn::Error {
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
