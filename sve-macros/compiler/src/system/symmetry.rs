//! Whether each `#[symmetry]` is one, and the momentum that it conserves.
//!
//! Input: the model with its generators ξ. Output: the momentum maps ⟨p, ξ⟩, or an error that names the function which is
//! not invariant. What the algebra does not decide is evaluated at random points (`symbolic/zero.rs`). To be zero identically (`docs/mathematics.md`, section 7; with `ξ_t` for a generator that depends on time):
//!
//! ```text
//! L:   ⟨L_q, ξ⟩ + ⟨L_v, Dξ v + ξ_t⟩        γ:   ⟨γ_q, ξ⟩
//! H₁:  ⟨∂H₁/∂q, ξ⟩ − ⟨p, Dξ ∂H₁/∂p⟩        F:   ⟨F, ξ⟩, the work of the force
//! ```

use proc_macro2::Ident;
use quote::format_ident;

use crate::algebra::{Arena, Expr, Symbol, Vanishing};
use crate::errors::Errors;
use crate::explain;
use crate::syntax::parse::{Annotated, Part};
use crate::system::model::{Generator, Model};

/// The name of the function that returns the momentum of a symmetry.
pub(crate) fn momentum_name(symmetry: &Ident) -> Ident {
    format_ident!("{symmetry}_momentum", span = symmetry.span())
}

/// A conserved momentum.
pub(crate) struct MomentumMap {
    /// Source name of the symmetry.
    pub(crate) name: String,
    /// ⟨p, ξ⟩.
    pub(crate) value: Expr,
    /// Whether ξ is affine in q and free of time: then the steps conserve it too.
    pub(crate) affine: bool,
    /// How it is known that nothing changes along ξ.
    pub(crate) surely: Vanishing,
}

/// Longest formula of a remainder that is shown, in characters.
const READABLE: usize = 160;

/// Checks the symmetries of a block.
pub(crate) fn check(
    block: &Annotated,
    model: &Model,
    arena: &mut Arena,
) -> syn::Result<Vec<MomentumMap>> {
    let mut errors = Errors::new();
    let mut maps = Vec::new();
    for (part, generator) in block.symmetries.iter().zip(&model.symmetries) {
        let moves_nothing = generator.field.iter().all(|&x| arena.is_zero(x));
        if moves_nothing {
            errors.push(
                part.name.span(),
                format!("the symmetry `{}` moves nothing: return the velocity of each coordinate along it, such as `[-q[1], q[0]]` for a rotation", part.name),
            );
            continue;
        }
        let function = momentum_name(&part.name);
        if block.functions.iter().any(|f| f.sig.ident == function) {
            errors.push(
                part.name.span(),
                format!("`{}` gives the function `{function}`, which the block has already: rename one of them", part.name),
            );
        }
        let mut surely = Vanishing::Proved;
        for Change { of, rate, scale } in changes(block, generator, model, arena) {
            match arena.vanishing(rate) {
                Some(vanishing) => surely = surely.max(vanishing),
                None => {
                    let rate = arena.scale(1.0 / scale, rate);
                    let message = broken(part, &of, rate, model, arena);
                    errors.push(part.name.span(), message);
                }
            }
        }
        maps.push(momentum(generator, surely, model, arena));
    }
    errors.finish(maps)
}

fn broken(part: &Part, what: &Changed, change: Expr, model: &Model, arena: &Arena) -> String {
    let name = &part.name;
    let rate = explain::formula(&model.symbols, change, READABLE, arena)
        .map(|formula| format!(" at the rate {formula}"))
        .unwrap_or_default();
    match what {
        Changed::Function(whose) => format!(
            "`{name}` is not a symmetry of {whose}, which changes along it{rate}; correct the generator, or remove `#[symmetry]`"
        ),
        Changed::Work(force) => format!(
            "the force {force} does work along the symmetry `{name}`{rate}, so that its momentum is not conserved; remove `#[symmetry]`, or the force along it"
        ),
    }
}

/// What must not change along a generator.
enum Changed {
    /// A function of the block, as a message calls it.
    Function(String),
    /// The work of the forces of these names.
    Work(String),
}

/// How much something changes along a generator.
struct Change {
    of: Changed,
    /// The rate of change times `scale`.
    rate: Expr,
    /// A power of two.
    scale: f64,
}

/// An expression times a power of two that brings it to the order of 1 where products with it might underflow or overflow.
fn scaled(expr: Expr, arena: &mut Arena) -> (Expr, f64) {
    let scale = arena.scale_of(&[expr]);
    if scale == 1.0 {
        (expr, scale)
    } else {
        (arena.scale(scale, expr), scale)
    }
}

/// How much each function of the block changes along a generator.
fn changes(
    block: &Annotated,
    generator: &Generator,
    model: &Model,
    arena: &mut Arena,
) -> Vec<Change> {
    let unit = arena.scale_of(&generator.field);
    let xi: Vec<Expr> = match unit {
        1.0 => generator.field.clone(),
        _ => {
            let scaled = generator.field.iter().map(|&x| arena.scale(unit, x));
            scaled.collect()
        }
    };
    let xi = &xi;
    let v: Vec<Expr> = model.v.iter().map(|&s| arena.symbol(s)).collect();
    let p: Vec<Expr> = model.p.iter().map(|&s| arena.symbol(s)).collect();

    let mut flow = transported(xi, &v, model, arena);
    for (at, &x) in xi.iter().enumerate() {
        let drift = arena.diff(x, model.time);
        flow[at] = arena.add(flow[at], drift);
    }
    let (lagrangian, scale) = scaled(model.lagrangian, arena);
    let along_q = pairing(lagrangian, &model.q, xi, arena);
    let along_v = pairing(lagrangian, &model.v, &flow, arena);
    let mut changes = vec![Change {
        of: Changed::Function("the Lagrangian".to_owned()),
        rate: arena.add(along_q, along_v),
        scale: scale * unit,
    }];
    for noise in &model.noises {
        let (hamiltonian, scale) = scaled(noise.hamiltonian, arena);
        let along_q = pairing(hamiltonian, &model.q, xi, arena);
        let kick: Vec<Expr> = model
            .p
            .iter()
            .map(|&s| arena.diff(hamiltonian, s))
            .collect();
        let turned = transported(xi, &kick, model, arena);
        let turned = dot(&p, &turned, arena);
        let mut rate = arena.sub(along_q, turned);
        if noise.is_gamma {
            // the noise Hamiltonian is −γ
            rate = arena.neg(rate);
        }
        changes.push(Change {
            of: Changed::Function(format!("the noise `{}`", noise.name)),
            rate,
            scale: scale * unit,
        });
    }
    if let Some(force) = &model.force {
        let names: Vec<String> = block
            .forces
            .iter()
            .map(|part| format!("`{}`", part.name))
            .collect();
        let scale = arena.scale_of(force);
        let force: Vec<Expr> = force.iter().map(|&f| arena.scale(scale, f)).collect();
        changes.push(Change {
            of: Changed::Work(names.join(" + ")),
            rate: dot(&force, xi, arena),
            scale: scale * unit,
        });
    }
    changes
}

/// `⟨∂f/∂x, by⟩`.
fn pairing(f: Expr, x: &[Symbol], by: &[Expr], arena: &mut Arena) -> Expr {
    let gradient: Vec<Expr> = x.iter().map(|&s| arena.diff(f, s)).collect();
    dot(&gradient, by, arena)
}

fn dot(a: &[Expr], b: &[Expr], arena: &mut Arena) -> Expr {
    let terms: Vec<(f64, Expr)> = a
        .iter()
        .zip(b)
        .map(|(&a, &b)| (1.0, arena.mul(a, b)))
        .collect();
    arena.sum(0.0, &terms)
}

/// `Dξ by`.
fn transported(xi: &[Expr], by: &[Expr], model: &Model, arena: &mut Arena) -> Vec<Expr> {
    xi.iter()
        .map(|&x| pairing(x, &model.q, by, arena))
        .collect()
}

fn momentum(
    generator: &Generator,
    surely: Vanishing,
    model: &Model,
    arena: &mut Arena,
) -> MomentumMap {
    let p: Vec<Expr> = model.p.iter().map(|&s| arena.symbol(s)).collect();
    let value = dot(&p, &generator.field, arena);
    let mut affine = true;
    for &x in &generator.field {
        affine &= !arena.contains(x, model.time);
        for &q in &model.q {
            let slope = arena.diff(x, q);
            for &other in &model.q {
                let second = arena.diff(slope, other);
                affine &= arena.is_zero(second);
            }
        }
    }
    MomentumMap {
        name: generator.name.clone(),
        value,
        affine,
        surely,
    }
}
