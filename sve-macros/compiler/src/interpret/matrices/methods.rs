//! Calls of the methods in the table: their arguments, and the types of parameters that follow from the arguments.

use proc_macro2::Span;
use syn::ExprMethodCall;

use super::formulas::MAX_DETERMINANT;
use super::refused::unknown_type;
use super::table::{ArgumentKind, CallArguments, METHODS, Method, MethodResult, Receiver};
use super::{Kind, Matrix, MatrixType, refused, views};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats::{self, are, plural};
use crate::interpret::value::Value;

/// Returns whether vectors or matrices have a method of this name.
pub(super) fn is_method(name: &str) -> bool {
    METHODS.iter().any(|method| method.name == name)
}

/// Returns the names of the methods, for suggestions.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    METHODS.iter().map(|method| method.name)
}

/// Returns the type that a parameter must have for a method and its first argument; `None` if several types are possible.
fn type_of_parameter(method: &Method, first: Option<&Value>) -> Option<MatrixType> {
    match (method.receiver, method.takes.first(), first) {
        (_, Some(ArgumentKind::Same), Some(Value::Matrix(other))) => Some(other.ty.plain()),
        // a cross product of columns, unless the argument is known to be a row
        (Receiver::OfLength(length), Some(ArgumentKind::Same), Some(_)) => {
            Some(MatrixType::vector(length))
        }
        _ => None,
    }
}

impl Lowering<'_> {
    /// Calls a method of the table; `None` if the table has no method of this name.
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
        if name == "determinant" && ty.rows > MAX_DETERMINANT {
            let message = format!(
                "the determinant of a `{ty}` is too long a formula: the limit is {MAX_DETERMINANT} rows"
            );
            return Some(self.refuse(&call.method, message));
        }
        if arguments.len() != method.takes.len() {
            let takes = plural(method.takes.len(), "argument");
            let message = format!("`{name}` takes {takes}, here {}", are(arguments.len()));
            return Some(self.refuse(&call.method, message));
        }
        let mut given = CallArguments::default();
        for (takes, argument) in method.takes.iter().zip(arguments) {
            if self
                .add_argument(&mut given, *takes, ty, argument, &name)
                .is_none()
            {
                return Some(Value::Poison);
            }
        }
        let receiver = self.numbers(receiver, &at);
        let Some(receiver) = receiver.filter(|m| self.work(m.entries.len(), call)) else {
            return Some(Value::Poison);
        };
        Some(match method.result {
            MethodResult::Number(compute) => match compute(self.arena, &receiver, &given) {
                Some(number) => self.computed_number(number, &call.method),
                None => Value::Poison,
            },
            MethodResult::Matrix(compute) => match compute(self.arena, &receiver, &given) {
                Some(matrix) => self.computed_matrix(matrix, &call.method),
                None => Value::Poison,
            },
        })
    }

    /// Evaluates an argument of a method of a `ty`; `None` after an error.
    fn add_argument(
        &mut self,
        given: &mut CallArguments,
        takes: ArgumentKind,
        ty: MatrixType,
        argument: &Argument,
        name: &str,
    ) -> Option<()> {
        match takes {
            ArgumentKind::Same => {
                let matrix = self.matrix_argument(argument, ty.plain(), name)?;
                given.matrices.push(matrix);
            }
            ArgumentKind::Vector => {
                let matrix = self.matrix_argument(argument, MatrixType::vector(ty.rows), name)?;
                given.matrices.push(matrix);
            }
            ArgumentKind::Number => given
                .numbers
                .push(self.scalar(&argument.value, &argument.at)?),
            ArgumentKind::Row => given.index = self.count_argument(argument, ty.rows, "rows")?,
            ArgumentKind::Column => {
                given.index = self.count_argument(argument, ty.columns, "columns")?;
            }
        }
        Some(())
    }

    /// Evaluates an argument that must be a matrix of this size. A parameter gets this type.
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

    /// Evaluates an argument that must be an index below `bound`.
    fn count_argument(&mut self, argument: &Argument, bound: usize, what: &str) -> Option<usize> {
        let index = self.index_of(&argument.value, &argument.at)?;
        if index < bound {
            return Some(index);
        }
        let message = format!("index {index} is out of range: there are {bound} {what}");
        self.refuse(&argument.at, message);
        None
    }

    /// Calls a method of vectors of a parameter, whose type follows from the arguments.
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
            return Some(self.refuse(&at, refused::refusal(&name, None)));
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

    /// Returns the type of a vector that a parameter may have, for messages.
    pub(in crate::interpret) fn example_of_vector(&mut self) -> String {
        self.example_of_type(None)
    }

    /// Returns a type that a parameter may have whose part, entries or size are asked for.
    fn example_of_part(&mut self, name: &str) -> String {
        let example = self.example_of_vector();
        if views::is_of_matrices(name) {
            example.replacen("Vector", "Matrix", 1)
        } else {
            example
        }
    }

    /// Returns the message for a method of vectors that is called on a number.
    pub(super) fn no_method_of_number(&mut self, name: &str) -> String {
        let method = METHODS.iter().find(|method| method.name == name);
        let example = self.example_of_type(method);
        let field = if example.starts_with('V') { 'g' } else { 'm' };
        format!(
            "`{name}` is a method of vectors and matrices, and this is a number: in a product a field is taken for one, unless its type is written, as in `let {field}: {example} = self.{field};`"
        )
    }

    /// Returns a type that a parameter may have, for messages. The type has the method and, if the coordinates are a vector, their
    /// size.
    pub(super) fn example_of_type(&mut self, method: Option<&Method>) -> String {
        let block = self.block;
        let coordinates = self.matrix_type(block.coordinates());
        let n = coordinates.map_or(3, |ty| ty.rows);
        let of_matrices = ["transpose", "adjoint", "row", "column"];
        let ty = match method {
            Some(method) => match method.receiver {
                Receiver::OfLength(length) => MatrixType::vector(length),
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
