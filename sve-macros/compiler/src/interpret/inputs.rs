//! The argument `u`, whose numbers are parameters that are given to each step.

use proc_macro2::Literal;
use quote::quote;
use syn::Type;
use syn::spanned::Spanned;

use super::Lowering;
use super::types::Shape;
use super::value::Value;
use crate::algebra::Symbol;
use crate::model::Meaning;
use crate::syntax::readable;

/// The argument `u` of functions.
pub(super) struct Input {
    /// Its type, as it is written.
    ty: String,
    value: Value,
}

impl Lowering<'_> {
    /// Declares a parameter for each number of the inputs.
    pub(super) fn declare_inputs(&mut self) -> Option<()> {
        let ty = self.block.inputs.as_ref()?;
        let shape = self.shape(ty)?;
        let is_row = match &shape {
            Shape::Scalar => true,
            Shape::Vector(vector) => vector.columns == 1,
            Shape::Array(_, inner) => **inner == Shape::Scalar,
        };
        if !is_row || shape.len() == 0 {
            let message = "inputs are an `f64`, a `[f64; K]` or a vector such as `Vector3<f64>`";
            return self.refuse(ty, message);
        }
        let symbols: Vec<Symbol> = (0..shape.len())
            .map(|k| {
                let (name, place) = (format!("u_{k}"), Literal::usize_unsuffixed(k));
                self.fields.reserve(&name);
                let access = quote!(self.u[#place]);
                self.symbols.declare(Meaning::Parameter {
                    name,
                    access,
                    input: Some(k),
                })
            })
            .collect();
        let mut symbols = symbols.into_iter();
        let mut next = || {
            let symbol = symbols.next().map(|symbol| self.arena.symbol(symbol));
            symbol.map_or(Value::Poison, Value::Scalar)
        };
        self.input = Some(Input {
            ty: readable(ty),
            value: shape.fill(&mut next),
        });
        Some(())
    }

    /// Declares the energy of a path, if the block has a time scale.
    pub(super) fn declare_energy(&mut self) {
        if self.block.time_scale.is_none() {
            return;
        }
        let name = "E".to_owned();
        self.fields.reserve(&name);
        self.symbols.energy = Some(self.symbols.declare(Meaning::Parameter {
            name,
            access: quote!(self.u[0]),
            input: Some(0),
        }));
    }

    /// Returns the value of an argument `u` of this type.
    pub(super) fn input_of(&self, ty: &Type) -> Value {
        match &self.input {
            Some(input) if input.ty == readable(ty) => input.value.clone(),
            // another type has been reported
            _ => Value::Poison,
        }
    }

    /// Reports a field `u` beside inputs or a time scale: derived code reads the inputs, or the
    /// energy, under this name.
    pub(super) fn check_fields_beside_inputs(&mut self) {
        let beside = match (&self.block.inputs, &self.block.time_scale) {
            (Some(_), _) => "the argument `u` of the same block",
            (None, Some(_)) => "a time scale, whose steps read the energy by this name",
            (None, None) => return,
        };
        for path in self.fields.paths() {
            let access = path.access();
            let text = access.to_string().replace(' ', "");
            let rest = text.strip_prefix("self.u");
            if rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '['])) {
                // `self . u`
                let name = access.clone().into_iter().nth(2);
                self.errors.push(
                    name.map_or_else(|| access.span(), |name| name.span()),
                    format!("a field `u` beside {beside}: rename the field"),
                );
            }
        }
    }
}
