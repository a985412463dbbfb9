//! Methods that are not smooth or not supported, and the replacements that messages offer.

use super::{METHODS, Method};
use crate::errors::nearest;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats;
use crate::interpret::matrices::Kind;

/// Names separated by spaces, and a part of the message.
type Refused = (&'static str, &'static str);

/// Returns the part of the message for a method in a list.
fn listed(list: &[Refused], name: &str) -> Option<&'static str> {
    let mut entries = list.iter();
    let found = entries.find(|(names, _)| names.split(' ').any(|own| own == name));
    found.map(|(_, text)| *text)
}

/// Methods of `f64` and its operator `%`, with the end of the message.
const OF_NUMBERS: &[Refused] = &[
    (
        "abs",
        "has no derivative at 0: write `x * x` for a square, or `(x * x + eps * eps).sqrt()` for a smooth modulus",
    ),
    (
        "signum copysign",
        "is not continuous: use `(x / width).tanh()`",
    ),
    (
        "min",
        "is not smooth: use a smooth penalty, such as `(-x / width).exp()`",
    ),
    (
        "max",
        "is not smooth: use a smooth penalty, such as `(x / width).exp()`",
    ),
    ("clamp", "is not smooth: use `width * (x / width).tanh()`"),
    (
        "floor ceil round trunc",
        "is not continuous, and its slope is 0: `x - (TAU * x).sin() / TAU` is a smooth staircase through the integers; a value that is held for several steps is a parameter, changed between steps through `system_mut`",
    ),
    (
        "fract rem_euclid %",
        "is not continuous: an angle needs no reduction in `sin` and `cos`; a function of the period P is made of `(TAU * x / P).sin()` and `.cos()`, and one that switches twice in a period is `((TAU * x / P).sin() / width).tanh()`",
    ),
    ("div_euclid", "is not continuous: divide with `/`"),
];

/// Returns the message for a method or operator of `f64` that is not smooth.
pub(in crate::interpret) fn rough_method(name: &str) -> Option<String> {
    listed(OF_NUMBERS, name).map(|text| format!("`{name}` {text}"))
}

/// Methods of arrays and iterators, with their replacements.
const OF_LISTS: &[Refused] = &[
    (
        "collect",
        "fill an array in a loop, `let mut a = [0.0; N]; for i in 0..N { a[i] = …; }`, or use `map` of an array",
    ),
    ("first last", "write `x[0]` or `x[x.len() - 1]`"),
    (
        "split_at split_first split_last",
        "write pieces, `&x[..2]` and `&x[2..]`",
    ),
    ("try_into", "write the array, `[x[0], x[1]]`"),
    (
        "cycle scan take_while skip_while last_mut",
        "write a loop over indices; the next on a ring is `x[(i + 1) % N]`",
    ),
    (
        "for_each",
        "write a loop over indices, `for i in 0..N { a[i] = …; }`",
    ),
    (
        "max min max_by min_by any all position find",
        "it is not smooth in the entries",
    ),
    (
        "dot norm norm_squared dist length",
        "arrays have no such method: write the sum, `a[0] * b[0] + a[1] * b[1]`, as a function of this block",
    ),
];

/// Returns the message for a method of arrays and iterators that is not supported.
pub(super) fn not_understood(name: &str) -> String {
    let instead = match listed(OF_LISTS, name) {
        Some(instead) => instead,
        None if floats::is_smooth_method(name) => {
            return format!(
                "`{name}` is a function of one number: take an entry, `x[i].{name}(…)`, or write `.map(|x| x.{name}(…))`"
            );
        }
        None => "write a loop, `let mut sum = 0.0; for i in 0..N { sum += …; }`",
    };
    format!("`{name}` of an array or iterator is not understood: {instead}")
}

const OF_ROTATIONS: &str = "an angle of a rotation is not smooth everywhere; a spring that holds the attitude `r` is `0.5 * k * (3.0 - r.matrix().trace())`, which is ½kθ² for a small angle θ, with `(a.inverse() * b)` for `r` between two bodies; else use directions `r * Vector3::x()` and entries `r[(i, j)]`";
const IN_PLACE: &str = "methods that change a vector in place are not followed; assign to it, `v = …`, `v += …` or `v[i] = …`";

/// Methods of vectors and matrices, with their replacements.
const OF_MATRICES: &[Refused] = &[
    (
        "abs",
        "it has no derivative at 0; write `v.component_mul(&v)` for squares, or `v.map(|x| (x * x + eps * eps).sqrt())`",
    ),
    (
        "max min amax amin camax camin imax imin iamax iamin icamax argmax argmin inf sup inf_sup clamp \
         iamax_full lp_norm apply_norm cap_magnitude simd_cap_magnitude",
        "it is not smooth in the entries; use `norm`, or a smooth function of each entry in `map`",
    ),
    (
        "lu full_piv_lu qr col_piv_qr svd svd_unordered cholesky ldl udu schur hessenberg bidiagonalize \
         symmetric_eigen symmetric_eigenvalues eigenvalues complex_eigenvalues singular_values try_inverse \
         pseudo_inverse rank solve_lower_triangular solve_upper_triangular exp pow",
        "a factorisation is no formula; make the result a parameter, or write the formula of a small matrix with `determinant`",
    ),
    (
        "angle",
        "its derivative does not exist for parallel vectors; write `a.cross(&b).norm().atan2(a.dot(&b))`",
    ),
    (
        "try_normalize slerp try_slerp",
        "it branches on the length; write `v.normalize()`",
    ),
    (
        "euler_angles axis axis_angle scaled_axis angle_to rotation_to powf",
        OF_ROTATIONS,
    ),
    (
        "fill copy_from axpy gemv ger gemm swap swap_rows swap_columns set_row set_column set_diagonal apply \
         zip_apply component_mul_assign component_div_assign scale_mut unscale_mut",
        IN_PLACE,
    ),
    ("shape", "sizes are in the types; write the numbers"),
    (
        "powi",
        "a power is of a number; write `v.norm_squared()`, or `v.map(|x| x.powi(n))` for each entry",
    ),
    (
        "fixed_rows fixed_columns fixed_view",
        "its size is written as generic arguments, `v.fixed_rows::<3>(0)` and `m.fixed_view::<2, 2>(0, 0)`",
    ),
];

/// Returns whether a method is in the list of methods of vectors and matrices.
pub(super) fn is_listed(name: &str) -> bool {
    listed(OF_MATRICES, name).is_some()
}

/// Returns the message for a method of vectors and matrices that is not supported.
pub(in crate::interpret) fn refusal(name: &str, kind: Option<Kind>) -> String {
    let instead = match listed(OF_MATRICES, name) {
        Some(_) if name == "angle" && kind == Some(Kind::Rotation) => OF_ROTATIONS.to_owned(),
        Some(instead) => instead.to_owned(),
        None if name.ends_with("_mut") || name.ends_with("_assign") => IN_PLACE.to_owned(),
        None if floats::is_method(name) => {
            format!("it is a function of one number; take an entry, `v[i].{name}(…)`, or write `v.map(|x| x.{name}(…))`")
        }
        None => match nearest(name, suggestions()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "write it with `dot`, `cross`, `norm_squared`, `component_mul`, `transpose`, products, or entries `v[i]` and `m[(i, j)]`".to_owned(),
        },
    };
    let what = match kind {
        Some(Kind::Rotation) => "rotation",
        _ => "vector or matrix",
    };
    format!("`{name}` of a {what} is not understood: {instead}")
}

/// Returns the names of methods of vectors and matrices, for suggestions.
fn suggestions() -> impl Iterator<Item = &'static str> {
    let formulas = METHODS.iter().filter(|method| method.is_formula());
    let names = formulas.flat_map(|Method { names, .. }| names.split(' '));
    names.chain(["map", "zip_map", "iter", "fixed_rows", "fixed_view"])
}

/// Returns the message for a parameter whose type is needed but unknown.
pub(in crate::interpret) fn unknown_type(path: &FieldPath, example: &str) -> String {
    let name = crate::syntax::readable(&path.access());
    format!(
        "the type of `{name}` is not known to the macro: name it, `let {}: {example} = {name};`",
        path.name()
    )
}
