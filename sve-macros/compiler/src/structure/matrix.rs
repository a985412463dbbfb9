//! Matrices with their storage, which is chosen once. Code generation, the counts of operations and
//! the plan read the storage from the matrix.

use super::band::Band;
use crate::algebra::{Arena, Expr};

/// Size of the smallest matrix that is stored and solved as a diagonal one. Smaller matrices keep
/// the formulas of one and two unknowns: Cramer's rule multiplies by the inverse of the
/// determinant, which rounds differently from a division for each unknown.
const SMALLEST_DIAGONAL: usize = 3;

/// The stored entries of a matrix, and so the method by which the runtime solves with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Storage {
    /// All entries; solved by Gaussian elimination with pivoting.
    Dense,
    /// All entries of a 3×3 matrix whose entries share a unit; solved by Cramer's rule.
    Cofactors,
    /// The diagonal; solved by a division for each unknown.
    Diagonal,
    /// The entries near the diagonal; solved by banded elimination.
    Banded(Band),
}

/// A square matrix.
#[derive(Clone, Debug)]
pub(crate) struct Matrix<T> {
    pub(crate) storage: Storage,
    /// The stored entries of each row, in consecutive columns from [`Matrix::first_column`] on.
    /// Rows of a band are padded with zeros to equal widths.
    pub(crate) rows: Vec<Vec<T>>,
}

impl Matrix<Expr> {
    /// Returns a matrix in the storage in which a solve costs the least work.
    pub(crate) fn new(entries: Vec<Vec<Expr>>, arena: &mut Arena) -> Self {
        let zero = arena.constant(0.0);
        let is_zero = |e: Expr| arena.constant_value(e) == Some(0.0);
        let size = entries.len();
        let is_diagonal = entries.iter().enumerate().all(|(i, row)| {
            let mut others = row.iter().enumerate().filter(|x| x.0 != i);
            others.all(|x| is_zero(*x.1))
        });
        if is_diagonal && size >= SMALLEST_DIAGONAL {
            let diagonal = entries.iter().enumerate().map(|(i, row)| vec![row[i]]);
            return Self {
                storage: Storage::Diagonal,
                rows: diagonal.collect(),
            };
        }
        match Band::of(&entries, is_zero) {
            Some(band) => Self {
                storage: Storage::Banded(band),
                rows: band.rows(&entries, zero),
            },
            None => Self::dense(entries),
        }
    }

    /// Returns the Jacobian of the equations of a rotation. Its unknowns share one unit, and so do
    /// its equations.
    pub(crate) fn of_rotation(entries: Vec<Vec<Expr>>, arena: &mut Arena) -> Self {
        let matrix = Self::new(entries, arena);
        match matrix.storage {
            Storage::Dense => Self {
                storage: Storage::Cofactors,
                ..matrix
            },
            Storage::Cofactors | Storage::Diagonal | Storage::Banded(_) => matrix,
        }
    }

    /// Returns a matrix of which all entries are stored, including zeros.
    pub(crate) fn dense(entries: Vec<Vec<Expr>>) -> Self {
        Self {
            storage: Storage::Dense,
            rows: entries,
        }
    }
}

impl<T: Copy> Matrix<T> {
    /// Returns the number of rows.
    pub(crate) fn size(&self) -> usize {
        self.rows.len()
    }

    /// Returns the column of the first stored entry of a row.
    pub(crate) fn first_column(&self, row: usize) -> usize {
        match self.storage {
            Storage::Dense | Storage::Cofactors => 0,
            Storage::Diagonal => row,
            Storage::Banded(band) => band.begin(row),
        }
    }

    /// Returns the stored entries of a row, each with its column.
    pub(crate) fn row(&self, row: usize) -> impl Iterator<Item = (usize, T)> + '_ {
        let (first, size) = (self.first_column(row), self.size());
        let entries = self.rows[row].iter().enumerate();
        let entries = entries.map(move |(at, &entry)| (first + at, entry));
        entries.filter(move |x| x.0 < size)
    }

    /// Returns all entries of a row; `None` for an entry that is not stored, which is zero.
    pub(crate) fn all_entries(&self, row: usize) -> Vec<Option<T>> {
        let mut entries = vec![None; self.size()];
        for (column, entry) in self.row(row) {
            entries[column] = Some(entry);
        }
        entries
    }

    /// Returns all stored entries row by row, including the padding.
    pub(crate) fn stored(&self) -> impl Iterator<Item = T> + '_ {
        self.rows.iter().flatten().copied()
    }

    /// Returns the numbers of stored entries before and behind the diagonal, if not all entries are
    /// stored.
    pub(crate) fn bandwidths(&self) -> Option<(usize, usize)> {
        match self.storage {
            Storage::Dense | Storage::Cofactors => None,
            Storage::Diagonal => Some((0, 0)),
            Storage::Banded(Band { lower, upper }) => Some((lower, upper)),
        }
    }

    /// Returns a matrix with the same storage whose entries are mapped by `entry`.
    pub(crate) fn map<U>(&self, mut entry: impl FnMut(T) -> U) -> Matrix<U> {
        let rows = self.rows.iter();
        Matrix {
            storage: self.storage,
            rows: rows
                .map(|row| row.iter().map(|&e| entry(e)).collect())
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Band, Matrix, Storage};
    use crate::algebra::{Arena, Expr, Symbol};

    /// Returns a matrix with the given pattern.
    fn matrix(
        n: usize,
        is_entry: impl Fn(usize, usize) -> bool,
        arena: &mut Arena,
    ) -> Matrix<Expr> {
        let (zero, entry) = (arena.constant(0.0), arena.symbol(Symbol(0)));
        let of = |i, j| if is_entry(i, j) { entry } else { zero };
        let rows = (0..n).map(|i| (0..n).map(|j| of(i, j)).collect());
        let rows = rows.collect();
        Matrix::new(rows, arena)
    }

    #[test]
    fn storage_is_that_of_the_least_work() {
        let arena = &mut Arena::new();
        let storage = |n, is_entry: fn(usize, usize) -> bool, arena: &mut Arena| {
            matrix(n, is_entry, arena).storage
        };
        let diagonal = |i, j| i == j;
        assert_eq!(storage(2, diagonal, arena), Storage::Dense);
        assert_eq!(storage(3, diagonal, arena), Storage::Diagonal);
        assert_eq!(storage(12, diagonal, arena), Storage::Diagonal);
        let chain = |i: usize, j: usize| i.abs_diff(j) <= 1;
        let band = Band { lower: 1, upper: 1 };
        assert_eq!(storage(4, chain, arena), Storage::Dense);
        assert_eq!(storage(6, chain, arena), Storage::Banded(band));
        assert_eq!(storage(6, |i, j| i + j != 5, arena), Storage::Dense);
    }

    #[test]
    fn a_full_matrix_of_a_rotation_is_solved_by_cofactors() {
        let arena = &mut Arena::new();
        let rows =
            |is_entry: fn(usize, usize) -> bool, arena: &mut Arena| matrix(3, is_entry, arena);
        let full = rows(|_, _| true, arena);
        assert_eq!(full.storage, Storage::Dense);
        let storage = Matrix::of_rotation(full.rows, arena).storage;
        assert_eq!(storage, Storage::Cofactors);
        let zero = arena.constant(0.0);
        let one = arena.constant(1.0);
        let diagonal = (0..3).map(|i| (0..3).map(|j| if i == j { one } else { zero }).collect());
        let storage = Matrix::of_rotation(diagonal.collect(), arena).storage;
        assert_eq!(storage, Storage::Diagonal);
    }

    #[test]
    fn stored_entries_know_their_columns() {
        let arena = &mut Arena::new();
        let zero = arena.constant(0.0);
        let patterns: [fn(usize, usize) -> bool; 3] =
            [|i, j| i == j, |i, j| i.abs_diff(j) <= 1, |i, j| i * j != 6];
        for is_entry in patterns {
            let matrix = matrix(7, is_entry, arena);
            for i in 0..7 {
                let present = matrix.row(i).filter(|x| x.1 != zero).map(|x| x.0);
                let expected: Vec<usize> = (0..7).filter(|&j| is_entry(i, j)).collect();
                assert_eq!(
                    present.collect::<Vec<_>>(),
                    expected,
                    "{:?}",
                    matrix.storage
                );
            }
        }
    }
}
