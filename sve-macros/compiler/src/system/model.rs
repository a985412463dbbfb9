//! The mechanical system as expressions, which all later stages read.
//!
//! Invariant: the Lagrangian and the force contain only the symbols of time, `q`, `v` and parameters, a noise Hamiltonian only those
//! of time, `q`, `p` and parameters, a generator only those of time, `q` and parameters.

use proc_macro2::TokenStream;

use crate::algebra::{Arena, Expr, Identity, Node, Symbol};
use crate::system::configuration::Configuration;
use crate::system::degeneracy::Degeneracy;

/// The quantity for which a symbol stands.
#[derive(Clone, Debug)]
pub(crate) enum Meaning {
    /// A field of the user's struct: its name, and the expression that reads it.
    Parameter {
        name: String,
        access: TokenStream,
    },
    Time,
    StepSize,
    /// Entry of the configuration, component of the velocity or of the momentum of the continuous system.
    Position(usize),
    Velocity(usize),
    Momentum(usize),
    /// Component of the state at the start of a step.
    Start(Quantity, usize),
    /// Increment of a Wiener process.
    Wiener(usize),
    /// An unknown of the step.
    Unknown(Unknown),
    /// The limit of an unknown for h → 0 without noise.
    Limit(Unknown),
    /// Entry of a rotation at a node of a rule, for which its value is substituted once the action is differentiated.
    NodeEntry(usize),
    /// A parameter of rotations, on which only tests of identities depend (`Configuration::parametrised`).
    Attitude(usize),
    /// Component of the momentum at the end of the step, which the action gives.
    End(usize),
    /// Half the width of a box around a point, in the direction of a coordinate.
    Radius(Axis),
}

/// A coordinate of the space of times, configurations, velocities and momenta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axis {
    Time,
    Position(usize),
    Velocity(usize),
    Momentum(usize),
}

/// A quantity at a quadrature node of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AtNode {
    /// Number of the node.
    pub(crate) node: usize,
    pub(crate) quantity: NodeQuantity,
}

impl AtNode {
    /// Returns the identity of the intermediate result that stands for the quantity in the arena.
    pub(crate) fn identity(self) -> Identity {
        let (kind, index) = match self.quantity {
            NodeQuantity::Time => (0, 0),
            NodeQuantity::Position(i) => (1, i),
            NodeQuantity::Velocity(i) => (2, i),
        };
        Identity((self.node as u64) << 34 | kind << 32 | index as u64)
    }

    /// Returns the quantity for which an expression stands; `None` if the expression is not a quantity at a node.
    pub(crate) fn of(expr: Expr, arena: &Arena) -> Option<Self> {
        let Node::Opaque(_, Some(Identity(bits))) = *arena.node(expr) else {
            return None;
        };
        let index = (bits & 0xffff_ffff) as usize;
        let quantity = match bits >> 32 & 3 {
            0 => NodeQuantity::Time,
            1 => NodeQuantity::Position(index),
            _ => NodeQuantity::Velocity(index),
        };
        Some(Self {
            node: (bits >> 34) as usize,
            quantity,
        })
    }
}

/// The quantities at a quadrature node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeQuantity {
    Time,
    /// A component of the position.
    Position(usize),
    /// A component of the velocity.
    Velocity(usize),
}

impl std::fmt::Display for AtNode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let node = match self.node {
            0 => "node".to_owned(),
            number => format!("node{number}"),
        };
        match self.quantity {
            NodeQuantity::Time => write!(f, "t_{node}"),
            NodeQuantity::Position(i) => write!(f, "q_{node}_{i}"),
            NodeQuantity::Velocity(i) => write!(f, "v_{node}_{i}"),
        }
    }
}

/// An unknown of the step: its family, and the coordinate to which it belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unknown {
    pub(crate) family: Family,
    pub(crate) index: usize,
}

/// The kinds of unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// `q₁ − q₀`.
    Displacement,
    Velocity,
    /// The velocity of a path at a stage, beside that at which L is evaluated.
    StageVelocity,
    Momentum,
    Acceleration,
    /// The multiplier of the equation that defines the velocity of `taylor2`, a momentum.
    VelocityMultiplier,
    /// The multiplier of the equation that defines the acceleration of `taylor2`.
    AccelerationMultiplier,
    /// The multiplier of a constraint at the start of the step, an impulse.
    StartMultiplier,
    /// The multiplier of a constraint at the end of the step.
    EndMultiplier,
    /// The velocity of p₁ at q₁.
    EndVelocity,
    /// The distance from q₀ of a coordinate that is a variable of the node.
    NodeDisplacement,
    /// The multiplier that keeps p = α(q) at the end of the step: a displacement of both ends.
    Projection,
}

impl Family {
    pub(crate) fn is_multiplier_of_constraint(self) -> bool {
        matches!(self, Self::StartMultiplier | Self::EndMultiplier)
    }

    /// Whether the unknown is the distance from a point that it does not leave in the limit of no noise and h → 0.
    pub(crate) fn is_displacement(self) -> bool {
        matches!(
            self,
            Self::Displacement | Self::NodeDisplacement | Self::Projection
        )
    }
}

impl Unknown {
    /// Returns the meaning of each symbol of a family, for [`Symbols::declare_all`].
    pub(crate) fn of(family: Family) -> impl Fn(usize) -> Meaning {
        move |index| Meaning::Unknown(Self { family, index })
    }
}

impl std::fmt::Display for Unknown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let letter = match self.family {
            Family::Displacement => "d",
            Family::Velocity => "v",
            Family::StageVelocity => "u",
            Family::Momentum => "p",
            Family::Acceleration => "a",
            Family::VelocityMultiplier | Family::EndMultiplier => "mu",
            Family::AccelerationMultiplier => "nu",
            Family::StartMultiplier | Family::Projection => "lambda",
            Family::EndVelocity => "v1",
            Family::NodeDisplacement => "e",
        };
        write!(f, "{letter}_{}", self.index)
    }
}

/// `q₀` or `p₀`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    Momentum,
}

/// A noise Hamiltonian: `−γ` or `H₁`.
#[derive(Clone)]
pub(crate) struct NoiseTerm {
    /// Source name, with an index if the function returns an array.
    pub(crate) name: String,
    /// Whether the user wrote γ; the Hamiltonian is then −γ.
    pub(crate) is_gamma: bool,
    /// Whether the momentum along the constraints is to take the place of p.
    pub(crate) is_tangent: bool,
    pub(crate) hamiltonian: Expr,
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

/// The meanings of all symbols, indexed by symbol.
#[derive(Clone, Default)]
pub(crate) struct Symbols {
    meanings: Vec<Meaning>,
    /// What the entries of the configuration and the components of velocity and momentum are.
    pub(crate) configuration: Configuration,
}

impl Symbols {
    /// Creates a symbol.
    pub(crate) fn declare(&mut self, meaning: Meaning) -> Symbol {
        self.meanings.push(meaning);
        Symbol(self.meanings.len() as u32 - 1)
    }

    pub(crate) fn declare_all(
        &mut self,
        n: usize,
        meaning: impl Fn(usize) -> Meaning,
    ) -> Vec<Symbol> {
        (0..n).map(|i| self.declare(meaning(i))).collect()
    }

    pub(crate) fn meaning(&self, symbol: Symbol) -> &Meaning {
        &self.meanings[symbol.0 as usize]
    }

    /// Returns the symbols of the parameters, in the order of their first use.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = Symbol> + '_ {
        (0..self.meanings.len() as u32)
            .map(Symbol)
            .filter(|&s| matches!(self.meaning(s), Meaning::Parameter { .. }))
    }

    /// Returns a parameter as it is written in the source, without `self`.
    pub(crate) fn source(&self, parameter: Symbol) -> String {
        match self.meaning(parameter) {
            Meaning::Parameter { access, .. } => {
                let path = access.to_string().replace(' ', "");
                path.strip_prefix("self.").unwrap_or(&path).to_owned()
            }
            _ => self.name(parameter),
        }
    }

    pub(crate) fn meanings(&self) -> &[Meaning] {
        &self.meanings
    }

    /// Returns the name of a symbol in generated code and messages.
    pub(crate) fn name(&self, symbol: Symbol) -> String {
        match self.meaning(symbol) {
            Meaning::Parameter { name, .. } => name.clone(),
            Meaning::Unknown(unknown) => unknown.to_string(),
            Meaning::Limit(unknown) => format!("{unknown}_limit"),
            Meaning::Time => "t".to_owned(),
            Meaning::StepSize => "h".to_owned(),
            Meaning::Position(i) => format!("q_{i}"),
            Meaning::Velocity(i) => format!("v_{i}"),
            Meaning::Momentum(i) => format!("p_{i}"),
            Meaning::Start(Quantity::Position, i) => format!("q0_{i}"),
            Meaning::Start(Quantity::Momentum, i) => format!("p0_{i}"),
            Meaning::Wiener(i) => format!("dw_{i}"),
            Meaning::NodeEntry(i) => format!("node_{i}"),
            Meaning::Attitude(i) => format!("attitude_{i}"),
            Meaning::End(i) => format!("p1_{i}"),
            Meaning::Radius(Axis::Time) => "radius_t".to_owned(),
            Meaning::Radius(Axis::Position(i)) => format!("radius_q{i}"),
            Meaning::Radius(Axis::Velocity(i)) => format!("radius_v{i}"),
            Meaning::Radius(Axis::Momentum(i)) => format!("radius_p{i}"),
        }
    }
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
    /// What L is if it does not determine every velocity; known after the stage `system`.
    pub(crate) degeneracy: Option<Degeneracy>,
    pub(crate) noises: Vec<NoiseTerm>,
    /// F, if there is a force.
    pub(crate) force: Option<Vec<Expr>>,
    pub(crate) symmetries: Vec<Generator>,
    pub(crate) constraints: Vec<Constraint>,
    /// The paths that are read as constants of `std::f64::consts` and may lead elsewhere, each with the value it is read as.
    pub(crate) constants: Vec<(TokenStream, f64)>,
}

impl Model {
    pub(crate) fn dof(&self) -> usize {
        self.v.len()
    }

    pub(crate) fn configuration(&self) -> &Configuration {
        &self.symbols.configuration
    }

    /// Returns the derivative of an expression in each direction of the configuration.
    pub(crate) fn gradient(&self, expr: Expr, arena: &mut Arena) -> Vec<Expr> {
        self.configuration().gradient(expr, &self.q, arena)
    }

    /// Returns an expression as a function of free parameters of the rotations. It vanishes identically if the expression vanishes for all rotations.
    pub(crate) fn on_rotations(&self, expr: Expr, arena: &mut Arena) -> Expr {
        if !self.configuration().has_rotations() {
            return expr;
        }
        let entries = self
            .configuration()
            .parametrised(&self.q, &self.attitude, arena);
        arena.substitute(expr, &entries)
    }

    /// The model with one more noise Hamiltonian.
    pub(crate) fn with_noise(&self, noise: NoiseTerm) -> Self {
        let mut model = self.clone();
        model.noises.push(noise);
        model
    }
}
