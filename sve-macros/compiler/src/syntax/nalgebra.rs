//! Types of nalgebra as the source spells them: `Vector3<f64>`, `SMatrix<f64, 2, 3>`,
//! `na::Rotation3<f64>`.
//!
//! Input: a type or the path of a constructor. Output: the kind of the type, and its sizes as the
//! source spells them. A type is recognised by its last name, since the macro does not see imports.

use syn::{Expr, GenericArgument, Path, PathArguments, Type};

use crate::syntax::bare;
use crate::syntax::parse::is_f64;

/// Largest size in the names of nalgebra's types.
const NAMED: usize = 6;

/// The kind of a type of nalgebra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A matrix; a vector is a matrix of one column.
    Matrix,
    /// `Rotation2` and `Rotation3`, which are stored as a matrix.
    Rotation,
    /// `Unit` of a vector.
    Unit,
}

/// A number of rows or columns in the source.
#[derive(Clone)]
pub(crate) enum Size {
    Known(usize),
    /// A generic argument.
    Written(Box<Expr>),
    /// The path of a constructor without generic arguments.
    Omitted,
}

/// A type of nalgebra.
#[derive(Clone)]
pub(crate) struct Written {
    pub(crate) kind: Kind,
    pub(crate) rows: Size,
    pub(crate) columns: Size,
    /// True if the entries are `f64`; `None` if the source does not say their type.
    pub(crate) has_floats: Option<bool>,
}

impl Written {
    /// Reads a type; `None` if it is not a type of nalgebra.
    pub(crate) fn of_type(ty: &Type) -> Option<Self> {
        match bare(ty) {
            Type::Path(path) if path.qself.is_none() => Self::of_path(&path.path),
            _ => None,
        }
    }

    /// Reads a path that names a type; `None` if it is not a type of nalgebra.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let last = path.segments.last()?;
        let arguments: Vec<&GenericArgument> = match &last.arguments {
            PathArguments::AngleBracketed(generics) => generics.args.iter().collect(),
            _ => Vec::new(),
        };
        let name = last.ident.to_string();
        if name == "Unit" {
            let inner = match arguments.as_slice() {
                [GenericArgument::Type(inner)] => Self::of_type(inner)?,
                _ => Self {
                    kind: Kind::Unit,
                    rows: Size::Omitted,
                    columns: Size::Known(1),
                    has_floats: None,
                },
            };
            return Some(Self {
                kind: Kind::Unit,
                ..inner
            });
        }
        let (kind, sizes) = named(&name)?;
        let mut arguments = arguments.into_iter();
        let has_floats = arguments.next().map(|argument| match argument {
            GenericArgument::Type(Type::Infer(_)) => true,
            GenericArgument::Type(ty) => is_f64(ty),
            _ => false,
        });
        let [rows, columns] = sizes.map(|size| match size {
            Some(size) => Size::Known(size),
            None => arguments
                .next()
                .and_then(length)
                .map_or(Size::Omitted, |argument| Size::Written(Box::new(argument))),
        });
        Some(Self {
            kind,
            rows,
            columns,
            has_floats,
        })
    }

    /// Returns whether the type is a vector, that is, has one column.
    pub(crate) fn is_vector(&self) -> bool {
        self.kind == Kind::Matrix && matches!(self.columns, Size::Known(1))
    }
}

/// Returns the kind and the sizes of the type with this name. A size that is a generic argument is
/// `None`.
fn named(name: &str) -> Option<(Kind, [Option<usize>; 2])> {
    match name {
        "SVector" => return Some((Kind::Matrix, [None, Some(1)])),
        "RowSVector" => return Some((Kind::Matrix, [Some(1), None])),
        "SMatrix" => return Some((Kind::Matrix, [None, None])),
        "Rotation2" => return Some((Kind::Rotation, [Some(2); 2])),
        "Rotation3" => return Some((Kind::Rotation, [Some(3); 2])),
        _ => {}
    }
    let size = |digits: &str| {
        let size = digits.parse::<usize>().ok()?;
        (digits.len() == 1 && (1..=NAMED).contains(&size)).then_some(size)
    };
    let one = Some(1);
    if let Some(digits) = name.strip_prefix("RowVector") {
        return Some((Kind::Matrix, [one, Some(size(digits)?)]));
    }
    if let Some(digits) = name.strip_prefix("UnitVector") {
        return Some((Kind::Unit, [Some(size(digits)?), one]));
    }
    if let Some(digits) = name.strip_prefix("Vector") {
        return Some((Kind::Matrix, [Some(size(digits)?), one]));
    }
    let digits = name.strip_prefix("Matrix")?;
    let (rows, columns) = digits.split_once('x').unwrap_or((digits, digits));
    Some((Kind::Matrix, [Some(size(rows)?), Some(size(columns)?)]))
}

/// Returns a size among generic arguments: a literal, a block, or a name, which the parser reads as
/// a type.
pub(crate) fn length(argument: &GenericArgument) -> Option<Expr> {
    match argument {
        GenericArgument::Const(length) => Some(length.clone()),
        GenericArgument::Type(Type::Path(name)) => Some(Expr::Path(syn::ExprPath {
            attrs: Vec::new(),
            qself: name.qself.clone(),
            path: name.path.clone(),
        })),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Kind, Size, Written};

    /// Kind, number of rows, number of columns, and whether the entries are `f64`.
    type Read = (Kind, Option<usize>, Option<usize>, Option<bool>);

    fn read(text: &str) -> Option<Read> {
        let known = |size: &Size| match size {
            Size::Known(n) => Some(*n),
            Size::Written(_) | Size::Omitted => None,
        };
        let written = Written::of_type(&syn::parse_str(text).expect("a type"))?;
        Some((
            written.kind,
            known(&written.rows),
            known(&written.columns),
            written.has_floats,
        ))
    }

    #[test]
    fn types_are_known_by_their_last_name() {
        let vector = Some((Kind::Matrix, Some(3), Some(1), Some(true)));
        for text in [
            "Vector3<f64>",
            "nalgebra::Vector3<f64>",
            "na::Vector3<f64>",
            "::sve_runtime::nalgebra::Vector3<f64>",
        ] {
            assert_eq!(read(text), vector, "{text}");
        }
        assert_eq!(read("Vector3<f32>").and_then(|t| t.3), Some(false));
        assert_eq!(read("Vector3").and_then(|t| t.3), None);
        let floats = Some(true);
        for (text, expected) in [
            ("Matrix2<f64>", (Kind::Matrix, Some(2), Some(2), floats)),
            ("Matrix2x3<f64>", (Kind::Matrix, Some(2), Some(3), floats)),
            ("RowVector4<f64>", (Kind::Matrix, Some(1), Some(4), floats)),
            ("Rotation3<f64>", (Kind::Rotation, Some(3), Some(3), floats)),
            ("UnitVector3<f64>", (Kind::Unit, Some(3), Some(1), floats)),
            ("Unit<Vector2<f64>>", (Kind::Unit, Some(2), Some(1), floats)),
            ("SVector<f64, 7>", (Kind::Matrix, None, Some(1), floats)),
            (
                "SMatrix<f64, { Self::N }, 7>",
                (Kind::Matrix, None, None, floats),
            ),
        ] {
            assert_eq!(read(text), Some(expected), "{text}");
        }
    }

    #[test]
    fn other_types_are_not_of_nalgebra() {
        for text in [
            "f64",
            "[f64; 3]",
            "Vector7<f64>",
            "Vector",
            "Matrix0<f64>",
            "Matrix2x",
            "DVector<f64>",
            "Vector33<f64>",
            "Unit<f64>",
            "<T as Trait>::Vector3<f64>",
        ] {
            assert!(read(text).is_none(), "{text}");
        }
    }
}
