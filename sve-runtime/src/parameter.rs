//! Conversion of parameters to numbers in generated code.

/// A type that a parameter in a formula can have.
#[diagnostic::on_unimplemented(
    message = "this parameter is taken for an `f64`, and it has another type",
    label = "not an `f64`",
    note = "the macro does not see the types of fields: name the type of a vector or matrix first, as in \
            `let m: Matrix2<f64> = self.m;`"
)]
pub trait Number {
    /// Returns the value.
    fn value(self) -> f64;
}

impl Number for f64 {
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}

/// Returns the value of a parameter. If the parameter is not an `f64`, the compile error of [`Number`] says how to name its type.
#[inline(always)]
pub fn number<T: Number>(parameter: T) -> f64 {
    parameter.value()
}
