//! The mechanical system as expressions, which all later stages read.
//!
//! Invariant: the Lagrangian and the forces contain only the symbols of time, `q`, `v` and
//! parameters. A noise Hamiltonian contains only time, `q`, `p` and parameters, and a generator
//! only time, `q` and parameters.

use proc_macro2::TokenStream;

pub(crate) mod chart;
pub(crate) mod configuration;
pub(crate) mod domain;
mod names;
mod nodes;
pub(crate) mod scene;
mod symbols;
pub(crate) mod time_scale;
mod unknowns;

use crate::algebra::{Arena, Bits, Expr, Node, Symbol};
use configuration::Configuration;
pub(crate) use names::{SymbolNames, unknown};
pub(crate) use nodes::{AtNode, END, NodeQuantity};
pub(crate) use symbols::{Argument, Meaning, Quantity, Symbols};
pub(crate) use unknowns::{Family, Unknown};

/// The noise of one Wiener process: the Hamiltonian `−γ` or `H₁`, or a force. The term of the
/// option `weak2` may have both.
#[derive(Clone)]
pub(crate) struct NoiseTerm {
    /// Source name, with an index if the function returns an array.
    pub(crate) name: String,
    pub(crate) kind: NoiseKind,
    /// G, which is zero if the user wrote a force.
    pub(crate) hamiltonian: Expr,
    /// f, which adds `f ∘ dW` to dp, if there is one.
    pub(crate) force: Option<Vec<Expr>>,
}

/// A noise as the user wrote it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoiseKind {
    /// γ; the Hamiltonian is −γ.
    Gamma,
    H1,
    /// An H₁ in which the momentum along the constraints replaces p.
    TangentH1,
    /// A force f(q, v).
    Force,
}

/// A generator ξ of a symmetry.
#[derive(Clone)]
pub(crate) struct Generator {
    /// Source name.
    pub(crate) name: String,
    pub(crate) field: Vec<Expr>,
}

/// A holonomic constraint, φ = 0.
#[derive(Clone)]
pub(crate) struct Constraint {
    /// Source name, with an index if the function returns an array.
    pub(crate) name: String,
    /// φ.
    pub(crate) value: Expr,
}

/// The names of the numbers that a state stores.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CoordinateNames {
    pub(crate) configuration: Vec<String>,
    pub(crate) momenta: Vec<String>,
}

/// The mechanical system.
#[derive(Clone)]
pub(crate) struct Model {
    pub(crate) symbols: Symbols,
    pub(crate) time: Symbol,
    /// The entries of the configuration.
    pub(crate) q: Vec<Symbol>,
    pub(crate) v: Vec<Symbol>,
    pub(crate) p: Vec<Symbol>,
    /// The parameters of rotations, see [`on_rotations`](Self::on_rotations).
    pub(crate) attitude: Vec<Symbol>,
    pub(crate) names: CoordinateNames,
    pub(crate) lagrangian: Expr,
    pub(crate) noises: Vec<NoiseTerm>,
    /// F, if there is a force.
    pub(crate) force: Option<Vec<Expr>>,
    pub(crate) symmetries: Vec<Generator>,
    pub(crate) constraints: Vec<Constraint>,
    /// s, if there is a time scale. `lagrangian` is then that of the scaled time (`time_scale.rs`).
    pub(crate) time_scale: Option<Expr>,
    /// The paths that are read as constants of `std::f64::consts` and may refer to something else,
    /// each with the value of the constant.
    pub(crate) constants: Vec<(TokenStream, f64)>,
}

impl Model {
    pub(crate) fn dof(&self) -> usize {
        self.v.len()
    }

    /// Returns the formulas of L, the noises and the force.
    pub(crate) fn formulas(&self) -> impl Iterator<Item = Expr> + '_ {
        let noises = self.noises.iter().flat_map(|noise| {
            let force = noise.force.iter().flatten();
            force.copied().chain([noise.hamiltonian])
        });
        let force = self.force.iter().flatten().copied();
        noises.chain(force).chain([self.lagrangian])
    }

    pub(crate) fn configuration(&self) -> &Configuration {
        &self.symbols.configuration
    }

    /// Returns the derivative of an expression in each direction of the configuration.
    pub(crate) fn gradient(&self, expr: Expr, arena: &mut Arena) -> Vec<Expr> {
        self.configuration().gradient(expr, &self.q, arena)
    }

    /// Returns an expression as a function of free parameters of the rotations. It vanishes
    /// identically if the expression vanishes for all rotations.
    pub(crate) fn on_rotations(&self, expr: Expr, arena: &mut Arena) -> Expr {
        if !self.configuration().has_rotations() {
            return expr;
        }
        let entries = self
            .configuration()
            .parametrised(&self.q, &self.attitude, arena);
        arena.substitute(expr, &entries)
    }

    /// Returns `∂φ/∂t + Dφ v` in the model's variables.
    pub(crate) fn rate(&self, value: Expr, arena: &mut Arena) -> Expr {
        let mut terms = vec![(1.0, arena.diff(value, self.time))];
        for (&q, &v) in self.q.iter().zip(&self.v) {
            let slope = arena.diff(value, q);
            let v = arena.symbol(v);
            terms.push((1.0, arena.mul(slope, v)));
        }
        arena.sum(0.0, &terms)
    }

    /// Returns the magnitude to which rounding errors of φ are relative: the sum of the magnitudes
    /// of its terms, and `Σ |∂φ/∂q| |q|` for the rounding of the coordinates.
    pub(crate) fn magnitude(&self, value: Expr, arena: &mut Arena) -> Expr {
        let (constant, terms) = match arena.node(value) {
            Node::Sum(constant, terms) => (constant.get(), terms.clone()),
            _ => (0.0, vec![(value, Bits::new(1.0))]),
        };
        let mut sizes = Vec::new();
        for (term, c) in terms {
            sizes.push((c.get().abs(), arena.abs(term)));
        }
        for &q in &self.q {
            let slope = arena.diff(value, q);
            let q = arena.symbol(q);
            let moved = arena.mul(slope, q);
            sizes.push((1.0, arena.abs(moved)));
        }
        arena.sum(constant.abs(), &sizes)
    }

    /// Returns the symbols of the configuration and of the velocity.
    pub(crate) fn q_and_v(&self) -> Vec<Symbol> {
        [&self.q[..], &self.v].concat()
    }

    /// Returns all forces: F and those of the noises.
    pub(crate) fn forces(&self) -> impl Iterator<Item = &Vec<Expr>> {
        let of_noises = self.noises.iter().filter_map(|noise| noise.force.as_ref());
        self.force.iter().chain(of_noises)
    }

    /// Returns whether a force depends on velocities.
    pub(crate) fn reads_velocity(&self, force: &[Expr], arena: &Arena) -> bool {
        let mut all = self.v.iter();
        all.any(|&v| force.iter().any(|&f| arena.contains(f, v)))
    }

    /// Returns the model with one more noise.
    pub(crate) fn with_noise(&self, noise: NoiseTerm) -> Self {
        let mut model = self.clone();
        model.noises.push(noise);
        model
    }
}
