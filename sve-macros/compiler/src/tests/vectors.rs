//! Vectors and matrices of nalgebra: a body with them is the same expressions as one with arrays, and mistakes are reported at
//! their tokens.

use proc_macro2::TokenStream;

use crate::algebra::{Arena, Expr};
use crate::errors::Errors;
use crate::interpret;
use crate::syntax::parse;
use crate::system::model::{Meaning, Model};

fn tokens(text: &str) -> TokenStream {
    text.parse().expect("tokens")
}

/// The model of a block; or its mistakes: the source text at which each is reported, and the message.
pub(super) fn model(members: &str, arena: &mut Arena) -> Result<Model, Vec<(String, String)>> {
    let text = format!("impl P {{ {members} }}");
    let block = syn::parse2(tokens(&text)).expect("a block");
    let mut errors = Errors::new();
    let read = parse::annotated(tokens("midpoint"), block, &mut errors);
    let model = read.and_then(|block| interpret::interpret(&block, arena, &mut errors));
    match errors.finish(model) {
        Ok(model) => Ok(model.expect("a model or an error")),
        Err(errors) => Err(errors
            .into_iter()
            .map(|error| {
                let at = error.span().source_text().unwrap_or_default();
                (at, error.to_string())
            })
            .collect()),
    }
}

/// Everything that a model computes.
fn expressions(model: &Model) -> Vec<Expr> {
    let mut all = vec![model.lagrangian];
    all.extend(model.noises.iter().map(|noise| noise.hamiltonian));
    all.extend(model.force.iter().flatten());
    all.extend(model.symmetries.iter().flat_map(|s| &s.field));
    all
}

/// Asserts that two blocks are the same expressions, and that there are some.
fn assert_same(vectors: &str, arrays: &str) {
    let mut arena = Arena::new();
    // the arrays first: the order in which expressions are made decides nothing
    let plain = model(arrays, &mut arena).unwrap_or_else(|e| panic!("{arrays}: {e:?}"));
    let found = model(vectors, &mut arena).unwrap_or_else(|e| panic!("{vectors}: {e:?}"));
    let (plain, found) = (expressions(&plain), expressions(&found));
    assert_eq!(plain.len(), found.len(), "{vectors}");
    for (plain, found) in plain.into_iter().zip(found) {
        let show = |expr| format!("{:?}", arena.node(expr));
        assert_eq!(
            found,
            plain,
            "{vectors}: {} is not {}",
            show(found),
            show(plain)
        );
    }
}

/// Expressions of two vectors a and b of length 3, a matrix m, and numbers x and y; and the same with arrays.
const OPERATIONS: &[(&str, &str)] = &[
    ("a.dot(&b)", "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]"),
    (
        "(&a + &b).norm_squared()",
        "(a[0] + b[0]).powi(2) + (a[1] + b[1]).powi(2) + (a[2] + b[2]).powi(2)",
    ),
    (
        "(a - b).norm()",
        "((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()",
    ),
    (
        "a.metric_distance(&b)",
        "((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()",
    ),
    ("(-a).sum()", "-a[0] - a[1] - a[2]"),
    ("(a * x - 2.0 * b / y).z", "a[2] * x - 2.0 * b[2] / y"),
    ("a.cross(&b).x", "a[1] * b[2] - a[2] * b[1]"),
    ("a.cross(&b).y", "a[2] * b[0] - a[0] * b[2]"),
    ("a.cross(&b)[2]", "a[0] * b[1] - a[1] * b[0]"),
    ("(a.cross_matrix() * b).y", "a[2] * b[0] - a[0] * b[2]"),
    (
        "a.component_mul(&b).sum()",
        "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]",
    ),
    ("a.component_div(&b)[1]", "a[1] / b[1]"),
    (
        "a.scale(x).unscale(y).add_scalar(1.0).y",
        "a[1] * x / y + 1.0",
    ),
    (
        "a.normalize().x",
        "a[0] / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()",
    ),
    ("a.mean()", "(a[0] + a[1] + a[2]) / 3.0"),
    ("a.product()", "a[0] * a[1] * a[2]"),
    ("a.lerp(&b, x).y", "a[1] * (1.0 - x) + b[1] * x"),
    ("a.map(|s| s.sin() * x).z", "a[2].sin() * x"),
    ("a.zip_map(&b, |s, t| s / t).x", "a[0] / b[0]"),
    (
        "a.fold(y, |s, t| s * 2.0 + t)",
        "((y * 2.0 + a[0]) * 2.0 + a[1]) * 2.0 + a[2]",
    ),
    (
        "a.iter().zip(b.iter()).map(|(s, t)| s * t.exp()).sum::<f64>()",
        "a[0] * b[0].exp() + a[1] * b[1].exp() + a[2] * b[2].exp()",
    ),
    (
        "a.iter().enumerate().map(|(i, s)| s * i as f64).sum::<f64>()",
        "a[1] + a[2] * 2.0",
    ),
    (
        "a.fixed_rows::<2>(1).norm_squared()",
        "a[1] * a[1] + a[2] * a[2]",
    ),
    ("a.rows(0, 2).dot(&b.xy())", "a[0] * b[0] + a[1] * b[1]"),
    ("a.xy().perp(&b.xy())", "a[0] * b[1] - a[1] * b[0]"),
    ("(a.zx()).x", "a[2]"),
    (
        "(a.transpose() * b)[(0, 0)]",
        "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]",
    ),
    (
        "(a.transpose() * b).to_scalar()",
        "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]",
    ),
    ("a.tr_mul(&b).x", "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]"),
    ("(a * b.transpose())[(2, 0)]", "a[2] * b[0]"),
    (
        "(a * b.transpose()).trace()",
        "a[0] * b[0] + a[1] * b[1] + a[2] * b[2]",
    ),
    ("a.len() as f64 * x", "3.0 * x"),
    // matrices: `new` takes rows, storage and `iter` are in columns
    (
        "(m * a).y",
        "m[1][0] * a[0] + m[1][1] * a[1] + m[1][2] * a[2]",
    ),
    (
        "a.dot(&(m * b))",
        "a[0] * (m[0][0] * b[0] + m[0][1] * b[1] + m[0][2] * b[2]) + a[1] * (m[1][0] * b[0] + m[1][1] * b[1] + m[1][2] * b[2]) + a[2] * (m[2][0] * b[0] + m[2][1] * b[1] + m[2][2] * b[2])",
    ),
    (
        "(m * m)[(0, 1)]",
        "m[0][0] * m[0][1] + m[0][1] * m[1][1] + m[0][2] * m[2][1]",
    ),
    ("m.transpose()[(0, 2)]", "m[2][0]"),
    ("m[1] + m.m12 + m.m33", "m[1][0] + m[0][1] + m[2][2]"),
    ("m.iter().skip(3).take(1).sum::<f64>()", "m[0][1]"),
    ("m.row(1)[2] * m.column(0).x", "m[1][2] * m[0][0]"),
    (
        "(m.row(1) * a).x",
        "m[1][0] * a[0] + m[1][1] * a[1] + m[1][2] * a[2]",
    ),
    (
        "m.column_iter().map(|c| c.dot(&a)).sum::<f64>()",
        "m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2] + (m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2]) + (m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2])",
    ),
    (
        "m.row_iter().map(|r| r[0]).sum::<f64>()",
        "m[0][0] + m[1][0] + m[2][0]",
    ),
    ("m.trace()", "m[0][0] + m[1][1] + m[2][2]"),
    ("m.diagonal().y", "m[1][1]"),
    (
        "m.fixed_view::<2, 2>(1, 0).determinant()",
        "m[1][0] * m[2][1] - m[2][0] * m[1][1]",
    ),
    (
        "m.determinant()",
        "m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2]) - m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2]) + m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2])",
    ),
    (
        "(m * 2.0 + Matrix3::identity()).trace()",
        "2.0 * m[0][0] + 1.0 + (2.0 * m[1][1] + 1.0) + (2.0 * m[2][2] + 1.0)",
    ),
    ("m.nrows() as f64 * m.ncols() as f64 * x", "9.0 * x"),
    // constructors
    (
        "Vector3::x().dot(&a) + Vector3::y_axis().dot(&b)",
        "a[0] + b[1]",
    ),
    (
        "Vector3::<f64>::repeat(x).dot(&a)",
        "x * a[0] + x * a[1] + x * a[2]",
    ),
    ("(a + nalgebra::Vector3::zeros()).x", "a[0]"),
    ("na::Vector2::from([x, y]).y", "y"),
    ("Vector3::from_row_slice(&[x, y, 1.0]).y", "y"),
    (
        "SVector::<f64, 4>::from_fn(|i, _| x * i as f64).w",
        "x * 3.0",
    ),
    (
        "SMatrix::<f64, 2, 3>::new(x, y, 1.0, 2.0, 3.0, 4.0)[(0, 1)]",
        "y",
    ),
    (
        "Matrix2::new(x, y, 1.0, 2.0)[1] + Matrix2::from([[x, y], [1.0, 2.0]])[(1, 0)]",
        "1.0 + y",
    ),
    (
        "Matrix2::from_row_slice(&[x, y, 1.0, 2.0])[(0, 1)] + Matrix2::from_column_slice(&[x, y, 1.0, 2.0])[(0, 1)]",
        "y + 1.0",
    ),
    ("(Matrix3::from_diagonal(&a) * b).y", "a[1] * b[1]"),
    ("Matrix3x2::from_columns(&[a, b])[(2, 1)]", "b[2]"),
    (
        "Matrix2x3::from_rows(&[a.transpose(), b.transpose()])[(1, 0)]",
        "b[0]",
    ),
    ("Matrix2::from_diagonal_element(x).trace()", "x + x"),
    // rotations
    (
        "(Rotation2::new(x) * a.xy()).x",
        "x.cos() * a[0] - x.sin() * a[1]",
    ),
    (
        "(Rotation2::new(x).inverse() * a.xy()).y",
        "-x.sin() * a[0] + x.cos() * a[1]",
    ),
    (
        "Rotation2::new(x).transform_vector(&a.xy()).y",
        "x.sin() * a[0] + x.cos() * a[1]",
    ),
    (
        "Rotation2::new(x).inverse_transform_vector(&a.xy()).x",
        "x.cos() * a[0] + x.sin() * a[1]",
    ),
    (
        "(Rotation3::from_axis_angle(&Vector3::z_axis(), x) * a).y",
        "x.sin() * a[0] + x.cos() * a[1]",
    ),
    (
        "(Rotation3::from_axis_angle(&Vector3::y_axis(), x).inverse() * a).x",
        "x.cos() * a[0] - x.sin() * a[2]",
    ),
    (
        "Rotation3::from_euler_angles(x, y, 0.0)[(0, 2)]",
        "y.sin() * x.cos()",
    ),
    (
        "(Rotation3::from_euler_angles(0.0, 0.0, x) * Vector3::x()).y",
        "x.sin()",
    ),
    ("Rotation3::identity().matrix().trace() * x", "3.0 * x"),
    (
        "Unit::new_normalize(Vector2::new(x, y)).into_inner().x",
        "x / (x * x + y * y).sqrt()",
    ),
];

#[test]
fn operations_are_those_of_their_entries() {
    for (vectors, arrays) in OPERATIONS {
        let vectors = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{
                let (a, b, x, y) = (q, v, self.x, self.y);
                let m = Matrix3::new(self.m[0][0], x, y, q.x, q.y, q.z, v.x, v.y, v.z);
                {vectors}
            }}"
        );
        let arrays = format!(
            "fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {{
                let (a, b, x, y) = (q, v, self.x, self.y);
                let m = [[self.m[0][0], x, y], q, v];
                {arrays}
            }}"
        );
        let touch = "+ 0.0 * (self.x + self.y + self.m[0][0])";
        // the parameters are named in the same order in both
        let first = |text: &str| text.replacen("{\n", &format!("{{ let _ = 0.0 {touch};\n"), 1);
        assert_same(&first(&vectors), &first(&arrays));
    }
}

/// Blocks whose parameters have types of nalgebra, and the same with arrays of parameters of the same names.
#[test]
fn types_of_parameters_follow_from_their_uses() {
    let mut wrong = Vec::new();
    for (body, reads) in [
        // beside a vector in a sum, as an argument or receiver, and by components
        (
            "(q - self.g).norm_squared()",
            &["self.g.x", "self.g.y", "self.g.z"][..],
        ),
        ("q.dot(&self.g)", &["self.g.x", "self.g.y", "self.g.z"]),
        ("self.g.dot(&q)", &["self.g.x", "self.g.y", "self.g.z"]),
        (
            "self.g.cross(&self.h).norm() + q.x",
            &[
                "self.g.x", "self.g.y", "self.g.z", "self.h.x", "self.h.y", "self.h.z",
            ],
        ),
        ("self.g.z * q.z", &["self.g.z"]),
        ("self.m[(0, 1)] * q.x", &["self.m[(0,1)]"]),
        (
            "self.a[1].dot(&q)",
            &["self.a[1].x", "self.a[1].y", "self.a[1].z"],
        ),
        (
            "self.a.iter().zip([q, v]).map(|(a, b)| (a - b).x).sum::<f64>()",
            &["self.a[0].x", "self.a[1].x"],
        ),
        ("let mut a = q; a += self.g; a.y", &["self.g.y"]),
        // in products a number
        (
            "(self.k * q).x + (q / self.l).y + (v * self.m).z",
            &["self.k", "self.l", "self.m"],
        ),
        (
            "let k: f64 = self.k; (k * Matrix3::identity() * q).x",
            &["self.k"],
        ),
        // by the type that is written
        (
            "let m: Matrix2<f64> = self.m; m.trace() + q.x",
            &["self.m[(0,0)]", "self.m[(1,1)]"],
        ),
        (
            "let m: &na::Matrix3<f64> = &self.m; (m * q).y",
            &["self.m[(1,0)]", "self.m[(1,1)]", "self.m[(1,2)]"],
        ),
        (
            "let r: Rotation3<f64> = self.r; (r * q).x",
            &["self.r[(0,0)]", "self.r[(0,1)]", "self.r[(0,2)]"],
        ),
        (
            "let g: SVector<f64, 7> = self.g; g[6] * q.x",
            &["self.g[6]"],
        ),
        (
            "let (g, a): (Vector2<f64>, [Vector2<f64>; 2]) = (self.g, self.a); g.dot(&a[1]) + q.x",
            &["self.g.x", "self.a[1].x", "self.g.y", "self.a[1].y"],
        ),
        ("Self::length(self.g) + q.x", &["self.g.x", "self.g.y"]),
        ("self.arm().y + q.x", &["self.arm.y"]),
        ("Vector2::from(self.w).y + q.x", &["self.w[1]"]),
        ("Matrix2::from(self.w)[(0, 1)] + q.x", &["self.w[1][0]"]),
        ("WIND.dot(&q)", &["WIND.x", "WIND.y", "WIND.z"]),
    ] {
        let members = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{ {body} }}
            fn length(x: Vector2<f64>) -> f64 {{ x.norm() }}
            fn arm(&self) -> Vector3<f64> {{ self.arm }}"
        );
        let mut arena = Arena::new();
        let model = match model(&members, &mut arena) {
            Ok(model) => model,
            Err(mistakes) => {
                wrong.push(format!("{body}: {mistakes:?}"));
                continue;
            }
        };
        let access = |symbol| match model.symbols.meaning(symbol) {
            Meaning::Parameter { access, .. } if arena.contains(model.lagrangian, symbol) => {
                Some(access.to_string().replace(' ', ""))
            }
            _ => None,
        };
        let mut found: Vec<String> = model.symbols.parameters().filter_map(access).collect();
        let mut reads = reads.to_vec();
        found.sort_unstable();
        reads.sort_unstable();
        if found != reads {
            wrong.push(format!("{body}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Bodies with one mistake: the token at which it is reported, and a part of the message.
const MISTAKES: &[(&str, &str, &str)] = &[
    // what is not smooth
    ("q.abs().sum()", "abs", "no derivative at 0"),
    ("q.max()", "max", "not smooth in the entries"),
    ("q.amax()", "amax", "not smooth in the entries"),
    ("q.argmax().1", "argmax", "not smooth in the entries"),
    ("q.angle(&v)", "angle", "atan2(a.dot(&b))"),
    ("q.slerp(&v, 0.5).x", "slerp", "v.normalize()"),
    // what is not understood
    (
        "m.lu().determinant()",
        "lu",
        "a factorisation is no formula",
    ),
    (
        "m.try_inverse().unwrap().trace()",
        "try_inverse",
        "a factorisation is no formula",
    ),
    (
        "let mut a = q; a.normalize_mut(); a.x",
        "normalize_mut",
        "assign to it",
    ),
    (
        "let mut a = q; a.copy_from(&v); a.x",
        "copy_from",
        "assign to it",
    ),
    ("q.sin().x", "sin", "v.map(|x| x.sin(…))"),
    ("q.powi(2)", "powi", "v.norm_squared()"),
    ("q.dott(&v)", "dott", "did you mean `dot`?"),
    ("q.shape().0", "shape", "sizes are in the types"),
    (
        "self.m.lu().determinant()",
        "lu",
        "a factorisation is no formula",
    ),
    (
        "self.m.determinant()",
        "determinant",
        "`let m: Matrix3<f64> = self.m;`",
    ),
    (
        "self.m.row(0).sum()",
        "row",
        "`let m: Matrix3<f64> = self.m;`",
    ),
    (
        "(self.m * 2.0).trace()",
        "trace",
        "`let m: Matrix3<f64> = self.m;`",
    ),
    ("q.fixed_rows(1).x", "fixed_rows", "fixed_rows::<3>(0)"),
    (
        "Rotation3::new(q).matrix().trace()",
        "new",
        "divides by the angle",
    ),
    ("Vector3::from_vec(vec).x", "vec", "not known here"),
    (
        "Vector3::new_random().x",
        "new_random",
        "vectors and matrices are made by",
    ),
    (
        "SVector::zeros().x",
        "zeros",
        "the size is not written here",
    ),
    (
        "Vector3::<f32>::zeros().x",
        "Vector3::<f32>",
        "every number of a body is an `f64`",
    ),
    (
        "SMatrix::<f64, 100, 100>::zeros().trace()",
        "zeros",
        "too many entries",
    ),
    // sizes and operators
    (
        "(q + q.xy()).x",
        "+",
        "a `Vector3<f64>` and a `Vector2<f64>` have no sum",
    ),
    ("(q + 1.0).x", "+", "v.add_scalar(x)"),
    ("(q * v).x", "*", "a.dot(&b)"),
    ("(m * q.xy()).x", "*", "the columns of the first"),
    ("(1.0 / q).x", "/", "component_div"),
    ("(q / m).x", "/", "nothing is divided by a matrix"),
    ("(q % 2.0).x", "%", "not smooth"),
    ("(q / 0.0).x", "0.0", "divides by zero"),
    ("(2 * q).x", "2", "write `2.0`"),
    ("(q.x + q)", "+", "have no sum"),
    (
        "q.dot(&m)",
        "&m",
        "`dot` takes a `Vector3<f64>` here, and this is a `Matrix3<f64>`",
    ),
    ("q.dot()", "dot", "`dot` takes 1 argument, here are none"),
    (
        "q.scale(v).x",
        "v",
        "expected an `f64`, found a `Vector3<f64>`: take an entry",
    ),
    ("q.xy().cross(&v.xy()).x", "cross", "vectors of length 3"),
    (
        "Matrix2x3::zeros().determinant()",
        "determinant",
        "square matrices",
    ),
    (
        "q[3]",
        "3",
        "index 3 is out of range: a `Vector3<f64>` has the entries `.x`, `.y`, `.z`",
    ),
    ("m[(3, 0)]", "(3, 0)", "index (3, 0) is out of range"),
    ("m.row(3)[0]", "3", "there are 3 rows"),
    (
        "q.w",
        "w",
        "has no such entry: its entries are `.x`, `.y`, `.z`",
    ),
    ("m.m14", "m14", "has no such entry"),
    (
        "q.fixed_rows::<3>(1).x",
        "1",
        "3 rows from 1 on are not within the 3",
    ),
    (
        "Vector3::new(1.0, 2.0).x",
        "new",
        "`new` of a `Vector3<f64>` takes 3 numbers, here are 2",
    ),
    ("Vector3::new(1, 2.0, 3.0).x", "1", "write `1.0`"),
    (
        "Matrix2::from_columns(&[q.xy()]).trace()",
        "from_columns",
        "this matrix has 2 columns, here is 1",
    ),
    (
        "Vector3::from([1.0, 2.0]).x",
        "[1.0, 2.0]",
        "expected a `Vector3<f64>`, found an array of 2",
    ),
    ("Vector2::z().x", "z", "has no axis `z`"),
    (
        "-Rotation2::new(q.x) * v.xy()",
        "-",
        "a rotation has no negative",
    ),
    (
        "(2.0 * Rotation2::new(q.x)).matrix().trace()",
        "*",
        "into_inner",
    ),
    (
        "q",
        "q",
        "expected an `f64`, found a `Vector3<f64>`: take an entry",
    ),
    // parameters whose type is not seen
    (
        "self.g.norm()",
        "norm",
        "the type of `self.g` is not known to the macro: name it, `let g: Vector3<f64> = self.g;`",
    ),
    (
        "self.a.dot(&self.b)",
        "dot",
        "the type of `self.a` is not known",
    ),
    (
        "self.g.fixed_rows::<2>(0).norm_squared()",
        "fixed_rows",
        "the type of `self.g` is not known to the macro: name it, `let g: Vector3<f64> = self.g;`",
    ),
    (
        "self.g.fixed_view::<2, 2>(0, 0).trace()",
        "fixed_view",
        "name it, `let g: Matrix3<f64> = self.g;`",
    ),
    (
        "self.g.zip_map(&q, |a, b| a * b).sum()",
        "zip_map",
        "the type of `self.g` is not known",
    ),
    (
        "use physics::consts; q.x",
        "consts",
        "imported within this body",
    ),
    (
        "self.g.map(|x| x * x).sum()",
        "map",
        "of a vector write `let g: Vector3<f64> = self.g;`",
    ),
    (
        "(Rotation2::new(q.x) * self.g).x",
        "self.g",
        "the type of `self.g` is not known",
    ),
    ("(self.k * self.g).dot(&q)", "dot", "taken for one"),
    (
        "(self.k * self.g + q).x",
        "+",
        "`self.g` is taken for a number",
    ),
    ("(-self.g + q).x", "+", "`self.g` is taken for a number"),
    ("let g: f64 = self.g; g.dot(&q)", "dot", "this is a number"),
    ("q.x.dot(&v)", "dot", "this is a number"),
];

#[test]
fn mistakes_are_reported_at_their_tokens() {
    let mut wrong = Vec::new();
    for (body, at, part) in MISTAKES {
        let members = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{
                let m = Matrix3::from_columns(&[q, v, q.cross(&v)]);
                {body}
            }}"
        );
        let found = model(&members, &mut Arena::new()).err().unwrap_or_default();
        let is_reported = |(text, message): &(String, String)| text == at && message.contains(part);
        if found.len() != 1 || !found.iter().all(is_reported) {
            wrong.push(format!("{body}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Signatures: what follows the attribute, where a mistake is reported, and a part of its message.
#[test]
fn signatures_have_vectors() {
    let free = "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 { v.norm_squared() }";
    for members in [
        "fn lagrangian(&self, q: na::Vector1<f64>, v: nalgebra::Vector1<f64>) -> f64 { v.x * v.x }".to_owned(),
        "const N: usize = 9; fn lagrangian(&self, q: SVector<f64, { Self::N }>, v: SVector<f64, 9>) -> f64 { v.norm_squared() }".to_owned(),
        "fn lagrangian(&self, t: f64, q: [SVector<f64, 2>; 3], v: [Vector2<f64>; 3]) -> f64 { t * v.iter().map(|v| v.dot(v)).sum::<f64>() }".to_owned(),
        format!("{free} #[gamma] fn a(&self, q: Vector3<f64>) -> Vector2<f64> {{ q.xy() }} #[gamma] fn b(&self, q: SVector<f64, 3>) -> [f64; 2] {{ [q.x, q.y] }}"),
        format!("{free} #[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {{ self.pull }} #[symmetry] fn b(&self, q: Vector3<f64>) -> Vector3<f64> {{ Vector3::x() }}"),
    ] {
        let found = model(&members, &mut Arena::new()).err();
        assert!(found.is_none(), "{members}: {found:?}");
    }
}

#[test]
fn wrong_signatures_are_errors_at_their_types() {
    let free = "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 { v.norm_squared() }";
    let lagrangian =
        |q: &str, v: &str| format!("fn lagrangian(&self, q: {q}, v: {v}) -> f64 {{ 1.0 }}");
    for (members, at, part) in [
        (
            lagrangian("Vector3<f64>", "Vector2<f64>"),
            "Vector2<f64>",
            "must be of the same type: here `Vector2<f64>`, there `Vector3<f64>`",
        ),
        (
            lagrangian("[f64; 3]", "Vector3<f64>"),
            "Vector3<f64>",
            "must be of the same type: here `Vector3<f64>`, there `[f64; 3]`",
        ),
        (
            lagrangian("Vector3<f64>", "[f64; 3]"),
            "[f64; 3]",
            "must be of the same type",
        ),
        (
            lagrangian("Vector3<f32>", "Vector3<f32>"),
            "Vector3<f32>",
            "not a type of coordinates",
        ),
        (
            lagrangian("Matrix2<f64>", "Matrix2<f64>"),
            "Matrix2<f64>",
            "`Vector3<f64>` or `SVector<f64, N>`",
        ),
        (
            lagrangian("&Vector3<f64>", "&Vector3<f64>"),
            "&Vector3<f64>",
            "by value",
        ),
        (
            lagrangian("Vector3", "Vector3"),
            "Vector3",
            "write `Vector3<f64>`",
        ),
        (
            lagrangian("SVector<f64>", "SVector<f64>"),
            "SVector<f64>",
            "write `SVector<f64, N>`",
        ),
        (
            lagrangian("SVector<f64, N>", "SVector<f64, N>"),
            "N",
            "outside of this `impl` block",
        ),
        (
            lagrangian("SVector<f64, 600>", "SVector<f64, 600>"),
            "SVector<f64, 600>",
            "too many to unroll",
        ),
        (
            lagrangian("SVector<f64, 0>", "SVector<f64, 0>"),
            "SVector<f64, 0>",
            "at least one coordinate",
        ),
        (
            format!("{free} #[gamma] fn a(&self, q: Vector2<f64>) -> f64 {{ q.x }}"),
            "Vector2<f64>",
            "of the same type",
        ),
        (
            format!(
                "{free} #[gamma] fn a(&self, q: Vector3<f64>) -> RowVector2<f64> {{ q.xy().transpose() }}"
            ),
            "RowVector2<f64>",
            "not a type of coordinates",
        ),
        (
            format!(
                "{free} #[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> [f64; 3] {{ v.into() }}"
            ),
            "[f64; 3]",
            "a vector like the coordinates, `Vector3<f64>`",
        ),
        (
            format!(
                "{free} #[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {{ v.xy() }}"
            ),
            "a",
            "expected a `Vector3<f64>`, found a `Vector2<f64>`",
        ),
    ] {
        let found = model(&members, &mut Arena::new()).err().unwrap_or_default();
        assert!(
            !found.is_empty() && found[0].0 == at && found[0].1.contains(part),
            "{members}: {found:?}"
        );
    }
}

/// The block as it is emitted after its errors.
fn mended(members: &str) -> String {
    let item = tokens(&format!("impl P {{ {members} }}"));
    let output = crate::tests::expand(&tokens("midpoint"), &item).to_string();
    let from = output.find("impl P").expect("the block");
    let to = output
        .find("# [automatically_derived]")
        .expect("implementations");
    output[from..to].to_owned()
}

/// What is left for the compiler after a mistake has no mistake in its types.
#[test]
fn constants_and_lengths_are_mended() {
    let block = mended(
        "const G: Vector2<f64> = Vector2::new(0.0, 3);
        fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 { v.dot(&v) + Self::G.x }
        fn other(&self, x: Vector2<f64>) -> f64 { x.dot(&Self::G) }",
    );
    assert!(
        block.contains("< Vector2 < f64 > > :: new (0.0 , 0.0)"),
        "{block}"
    );
    assert!(block.contains("x . dot"), "{block}");
    let block = mended(
        "const N: usize = 2;
        fn lagrangian(&self, q: SVector<f64, N>, v: na::SVector<f64, N>) -> f64 { v.dot(&v) }",
    );
    assert_eq!(
        block.matches("SVector < f64 , { Self :: N } >").count(),
        2,
        "{block}"
    );
}
