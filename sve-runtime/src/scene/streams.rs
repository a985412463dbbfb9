//! What a printed loop reads: slices in which the index advances by one from node to node.
//!
//! The loops are here, and the body is a closure or a function of generated code. All slices are
//! arguments of the function with the loop and are cut to one length, so that the loop has no
//! bounds to check, and the compiler knows that the written slice overlaps no other.

use core::array::from_fn;
use core::marker::PhantomData;

use super::Row;

/// What the impulse of a node reads.
pub trait Reads<R> {
    /// Returns the row of the node.
    fn own(&self) -> R;
    /// Returns the row of stream `number`.
    fn row(&self, number: usize) -> R;
    /// Returns the number of column stream `number`.
    fn column(&self, number: usize) -> f64;
    /// Returns the increment of increment stream `number`.
    fn increment(&self, number: usize) -> f64;
}

/// The streams of consecutive nodes.
#[derive(Clone, Copy, Debug)]
pub struct Streams<'a, R> {
    /// The nodes themselves.
    pub own: &'a [R],
    /// The other rows.
    pub rows: &'a [&'a [R]],
    /// Columns of fields.
    pub columns: &'a [&'a [f64]],
    /// Increments of processes, each belonging to one instance.
    pub increments: &'a [&'a [f64]],
}

/// A place in streams of known numbers.
#[derive(Clone, Copy, Debug)]
pub struct At<'s, 'a, R, const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize> {
    own: &'a [R],
    rows: &'s [&'a [R]; ROWS],
    columns: &'s [&'a [f64]; COLUMNS],
    increments: &'s [&'a [f64]; INCREMENTS],
    at: usize,
}

impl<R: Row, const A: usize, const B: usize, const C: usize> Reads<R> for At<'_, '_, R, A, B, C> {
    #[inline(always)]
    fn own(&self) -> R {
        self.own[self.at]
    }

    #[inline(always)]
    fn row(&self, number: usize) -> R {
        self.rows[number][self.at]
    }

    #[inline(always)]
    fn column(&self, number: usize) -> f64 {
        self.columns[number][self.at]
    }

    #[inline(always)]
    fn increment(&self, number: usize) -> f64 {
        self.increments[number][self.at]
    }
}

/// Adds `impulse` at each place of the streams to `to`. The streams have at least its length, and
/// the numbers `ROWS`, `COLUMNS` and `INCREMENTS`.
#[inline(always)]
pub fn add<R: Row, const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize>(
    streams: &Streams<'_, R>,
    to: &mut [R],
    impulse: impl Fn(&At<'_, '_, R, ROWS, COLUMNS, INCREMENTS>) -> R,
) {
    let m = to.len();
    let own = &streams.own[..m];
    let rows: [&[R]; ROWS] = from_fn(|k| &streams.rows[k][..m]);
    let columns: [&[f64]; COLUMNS] = from_fn(|k| &streams.columns[k][..m]);
    let increments: [&[f64]; INCREMENTS] = from_fn(|k| &streams.increments[k][..m]);
    for at in 0..m {
        to[at].add(impulse(&At {
            own,
            rows: &rows,
            columns: &columns,
            increments: &increments,
            at,
        }));
    }
}

/// Numbers of streams: of rows, of columns of fields, and of increments.
#[derive(Clone, Copy, Debug)]
pub struct Counts<const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize>(
    PhantomData<[(); ROWS]>,
);

/// Numbers of streams as a type.
pub trait StreamCounts {}

impl<const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize> StreamCounts
    for Counts<ROWS, COLUMNS, INCREMENTS>
{
}
