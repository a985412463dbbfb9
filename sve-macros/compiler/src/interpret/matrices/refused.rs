//! Methods of vectors and matrices that are not smooth or not supported, and the replacements that messages offer.

use super::{Kind, methods};
use crate::errors::nearest;
use crate::interpret::fields::FieldPath;
use crate::interpret::floats;

const NOT_SMOOTH: &str =
    "it is not smooth in the entries; use `norm`, or a smooth function of each entry in `map`";
const FACTORISATION: &str = "a factorisation is no formula; make the result a parameter, or write the formula of a small matrix with `determinant`";
const OF_ROTATIONS: &str = "an angle of a rotation is not smooth everywhere; a spring that holds the attitude `r` is `0.5 * k * (3.0 - r.matrix().trace())`, which is ½kθ² for a small angle θ, with `(a.inverse() * b)` for `r` between two bodies; else use directions `r * Vector3::x()` and entries `r[(i, j)]`";
const IN_PLACE: &str = "methods that change a vector in place are not followed; assign to it, `v = …`, `v += …` or `v[i] = …`";

/// Methods, and the end of the message that says what to write instead.
const REFUSED: &[(&[&str], &str)] = &[
    (
        &["abs"],
        "it has no derivative at 0; write `v.component_mul(&v)` for squares, or `v.map(|x| (x * x + eps * eps).sqrt())`",
    ),
    (
        &[
            "max",
            "min",
            "amax",
            "amin",
            "camax",
            "camin",
            "imax",
            "imin",
            "iamax",
            "iamin",
            "icamax",
            "argmax",
            "argmin",
            "inf",
            "sup",
            "inf_sup",
            "clamp",
            "iamax_full",
            "lp_norm",
            "apply_norm",
            "cap_magnitude",
            "simd_cap_magnitude",
        ],
        NOT_SMOOTH,
    ),
    (
        &[
            "lu",
            "full_piv_lu",
            "qr",
            "col_piv_qr",
            "svd",
            "svd_unordered",
            "cholesky",
            "ldl",
            "udu",
            "schur",
            "hessenberg",
            "bidiagonalize",
            "symmetric_eigen",
            "symmetric_eigenvalues",
            "eigenvalues",
            "complex_eigenvalues",
            "singular_values",
            "try_inverse",
            "pseudo_inverse",
            "rank",
            "solve_lower_triangular",
            "solve_upper_triangular",
            "exp",
            "pow",
        ],
        FACTORISATION,
    ),
    (
        &["angle"],
        "its derivative does not exist for parallel vectors; write `a.cross(&b).norm().atan2(a.dot(&b))`",
    ),
    (
        &["try_normalize", "slerp", "try_slerp"],
        "it branches on the length; write `v.normalize()`",
    ),
    (
        &[
            "euler_angles",
            "axis",
            "axis_angle",
            "scaled_axis",
            "angle_to",
            "rotation_to",
            "powf",
        ],
        OF_ROTATIONS,
    ),
    (
        &[
            "fill",
            "copy_from",
            "axpy",
            "gemv",
            "ger",
            "gemm",
            "swap",
            "swap_rows",
            "swap_columns",
            "set_row",
            "set_column",
            "set_diagonal",
            "apply",
            "zip_apply",
            "component_mul_assign",
            "component_div_assign",
            "scale_mut",
            "unscale_mut",
        ],
        IN_PLACE,
    ),
    (&["shape"], "sizes are in the types; write the numbers"),
    (
        &["powi"],
        "a power is of a number; write `v.norm_squared()`, or `v.map(|x| x.powi(n))` for each entry",
    ),
    (
        &["fixed_rows", "fixed_columns", "fixed_view"],
        "its size is written as generic arguments, `v.fixed_rows::<3>(0)` and `m.fixed_view::<2, 2>(0, 0)`",
    ),
];

/// Returns whether a method is in the list.
pub(super) fn is_listed(name: &str) -> bool {
    REFUSED.iter().any(|(names, _)| names.contains(&name))
}

/// Returns the message for a method of vectors and matrices that is not supported.
pub(super) fn refusal(name: &str, kind: Option<Kind>) -> String {
    let listed = REFUSED.iter().find(|(names, _)| names.contains(&name));
    let instead = match listed {
        Some(_) if name == "angle" && kind == Some(Kind::Rotation) => OF_ROTATIONS.to_owned(),
        Some((_, instead)) => (*instead).to_owned(),
        None if name.ends_with("_mut") || name.ends_with("_assign") => IN_PLACE.to_owned(),
        None if floats::is_method(name) => {
            format!("it is a function of one number; take an entry, `v[i].{name}(…)`, or write `v.map(|x| x.{name}(…))`")
        }
        None => match nearest(name, methods::names().chain(["map", "zip_map", "iter", "fixed_rows", "fixed_view"])) {
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

/// What to say of a parameter whose type is needed and not known.
pub(in crate::interpret) fn unknown_type(path: &FieldPath, example: &str) -> String {
    let name = crate::syntax::readable(&path.access());
    format!(
        "the type of `{name}` is not known to the macro: name it, `let {}: {example} = {name};`",
        path.name()
    )
}
