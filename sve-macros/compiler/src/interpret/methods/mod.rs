//! The table of methods: their receivers, their arguments, and the computations of their results.
//!
//! `call.rs` looks a method up, evaluates its arguments and calls it; `refused.rs` has the messages
//! for methods that are not understood. The smooth functions of the algebra are methods of numbers
//! too; the table does not repeat them.

mod call;
mod refused;

use syn::{Expr as Syntax, ExprMethodCall};

use super::Lowering;
use super::calls::Argument;
use super::matrices::formulas::{
    cross, cross_matrix, diagonal, distance, image, inner, inverse_image, mean, norm, norm_squared,
    normalized, perp, product, sum, trace, transpose,
};
use super::matrices::views;
use super::matrices::{Kind, Matrix, MatrixType};
use super::scenes::streams;
use super::value::Value;
use super::{adapters, floats, matrices, sequences};
use crate::algebra::{Arena, Expr};
use Receiver::{
    Any, Array, Iterator, List, Number, OfLength, One, Rotation, Square, Stream, Vector, Wrapped,
};
use Run::{
    Adapter, Computed, Each, Entry, EntryOf, Entrywise, Float, Formula, FormulaOf, Line, Own,
    Plain, Size,
};
pub(super) use refused::{refusal, rough_method, unknown_type};

/// The types of values that have a method.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Receiver {
    Number,
    Array,
    Iterator,
    /// Arrays and iterators.
    List,
    /// Arrays and iterators whose length is known when the program runs.
    Stream,
    /// Vectors, matrices and rotations.
    Any,
    /// One column.
    Vector,
    /// A vector or row of this length.
    OfLength(usize),
    Square,
    One,
    Rotation,
    /// A rotation or a unit vector.
    Wrapped,
}

/// The kind of an argument.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Take {
    Value,
    Number,
    /// An index or a length.
    Count,
    /// The index of a row.
    Row,
    /// The index of a column.
    Column,
    /// A matrix of the receiver's size.
    Same,
    /// A vector with as many entries as the receiver has rows.
    Rows,
    /// A closure, or the name of a variable that holds one.
    Function,
}

/// The arguments of a call, by their kinds.
#[derive(Default)]
pub(super) struct Given<'c> {
    pub(super) values: Vec<Argument>,
    pub(super) numbers: Vec<Expr>,
    pub(super) counts: Vec<usize>,
    pub(super) matrices: Vec<Matrix<Expr>>,
    pub(super) functions: Vec<&'c Syntax>,
}

/// A call of a method of the table.
pub(super) struct Call<'c> {
    pub(super) syntax: &'c ExprMethodCall,
    pub(super) receiver: Argument,
    pub(super) given: Given<'c>,
}

impl Call<'_> {
    /// Returns the receiver if it is a matrix, and otherwise an empty matrix.
    pub(super) fn matrix(&self) -> Matrix<Value> {
        match &self.receiver.value {
            Value::Matrix(matrix) => matrix.clone(),
            _ => Matrix::from_fn(MatrixType::matrix(0, 0), |_, _| Value::Poison),
        }
    }
}

/// The computation of the result of a method. Numbers and matrices come from the receiver first,
/// then from the arguments.
pub(super) enum Run {
    /// A function of numbers.
    Float(fn(&mut Arena, &[Expr]) -> Expr),
    /// A number computed from one matrix or from two.
    Entry(fn(&mut Arena, &Matrix<Expr>) -> Expr),
    EntryOf(fn(&mut Arena, &Matrix<Expr>, &Matrix<Expr>) -> Expr),
    /// A matrix computed from one matrix or from two.
    Formula(fn(&mut Arena, &Matrix<Expr>) -> Matrix<Expr>),
    FormulaOf(fn(&mut Arena, &Matrix<Expr>, &Matrix<Expr>) -> Matrix<Expr>),
    /// An operation on each entry and a number, or on the entries of two matrices.
    Each(fn(&mut Arena, Expr, Expr) -> Expr),
    Entrywise(fn(&mut Arena, Expr, Expr) -> Expr),
    /// A row or a column.
    Line(fn(&Matrix<Expr>, usize) -> Matrix<Expr>),
    Size(fn(MatrixType) -> usize),
    /// The entries or items of the receiver in another order or form.
    Plain(fn(&Call<'_>) -> Value),
    /// The items of another iterator.
    Adapter(fn(&mut Lowering<'_>, Vec<Value>, &Call<'_>) -> Option<Vec<Value>>),
    /// A number or a matrix computed from a matrix and other arguments.
    Computed(fn(&mut Lowering<'_>, &Call<'_>) -> Option<Value>),
    /// Another value.
    Own(fn(&mut Lowering<'_>, &Call<'_>) -> Option<Value>),
}

pub(super) struct Method {
    /// The names, separated by spaces.
    names: &'static str,
    receiver: Receiver,
    takes: &'static [Take],
    run: Run,
}

const fn row(receiver: Receiver, names: &'static str, takes: &'static [Take], run: Run) -> Method {
    Method {
        names,
        receiver,
        takes,
        run,
    }
}

const SAME: &[Take] = &[Take::Same];
const NUMBER: &[Take] = &[Take::Number];
const COUNT: &[Take] = &[Take::Count];
const COUNTS: &[Take] = &[Take::Count, Take::Count];
const VALUE: &[Take] = &[Take::Value];
const FUNCTION: &[Take] = &[Take::Function];
const FOLD: &[Take] = &[Take::Value, Take::Function];
const ZIP: &[Take] = &[Take::Same, Take::Function];
const LERP: &[Take] = &[Take::Same, Take::Number];
const NUMBERS: &[Take] = &[Take::Number, Take::Number];
const ROWS: &[Take] = &[Take::Rows];

static METHODS: &[Method] = &[
    row(Number, "recip", &[], Float(|a, x| a.pow(x[0], -1))),
    row(Number, "to_radians", &[], Float(floats::to_radians)),
    row(Number, "to_degrees", &[], Float(floats::to_degrees)),
    row(Number, "mul_add", NUMBERS, Float(floats::mul_add)),
    row(Number, "log", NUMBER, Float(floats::log)),
    row(List, "len", &[], Plain(sequences::length)),
    row(List, "iter into_iter", &[], Plain(sequences::iterator)),
    row(List, "copied cloned", &[], Plain(sequences::iterator)),
    row(Array, "map", FUNCTION, Own(sequences::map)),
    row(Iterator, "map", FUNCTION, Adapter(adapters::map)),
    row(Iterator, "for_each", FUNCTION, Own(sequences::for_each)),
    row(List, "windows chunks", COUNT, Own(sequences::chunks)),
    row(List, "chunks_exact", COUNT, Own(sequences::chunks)),
    row(List, "as_flattened", &[], Own(sequences::as_flattened)),
    row(List, "sum product", &[], Own(sequences::total)),
    row(List, "fold", FOLD, Own(sequences::fold)),
    row(List, "rev", &[], Plain(adapters::rev)),
    row(List, "enumerate", &[], Plain(adapters::enumerate)),
    row(List, "flatten", &[], Adapter(adapters::flatten)),
    row(List, "flat_map", FUNCTION, Adapter(adapters::flat_map)),
    row(List, "zip", VALUE, Adapter(adapters::zip)),
    row(List, "chain", VALUE, Adapter(adapters::chain)),
    row(List, "filter", FUNCTION, Adapter(adapters::filter)),
    row(List, "skip", COUNT, Plain(adapters::skip)),
    row(List, "take", COUNT, Plain(adapters::take)),
    row(List, "step_by", COUNT, Adapter(adapters::step_by)),
    row(Stream, "len count", &[], Own(streams::length)),
    row(Stream, "iter into_iter", &[], Own(streams::same)),
    row(Stream, "copied cloned", &[], Own(streams::same)),
    row(Stream, "collect to_vec", &[], Own(streams::same)),
    row(Stream, "map", FUNCTION, Own(streams::map)),
    row(Stream, "filter", FUNCTION, Own(streams::filter)),
    row(Stream, "enumerate", &[], Own(streams::enumerate)),
    row(Stream, "zip", VALUE, Own(streams::zip)),
    row(Stream, "rev", &[], Own(streams::rev)),
    row(Stream, "skip take", VALUE, Own(streams::part)),
    row(Stream, "windows", COUNT, Own(streams::windows)),
    row(Stream, "sum", &[], Own(streams::sum)),
    row(Any, "dot", SAME, EntryOf(inner)),
    row(Any, "norm_squared", &[], Entry(norm_squared)),
    row(Any, "magnitude_squared", &[], Entry(norm_squared)),
    row(Any, "norm magnitude", &[], Entry(norm)),
    row(Any, "metric_distance", SAME, EntryOf(distance)),
    row(Any, "sum", &[], Entry(|a, m| sum(a, &m.entries))),
    row(Any, "product", &[], Entry(product)),
    row(Any, "mean", &[], Entry(mean)),
    row(Square, "trace", &[], Entry(trace)),
    row(Square, "determinant", &[], Computed(matrices::determinant)),
    row(OfLength(2), "perp", SAME, EntryOf(perp)),
    row(
        One,
        "to_scalar into_scalar",
        &[],
        Entry(|_, m| m.entries[0]),
    ),
    row(OfLength(3), "cross", SAME, FormulaOf(cross)),
    row(OfLength(3), "cross_matrix", &[], Formula(cross_matrix)),
    row(Any, "component_mul", SAME, Entrywise(Arena::mul)),
    row(Any, "component_div", SAME, Entrywise(Arena::div)),
    row(Any, "scale", NUMBER, Each(Arena::mul)),
    row(Any, "unscale", NUMBER, Each(Arena::div)),
    row(Any, "add_scalar", NUMBER, Each(Arena::add)),
    row(Any, "normalize", &[], Formula(normalized)),
    row(Vector, "lerp", LERP, Computed(matrices::lerp)),
    row(Any, "transpose adjoint", &[], Formula(|_, m| transpose(m))),
    row(Square, "diagonal", &[], Formula(|_, m| diagonal(m))),
    row(Any, "row", &[Take::Row], Line(Matrix::row)),
    row(Any, "column", &[Take::Column], Line(Matrix::column)),
    row(Any, "into_owned", &[], Formula(|_, m| m.clone())),
    row(Any, "clone_owned", &[], Formula(|_, m| m.clone())),
    row(Rotation, "inverse", &[], Formula(|_, m| m.transposed())),
    row(Rotation, "transform_vector", ROWS, FormulaOf(image)),
    row(
        Rotation,
        "inverse_transform_vector",
        ROWS,
        FormulaOf(inverse_image),
    ),
    row(Rotation, "matrix", &[], Formula(|_, m| m.unwrapped())),
    row(Wrapped, "into_inner", &[], Formula(|_, m| m.unwrapped())),
    row(Any, "len", &[], Size(MatrixType::len)),
    row(Any, "nrows", &[], Size(|ty| ty.rows)),
    row(Any, "ncols", &[], Size(|ty| ty.columns)),
    row(Any, "iter into_iter", &[], Plain(sequences::iterator)),
    row(Any, "as_slice", &[], Plain(sequences::array)),
    row(Any, "column_iter", &[], Plain(views::columns)),
    row(Any, "row_iter", &[], Plain(views::rows)),
    row(Any, "rows columns fixed_view", COUNTS, Own(views::part)),
    row(Any, "fixed_rows fixed_columns", COUNT, Own(views::part)),
    row(Any, "map", FUNCTION, Own(matrices::map)),
    row(Any, "zip_map", ZIP, Own(matrices::map)),
    row(Any, "fold", FOLD, Own(sequences::fold)),
    row(Any, "tr_mul", VALUE, Own(matrices::transposed_product)),
];

impl Receiver {
    /// Returns whether vectors, matrices or rotations of some size are receivers of this type.
    fn is_matrix(self) -> bool {
        !matches!(self, Number | Array | Iterator | List | Stream)
    }

    /// Returns whether a value is a receiver of this type. For a matrix, returns whether matrices
    /// of the same kind and some size are.
    fn includes(self, value: &Value) -> bool {
        match value {
            Value::Array(_) => matches!(self, Array | List),
            Value::Sequence(_) => matches!(self, Iterator | List),
            Value::Stream(_) => self == Stream,
            Value::Matrix(_) => self.is_matrix(),
            _ => self == Number,
        }
    }

    fn accepts(self, ty: MatrixType) -> bool {
        match self {
            Any | Number | Array | Iterator | List | Stream => true,
            Vector => ty.is_vector(),
            OfLength(length) => ty.len() == length && ty.rows.min(ty.columns) == 1,
            Square => ty.is_square(),
            One => ty.len() == 1,
            Rotation => ty.kind == Kind::Rotation,
            Wrapped => ty.kind != Kind::Matrix,
        }
    }

    fn described(self) -> String {
        match self {
            Number | Array | Iterator | List | Stream | Any => "matrices".to_owned(),
            Vector => "vectors".to_owned(),
            OfLength(length) => format!("vectors of length {length}"),
            Square => "square matrices".to_owned(),
            One => "matrices of one entry".to_owned(),
            Rotation => "rotations".to_owned(),
            Wrapped => "rotations and unit vectors".to_owned(),
        }
    }
}

impl Method {
    fn has_name(&self, name: &str) -> bool {
        self.names.split(' ').any(|own| own == name)
    }

    /// Returns whether the method is a formula of the entries of its receiver, a vector or matrix.
    fn is_formula(&self) -> bool {
        !matches!(
            self.run,
            Float(_) | Plain(_) | Adapter(_) | Size(_) | Own(_)
        )
    }
}

/// Returns the method with this name and such a receiver.
fn find(name: &str, is_receiver: impl Fn(Receiver) -> bool) -> Option<&'static Method> {
    let mut methods = METHODS.iter();
    methods.find(|method| method.has_name(name) && is_receiver(method.receiver))
}

/// Returns the formula of vectors and matrices with this name.
fn formula(name: &str) -> Option<&'static Method> {
    find(name, Receiver::is_matrix).filter(|method| method.is_formula())
}

/// Returns whether arrays or iterators have a method with this name.
fn is_of_lists(name: &str) -> bool {
    find(name, |receiver| matches!(receiver, Array | Iterator | List)).is_some()
}

/// Returns the number of arguments and the computation of a method of numbers.
pub(super) fn of_numbers(name: &str) -> Option<(usize, &'static Run)> {
    let method = find(name, |receiver| receiver == Number)?;
    Some((method.takes.len(), &method.run))
}

/// Returns the names of the methods of numbers in the table.
pub(super) fn names_of_numbers() -> impl std::iter::Iterator<Item = &'static str> {
    let methods = METHODS.iter().filter(|method| method.receiver == Number);
    methods.map(|method| method.names)
}

#[cfg(test)]
mod tests;
