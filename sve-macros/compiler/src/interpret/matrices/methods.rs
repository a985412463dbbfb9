//! Calls of the methods in the table: their arguments, and the types of parameters that follow from these.

use proc_macro2::Span;
use syn::ExprMethodCall;

use super::formulas::MINORS;
use super::refused::unknown_type;
use super::table::{Given, Gives, METHODS, Method, Receiver, Takes};
use super::{Kind, Matrix, MatrixType, refused, views};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats::{self, are, plural};
use crate::interpret::value::Value;

/// Whether vectors or matrices have a method of this name.
pub(super) fn is_method(name: &str) -> bool {
    METHODS.iter().any(|method| method.name == name)
}

/// The names of methods, for suggestions.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|method| method.name)
}

/// The type that a parameter must have for a method and its first argument; nothing where several types are possible.
fn type_of_parameter(method: &Method, first: Option<&Value>) -> Option<MatrixType> {
    match (method.receiver, method.takes.first(), first) {
        (_, Some(Takes::Same), Some(Value::Matrix(other))) => Some(other.ty.plain()),
        // a cross product of columns, unless the argument is known to be a row
        (Receiver::Of(length), Some(Takes::Same), Some(_)) => Some(MatrixType::vector(length)),
        _ => None,
    }
}

impl Lowering<'_> {
    /// A method of the table; nothing if it has none of this name.
    pub(super) fn tabled_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Matrix<Value>,
        arguments: &[Argument],
        at: Span,
    ) -> Option<Value> {
        let name = call.method.to_string();
        let method = METHODS.iter().find(|method| method.name == name)?;
        let ty = receiver.ty;
        if !method.receiver.accepts(ty) {
            let message = format!(
                "a `{ty}` has no `{name}`: it is a method of {}",
                method.receiver.described()
            );
            return Some(self.refuse(&call.method, message));
        }
        if name == "determinant" && ty.rows > MINORS {
            let message = format!(
                "the determinant of a `{ty}` is too long a formula: the limit is {MINORS} rows"
            );
            return Some(self.refuse(&call.method, message));
        }
        if arguments.len() != method.takes.len() {
            let takes = plural(method.takes.len(), "argument");
            let message = format!("`{name}` takes {takes}, here {}", are(arguments.len()));
            return Some(self.refuse(&call.method, message));
        }
        let mut given = Given::default();
        for (takes, argument) in method.takes.iter().zip(arguments) {
            if self
                .given(&mut given, *takes, ty, argument, &name)
                .is_none()
            {
                return Some(Value::Poison);
            }
        }
        let receiver = self.numbers(receiver, &at);
        let Some(receiver) = receiver.filter(|m| self.work(m.entries.len(), call)) else {
            return Some(Value::Poison);
        };
        Some(match method.gives {
            Gives::Number(compute) => match compute(self.arena, &receiver, &given) {
                Some(number) => self.computed_number(number, &call.method),
                None => Value::Poison,
            },
            Gives::Matrix(compute) => match compute(self.arena, &receiver, &given) {
                Some(matrix) => self.computed_matrix(matrix, &call.method),
                None => Value::Poison,
            },
        })
    }

    /// Reads an argument of a method of a `ty`; nothing after an error.
    fn given(
        &mut self,
        given: &mut Given,
        takes: Takes,
        ty: MatrixType,
        argument: &Argument,
        name: &str,
    ) -> Option<()> {
        match takes {
            Takes::Same => {
                let matrix = self.matrix_argument(argument, ty.plain(), name)?;
                given.matrices.push(matrix);
            }
            Takes::Vector => {
                let matrix = self.matrix_argument(argument, MatrixType::vector(ty.rows), name)?;
                given.matrices.push(matrix);
            }
            Takes::Number => given
                .numbers
                .push(self.scalar(&argument.value, &argument.at)?),
            Takes::Row => given.index = self.count_argument(argument, ty.rows, "rows")?,
            Takes::Column => given.index = self.count_argument(argument, ty.columns, "columns")?,
        }
        Some(())
    }

    /// An argument that is a matrix of this size; a parameter gets its type from there.
    pub(super) fn matrix_argument(
        &mut self,
        argument: &Argument,
        ty: MatrixType,
        name: &str,
    ) -> Option<Matrix<Expr>> {
        match &argument.value {
            Value::Matrix(matrix) if matrix.ty.has_size_of(ty) => {
                self.numbers(matrix, &argument.at)
            }
            Value::Field(path) if !path.is_self() && !path.is_number() => {
                self.numbers(&Matrix::of_field(path, ty), &argument.at)
            }
            Value::Poison => None,
            other => {
                let message = format!("`{name}` takes a `{ty}` here, and this is {}", other.kind());
                self.refuse(&argument.at, message);
                None
            }
        }
    }

    /// An argument that is an index below `bound`.
    fn count_argument(&mut self, argument: &Argument, bound: usize, what: &str) -> Option<usize> {
        let index = self.index_of(&argument.value, &argument.at)?;
        if index < bound {
            return Some(index);
        }
        let message = format!("index {index} is out of range: there are {bound} {what}");
        self.refuse(&argument.at, message);
        None
    }

    /// A method of vectors of a parameter, whose type is found from the arguments.
    pub(super) fn method_of_field(
        &mut self,
        call: &ExprMethodCall,
        path: &FieldPath,
        at: Span,
    ) -> Option<Value> {
        let name = call.method.to_string();
        if views::is_method(&name, call.turbofish.is_some()) {
            let example = self.example_of_part(&name);
            return Some(self.refuse(&at, unknown_type(path, &example)));
        }
        let is_of_numbers = floats::is_method(&name) || floats::other_name(&name).is_some();
        if refused::is_listed(&name) && !is_of_numbers {
            return Some(self.refuse(&at, refused::refusal(&name)));
        }
        let method = METHODS.iter().find(|method| method.name == name)?;
        let arguments: Vec<Argument> = call.args.iter().map(|a| self.argument(a)).collect();
        if arguments
            .iter()
            .any(|argument| matches!(argument.value, Value::Poison))
        {
            return Some(Value::Poison);
        }
        let first = arguments.first().map(|argument| &argument.value);
        let Some(ty) = type_of_parameter(method, first).filter(|_| !path.is_number()) else {
            let message = if path.is_number() {
                self.no_method_of_number(&name)
            } else {
                unknown_type(path, &self.example_of_type(Some(method)))
            };
            return Some(self.refuse(&at, message));
        };
        let receiver = Matrix::of_field(path, ty);
        self.tabled_method(call, &receiver, &arguments, at)
    }

    /// A vector that a parameter may be, for messages.
    pub(in crate::interpret) fn example_of_vector(&mut self) -> String {
        self.example_of_type(None)
    }

    /// A type that a parameter may have whose part, entries or size are asked for.
    fn example_of_part(&mut self, name: &str) -> String {
        let example = self.example_of_vector();
        if views::is_of_matrices(name) {
            example.replacen("Vector", "Matrix", 1)
        } else {
            example
        }
    }

    /// What to say of a method of vectors that is called on a number.
    pub(super) fn no_method_of_number(&mut self, name: &str) -> String {
        let method = METHODS.iter().find(|method| method.name == name);
        let example = self.example_of_type(method);
        let field = if example.starts_with('V') { 'g' } else { 'm' };
        format!(
            "`{name}` is a method of vectors and matrices, and this is a number: in a product a field is taken for one, unless its type is written, as in `let {field}: {example} = self.{field};`"
        )
    }

    /// A type that a parameter may have, for messages: one that has the method, and the size of the coordinates where they are a
    /// vector.
    pub(super) fn example_of_type(&mut self, method: Option<&Method>) -> String {
        let block = self.block;
        let coordinates = self.matrix_type(block.coordinates());
        let n = coordinates.map_or(3, |ty| ty.rows);
        let of_matrices = ["transpose", "adjoint", "row", "column"];
        let ty = match method {
            Some(method) => match method.receiver {
                Receiver::Of(length) => MatrixType::vector(length),
                Receiver::Square => MatrixType::matrix(n, n),
                Receiver::Rotation => MatrixType {
                    kind: Kind::Rotation,
                    ..MatrixType::matrix(n.clamp(2, 3), n.clamp(2, 3))
                },
                _ if of_matrices.contains(&method.name) => MatrixType::matrix(n, n),
                _ => MatrixType::vector(n),
            },
            None => MatrixType::vector(n),
        };
        ty.to_string()
    }
}
