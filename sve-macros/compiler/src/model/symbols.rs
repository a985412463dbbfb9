//! The symbols of the arena and their meanings.

use proc_macro2::TokenStream;

use super::Unknown;
use super::configuration::Configuration;
use crate::algebra::Symbol;

/// The quantity that a symbol denotes.
#[derive(Clone, Debug)]
pub(crate) enum Meaning {
    /// A field of the user's struct, or a number in the inputs of a step: its name, and the
    /// expression that reads it.
    Parameter {
        name: String,
        access: TokenStream,
        /// Its number among the inputs, which differ from step to step and from path to path.
        input: Option<usize>,
    },
    Time,
    StepSize,
    /// An entry of the configuration, or a component of the velocity or the momentum, of the
    /// continuous system.
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
    /// An entry of a rotation at a node of a rule. Its value replaces it once the action is
    /// differentiated.
    NodeEntry(usize),
    /// A parameter of rotations, which occurs in tests of identities only
    /// (`Configuration::parametrised`).
    Attitude(usize),
    /// A component of the momentum at the end of the step, which follows from the action.
    End(usize),
    /// Half the width of a box around a point, in the direction of a coordinate.
    Radius(Argument),
    /// A kept loop of a scene, and a read with an index (`model/scene.rs`).
    Sum(usize),
    Slot(usize),
    /// A number in the loop over the nodes of a scene: of a row, a column or an increment.
    Read(usize),
    /// The value of a sum of a scene, which is computed before the loops whose terms read it.
    Total(usize),
    /// A number in a loop that is being read, which occurs in no system.
    Partial,
}

/// A coordinate of the space of times, configurations, velocities and momenta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Argument {
    Time,
    Position(usize),
    Velocity(usize),
    Momentum(usize),
}

/// `q₀` or `p₀`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Position,
    Momentum,
}

/// The meanings of all symbols, indexed by symbol.
#[derive(Clone, Default)]
pub(crate) struct Symbols {
    meanings: Vec<Meaning>,
    /// The kinds of the entries of the configuration and of the components of velocity and
    /// momentum.
    pub(crate) configuration: Configuration,
    /// The energy on which a path of a system with a time scale stays, which a step reads as it
    /// reads an input.
    pub(crate) energy: Option<Symbol>,
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

    /// Returns the number of numbers in the inputs of a step.
    pub(crate) fn inputs(&self) -> usize {
        let is_input = |m: &&Meaning| matches!(m, Meaning::Parameter { input: Some(_), .. });
        self.meanings.iter().filter(is_input).count()
    }

    /// Returns a parameter as the source spells it, without `self`.
    pub(crate) fn source(&self, parameter: Symbol) -> String {
        match self.meaning(parameter) {
            Meaning::Parameter { access, .. } if self.energy != Some(parameter) => {
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
            Meaning::Sum(i) => format!("sum_{i}"),
            Meaning::Slot(i) => format!("slot_{i}"),
            Meaning::Read(i) => format!("read_{i}"),
            Meaning::Total(i) => format!("S_{i}"),
            Meaning::Partial => "partial".to_owned(),
            Meaning::Radius(Argument::Time) => "radius_t".to_owned(),
            Meaning::Radius(Argument::Position(i)) => format!("radius_q{i}"),
            Meaning::Radius(Argument::Velocity(i)) => format!("radius_v{i}"),
            Meaning::Radius(Argument::Momentum(i)) => format!("radius_p{i}"),
        }
    }
}
