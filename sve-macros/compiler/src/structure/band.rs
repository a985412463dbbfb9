//! Orders the equations and unknowns of a block so that the nonzero entries of its Jacobian lie
//! near the diagonal.
//!
//! Input: the unknowns in each equation. Output: an order of both, if a banded solve costs less
//! than a dense one. Unknowns are numbered along a breadth-first search from one far end of the
//! graph of equations and unknowns (Cuthill and `McKee`, Reducing the bandwidth of sparse symmetric
//! matrices, 1969; the end is found as by George and Liu). Equations are ordered by the middle of
//! their unknowns.

use std::collections::VecDeque;

use crate::algebra::Expr;

/// Size of the smallest block that is solved as a banded one. The compiler unrolls the loops of
/// smaller dense blocks.
const SMALLEST: usize = 5;

/// The entries of a matrix that may differ from zero: from `lower` entries before the diagonal to
/// `upper` entries behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Band {
    pub(crate) lower: usize,
    pub(crate) upper: usize,
}

/// An order of the equations and unknowns of a block.
pub(super) struct Order {
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
}

impl Band {
    /// Returns the band of a matrix, if solving with it costs less than a dense solve.
    pub(super) fn of(matrix: &[Vec<Expr>], is_zero: impl Fn(Expr) -> bool) -> Option<Self> {
        let columns = |row: &Vec<Expr>| {
            let present = row.iter().enumerate().filter(|x| !is_zero(*x.1));
            present.map(|x| x.0).collect()
        };
        let pattern: Vec<Vec<usize>> = matrix.iter().map(columns).collect();
        let band = Self::around(&pattern);
        band.pays(matrix.len()).then_some(band)
    }

    /// Returns the band of a pattern: for each row the columns of its entries, ascending.
    fn around(pattern: &[Vec<usize>]) -> Self {
        let (mut lower, mut upper) = (0, 0);
        for (i, columns) in pattern.iter().enumerate() {
            if let (Some(&first), Some(&last)) = (columns.first(), columns.last()) {
                lower = lower.max(i.saturating_sub(first));
                upper = upper.max(last.saturating_sub(i));
            }
        }
        Self { lower, upper }
    }

    /// Returns the number of entries of a row.
    pub(crate) fn width(self) -> usize {
        self.lower + 1 + self.upper
    }

    /// Returns the number of operations of a solve: each row is subtracted from `lower` others,
    /// each with `width` entries.
    fn work(self, size: usize) -> usize {
        size * (self.lower + 1) * self.width()
    }

    /// Returns whether a banded solve costs less than a dense one, K³/3.
    fn pays(self, size: usize) -> bool {
        size >= SMALLEST && 3 * self.work(size) < size.pow(3)
    }

    /// Returns the first column of a row.
    pub(super) fn begin(self, row: usize) -> usize {
        row.saturating_sub(self.lower)
    }

    /// Returns the rows of a matrix in the layout of the runtime's `Banded`: `width` entries from
    /// the first column of the band on.
    pub(super) fn rows(self, matrix: &[Vec<Expr>], zero: Expr) -> Vec<Vec<Expr>> {
        let row = |(i, row): (usize, &Vec<Expr>)| {
            let begin = self.begin(i);
            let entries =
                (begin..begin + self.width()).map(|j| row.get(j).copied().unwrap_or(zero));
            entries.collect()
        };
        matrix.iter().enumerate().map(row).collect()
    }
}

/// Returns an order in which a banded solve pays; `None` if there is none or if the present order
/// is such an order.
///
/// `depends` has the columns of the entries of each row, ascending.
pub(super) fn order(depends: &[Vec<usize>]) -> Option<Order> {
    let n = depends.len();
    if n < SMALLEST {
        return None;
    }
    let candidates = [(0..n).collect(), cuthill_mckee(depends)];
    let orders = candidates.map(|columns| {
        let order = with_rows(columns, depends);
        (order.band(depends).work(n), order)
    });
    let [given, searched] = orders;
    let (_, best) = if searched.0 < given.0 {
        searched
    } else {
        given
    };
    best.band(depends).pays(n).then_some(best)
}

impl Order {
    fn band(&self, depends: &[Vec<usize>]) -> Band {
        let mut place = vec![0; self.columns.len()];
        for (at, &column) in self.columns.iter().enumerate() {
            place[column] = at;
        }
        let pattern: Vec<Vec<usize>> = self
            .rows
            .iter()
            .map(|&row| {
                let mut columns: Vec<usize> = depends[row].iter().map(|&c| place[c]).collect();
                columns.sort_unstable();
                columns
            })
            .collect();
        Band::around(&pattern)
    }
}

/// Returns an order with the given order of unknowns and the equations ordered by the middle of
/// their unknowns.
fn with_rows(columns: Vec<usize>, depends: &[Vec<usize>]) -> Order {
    let mut place = vec![0; columns.len()];
    for (at, &column) in columns.iter().enumerate() {
        place[column] = at;
    }
    let middle = |row: &usize| {
        let places = || depends[*row].iter().map(|&c| place[c]);
        places().min().unwrap_or(0) + places().max().unwrap_or(0)
    };
    let mut rows: Vec<usize> = (0..depends.len()).collect();
    rows.sort_by_key(middle);
    Order { rows, columns }
}

/// Orders unknowns along breadth-first searches from far ends.
fn cuthill_mckee(depends: &[Vec<usize>]) -> Vec<usize> {
    let n = depends.len();
    let mut rows_of: Vec<Vec<usize>> = vec![Vec::new(); n];
    for (row, columns) in depends.iter().enumerate() {
        for &column in columns {
            rows_of[column].push(row);
        }
    }
    // unknowns in few equations come first
    for columns in &mut rows_of {
        columns.sort_by_key(|&row| depends[row].len());
    }
    let mut order: Vec<usize> = Vec::new();
    let mut numbered = vec![false; n];
    for start in 0..n {
        if numbered[start] {
            continue;
        }
        let (mut reached, mut depth) = search(start, depends, &rows_of);
        // goes to the farthest unknown until the distance grows no more
        loop {
            let end = reached[reached.len() - 1];
            let (again, deeper) = search(end, depends, &rows_of);
            if deeper <= depth {
                break;
            }
            (reached, depth) = (again, deeper);
        }
        for &column in &reached {
            numbered[column] = true;
        }
        order.extend(reached);
    }
    order
}

/// Returns the unknowns in the order in which a breadth-first search reaches them, and the distance
/// of the last one.
fn search(start: usize, depends: &[Vec<usize>], rows_of: &[Vec<usize>]) -> (Vec<usize>, usize) {
    let mut seen_row = vec![false; depends.len()];
    let mut distance: Vec<Option<usize>> = vec![None; rows_of.len()];
    let mut queue = VecDeque::from([start]);
    distance[start] = Some(0);
    let (mut order, mut last) = (Vec::new(), 0);
    while let Some(column) = queue.pop_front() {
        order.push(column);
        last = distance[column].unwrap_or(last);
        for &row in &rows_of[column] {
            if std::mem::replace(&mut seen_row[row], true) {
                continue;
            }
            let mut fresh: Vec<usize> = depends[row]
                .iter()
                .copied()
                .filter(|&c| distance[c].is_none())
                .collect();
            fresh.sort_by_key(|&c| rows_of[c].len());
            for c in fresh {
                distance[c] = Some(last + 1);
                queue.push_back(c);
            }
        }
    }
    (order, last)
}

#[cfg(test)]
mod tests {
    use super::{Band, Order, order};

    /// Returns the pattern of pairs of neighbours, renumbered modulo `n` by the factor `step`.
    fn pattern(n: usize, step: usize, neighbours: impl Fn(usize) -> Vec<usize>) -> Vec<Vec<usize>> {
        let name = |i: usize| i * step % n;
        let mut depends = vec![Vec::new(); n];
        for i in 0..n {
            // equations are numbered backwards, against the order of the unknowns
            let row = &mut depends[n - 1 - name(i)];
            row.extend(neighbours(i).into_iter().map(name));
            row.sort_unstable();
        }
        depends
    }

    fn band(depends: &[Vec<usize>]) -> Option<Band> {
        let order = order(depends)?;
        let Order { rows, columns } = &order;
        for list in [rows, columns] {
            let mut sorted = list.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..depends.len()), "{list:?}");
        }
        Some(order.band(depends))
    }

    fn chain(n: usize) -> impl Fn(usize) -> Vec<usize> {
        move |i| (i.saturating_sub(1)..(i + 2).min(n)).collect()
    }

    #[test]
    fn a_chain_is_tridiagonal_in_any_numbering() {
        let tridiagonal = Some(Band { lower: 1, upper: 1 });
        for step in [1, 7, 11, 19] {
            assert_eq!(band(&pattern(40, step, chain(40))), tridiagonal, "{step}");
        }
    }

    #[test]
    fn a_ring_is_folded() {
        let ring = |i: usize| vec![(i + 39) % 40, i, (i + 1) % 40];
        for step in [1, 7, 11] {
            let found = band(&pattern(40, step, ring)).unwrap();
            assert!(found.lower <= 3 && found.upper <= 3, "{step}: {found:?}");
        }
    }

    #[test]
    fn a_lattice_has_the_band_of_its_narrow_side() {
        let lattice = |i: usize| {
            let (x, y) = (i / 4, i % 4);
            let near = |j: &usize| x.abs_diff(j / 4) + y.abs_diff(j % 4) <= 1;
            (0..80).filter(near).collect()
        };
        for step in [1, 3, 7] {
            let found = band(&pattern(80, step, lattice)).unwrap();
            assert!(found.lower <= 6 && found.upper <= 6, "{step}: {found:?}");
        }
    }

    #[test]
    fn parts_without_connection_are_numbered_one_after_the_other() {
        let pairs = |i: usize| vec![i / 2 * 2, i / 2 * 2 + 1];
        let found = band(&pattern(40, 7, pairs)).unwrap();
        assert!(found.lower <= 1 && found.upper <= 1, "{found:?}");
    }

    #[test]
    fn full_bordered_and_small_blocks_are_dense() {
        assert_eq!(band(&pattern(40, 1, |_| (0..40).collect())), None);
        let arrow = |i: usize| {
            if i == 0 {
                (0..40).collect()
            } else {
                vec![0, i]
            }
        };
        assert_eq!(band(&pattern(40, 1, arrow)), None);
        assert_eq!(band(&pattern(4, 1, chain(4))), None);
        assert!(band(&pattern(5, 1, chain(5))).is_some());
    }
}
