//! Calls of methods: the receiver, the arguments, and the types of parameters that follow from the
//! arguments.

use syn::{Expr as Syntax, ExprMethodCall};

use super::refused::{is_listed, not_understood, refusal, unknown_type};
use super::{Call, Given, Method, Receiver, Run, Take, find, formula, is_of_lists};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::conversions::NO_LENGTH;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats::{self, wrong_arity};
use crate::interpret::integers;
use crate::interpret::matrices::formulas::{each, entrywise};
use crate::interpret::matrices::views::{self, components};
use crate::interpret::matrices::{Kind, Matrix, MatrixType};
use crate::interpret::value::Value;

/// Returns the type that a parameter must have for a method and its first argument; `None` if
/// several types are possible.
fn type_of_parameter(method: &Method, first: Option<&Value>) -> Option<MatrixType> {
    match (method.receiver, method.takes.first(), first) {
        (_, Some(Take::Same), Some(Value::Matrix(other))) => Some(other.ty.plain()),
        // a cross product of columns, unless the argument is known to be a row
        (Receiver::OfLength(length), Some(Take::Same), Some(_)) => Some(MatrixType::vector(length)),
        _ => None,
    }
}

impl Lowering<'_> {
    pub(in crate::interpret) fn method_call(&mut self, call: &ExprMethodCall) -> Option<Value> {
        let (name, at) = (call.method.to_string(), call.method.span());
        let name = name.as_str();
        if matches!(&*call.receiver, Syntax::Path(path) if path.path.is_ident("self")) {
            let arguments = self.arguments(&call.args);
            return self.helper(name, at, true, arguments);
        }
        let is_alone = call.args.is_empty();
        if name == "iter_mut" && is_alone {
            return self.iterate_mutably(&call.receiver, at);
        }
        let receiver = self.argument(&call.receiver);
        match (&receiver.value, name) {
            // a poisoned receiver has no type against which its method could be checked
            (Value::Poison, name) if !floats::is_method(name) => return None,
            (Value::Field(path), name) if !path.is_self() && !is_of_lists(name) => {
                if let Ok(value) = self.method_of_field(call, path) {
                    return value;
                }
            }
            (Value::Scalar(_), name)
                if formula(name).is_some() && floats::other_name(name).is_none() =>
            {
                let message = self.no_method_of_number(name);
                return self.refuse(&at, message);
            }
            _ => {}
        }
        let is_of_rows = matches!(name, "iter" | "into_iter" | "len" | "windows" | "to_vec");
        if is_of_rows
            && let Value::Field(_) = &receiver.value
            && let Some(stream) = self.stream(&receiver.value)
        {
            let value = Value::Stream(stream);
            return self.tabled(call, Argument { value, ..receiver });
        }
        match (&receiver.value, name) {
            (_, "clone" | "to_owned") if is_alone => Some(receiver.value),
            (_, "into") if is_alone => Some(self.converted(receiver.value)),
            (Value::Matrix(_), _) => self.tabled(call, receiver),
            (_, "as_slice" | "each_ref") if is_alone => Some(receiver.value),
            (Value::Array(_) | Value::Sequence(_) | Value::Stream(_), _) => {
                self.tabled(call, receiver)
            }
            (Value::Field(path), name) if is_of_lists(name) => self.method_of_unsized(call, path),
            (Value::Generated(_), _) => self.refuse(&at, NO_LENGTH),
            _ => {
                let mut arguments = vec![receiver];
                arguments.extend(self.arguments(&call.args));
                let values: Vec<&Value> = arguments.iter().map(|a| &a.value).collect();
                if let Some(value) = self.running_method(name, &values) {
                    return Some(value);
                }
                match integers::method(name, &arguments) {
                    Some((compute, operands)) => self.integer_method(name, compute, operands, at),
                    None => self.number_method(name, at, &arguments),
                }
            }
        }
    }

    /// Calls the method of an array, an iterator, a vector or a matrix.
    fn tabled(&mut self, call: &ExprMethodCall, receiver: Argument) -> Option<Value> {
        let name = call.method.to_string();
        let has_lengths = call.turbofish.is_some() || !name.starts_with("fixed_");
        let is_receiver = |kind: Receiver| has_lengths && kind.includes(&receiver.value);
        let method = find(&name, is_receiver);
        let message = match (&receiver.value, method) {
            (Value::Matrix(matrix), Some(method)) if !method.receiver.accepts(matrix.ty) => {
                let described = method.receiver.described();
                format!(
                    "a `{}` has no `{name}`: it is a method of {described}",
                    matrix.ty
                )
            }
            (_, Some(method)) if method.takes.len() == call.args.len() => {
                self.work(receiver.value.items().len(), call)?;
                return self.invoke(method, call, receiver);
            }
            (_, Some(method)) => {
                wrong_arity(&format!("`{name}`"), method.takes.len(), call.args.len())
            }
            (Value::Matrix(matrix), None) => match components(matrix, &name) {
                Some(components) if call.args.is_empty() => return Some(components),
                _ => refusal(&name, Some(matrix.ty.kind)),
            },
            (_, None) => not_understood(&name),
        };
        if let Value::Matrix(_) = receiver.value {
            // reports the mistakes in the arguments
            self.arguments(&call.args);
        }
        self.refuse(&call.method, message)
    }

    /// Evaluates the arguments of a method and computes its result.
    fn invoke(
        &mut self,
        method: &Method,
        syntax: &ExprMethodCall,
        receiver: Argument,
    ) -> Option<Value> {
        let mut given = Given::default();
        let ty = match &receiver.value {
            Value::Matrix(matrix) => matrix.ty,
            _ => MatrixType::matrix(0, 0),
        };
        let name = syntax.method.to_string();
        let arguments: Vec<(Take, &Syntax)> =
            method.takes.iter().copied().zip(&syntax.args).collect();
        let mut evaluated = Vec::new();
        for (take, argument) in arguments {
            if take == Take::Function {
                given.functions.push(argument);
            } else {
                evaluated.push((take, self.argument(argument)));
            }
        }
        let mut is_complete = true;
        for (take, argument) in evaluated {
            let taken = self.give(&mut given, take, ty, argument, &name);
            is_complete &= taken.is_some();
        }
        if !is_complete {
            return None;
        }
        let call = Call {
            syntax,
            receiver,
            given,
        };
        let matrix = match method.run {
            Run::Own(run) | Run::Computed(run) => return run(self, &call),
            Run::Adapter(run) => {
                let items = call.receiver.value.items().to_vec();
                return run(self, items, &call).map(Value::Sequence);
            }
            Run::Plain(run) => return Some(run(&call)),
            Run::Size(size) => return Some(Value::count(size(ty))),
            _ => self.numbers(&call.matrix(), &call.receiver.at)?,
        };
        self.computed_by(&method.run, &matrix, &call)
    }

    /// Computes a formula of a vector or matrix.
    fn computed_by(&mut self, run: &Run, m: &Matrix<Expr>, call: &Call<'_>) -> Option<Value> {
        let (given, arena) = (&call.given, &mut *self.arena);
        let result = match *run {
            Run::Entry(compute) => {
                let number = compute(arena, m);
                return self.finite(number, &call.syntax.method);
            }
            Run::EntryOf(compute) => {
                let number = compute(arena, m, &given.matrices[0]);
                return self.finite(number, &call.syntax.method);
            }
            Run::Formula(compute) => compute(arena, m),
            Run::FormulaOf(compute) => compute(arena, m, &given.matrices[0]),
            Run::Each(operation) => each(arena, m, given.numbers[0], operation),
            Run::Entrywise(operation) => entrywise(arena, m, &given.matrices[0], operation),
            Run::Line(line) => line(m, given.counts[0]),
            _ => return None,
        };
        self.finite_matrix(result, &call.syntax.method)
    }

    /// Adds an argument of a method of a `ty`; `None` after an error.
    fn give(
        &mut self,
        given: &mut Given<'_>,
        take: Take,
        ty: MatrixType,
        argument: Argument,
        name: &str,
    ) -> Option<()> {
        let mut matrix = |ty| self.matrix_argument(&argument, ty, name);
        match take {
            Take::Same => given.matrices.push(matrix(ty.plain())?),
            Take::Rows => given.matrices.push(matrix(MatrixType::vector(ty.rows))?),
            Take::Number => given
                .numbers
                .push(self.scalar(&argument.value, &argument.at)?),
            Take::Count => given
                .counts
                .push(self.index_of(&argument.value, &argument.at)?),
            Take::Row => given
                .counts
                .push(self.count_argument(&argument, ty.rows, "rows")?),
            Take::Column => {
                let count = self.count_argument(&argument, ty.columns, "columns")?;
                given.counts.push(count);
            }
            Take::Value | Take::Function => given.values.push(argument),
        }
        Some(())
    }

    /// Evaluates an argument that must be a matrix of this size. A parameter gets this type.
    pub(in crate::interpret) fn matrix_argument(
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
                self.refuse(&argument.at, message)
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
        self.refuse(&argument.at, message)
    }

    /// Calls a method of vectors on a parameter. The type of the parameter follows from the
    /// arguments. Returns `Err` if vectors have no such method.
    fn method_of_field(
        &mut self,
        call: &ExprMethodCall,
        path: &FieldPath,
    ) -> Result<Option<Value>, ()> {
        let (name, at) = (call.method.to_string(), call.method.span());
        if views::is_method(&name, call.turbofish.is_some()) {
            let example = self.example_of_part(&name);
            return Ok(self.refuse(&at, unknown_type(path, &example)));
        }
        let is_of_numbers = floats::is_method(&name) || floats::other_name(&name).is_some();
        if is_listed(&name) && !is_of_numbers {
            return Ok(self.refuse(&at, refusal(&name, None)));
        }
        let method = formula(&name).ok_or(())?;
        let arguments = self.arguments(&call.args);
        let mut values = arguments.iter().map(|argument| &argument.value);
        if values.clone().any(|value| matches!(value, Value::Poison)) {
            return Ok(None);
        }
        let ty = type_of_parameter(method, values.next()).filter(|_| !path.is_number());
        let message = match ty {
            Some(ty) => {
                let value = Value::Matrix(Matrix::of_field(path, ty));
                return Ok(self.tabled(call, Argument { value, at }));
            }
            None if path.is_number() => self.no_method_of_number(&name),
            None => unknown_type(path, &self.example_of_type(Some(method))),
        };
        Ok(self.refuse(&at, message))
    }

    /// Returns the type of a vector that a parameter may have, for messages.
    pub(in crate::interpret) fn example_of_vector(&mut self) -> String {
        self.example_of_type(None)
    }

    /// Returns a type that a parameter may have, for messages about its part, its entries or its
    /// size.
    fn example_of_part(&mut self, name: &str) -> String {
        let example = self.example_of_vector();
        if views::is_of_matrices(name) {
            example.replacen("Vector", "Matrix", 1)
        } else {
            example
        }
    }

    /// Returns the message for a method of vectors that is called on a number.
    fn no_method_of_number(&mut self, name: &str) -> String {
        let example = self.example_of_type(formula(name));
        let field = if example.starts_with('V') { 'g' } else { 'm' };
        format!(
            "`{name}` is a method of vectors and matrices, and this is a number: in a product a field is taken for one, unless its type is written, as in `let {field}: {example} = self.{field};`"
        )
    }

    /// Returns a type that a parameter may have, for messages. The type has the method and, if the
    /// coordinates are a vector, their size.
    fn example_of_type(&mut self, method: Option<&Method>) -> String {
        let block = self.block;
        let coordinates = self.matrix_type(block.coordinates());
        let n = coordinates.map_or(3, |ty| ty.rows);
        let is_of_matrices = |method: &Method| {
            let names = ["transpose adjoint", "row", "column"];
            method.receiver == Receiver::Square || names.contains(&method.names)
        };
        let ty = match method {
            Some(method) if is_of_matrices(method) => MatrixType::matrix(n, n),
            Some(method) => match method.receiver {
                Receiver::OfLength(length) => MatrixType::vector(length),
                Receiver::Rotation => MatrixType {
                    kind: Kind::Rotation,
                    ..MatrixType::matrix(n.clamp(2, 3), n.clamp(2, 3))
                },
                _ => MatrixType::vector(n),
            },
            None => MatrixType::vector(n),
        };
        ty.to_string()
    }
}
