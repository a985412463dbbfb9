//! The data that a printed loop reads: slices in which the index advances by one from node to node.
//!
//! The loop is here, and its body is a closure or a function of generated code. All slices are
//! arguments of the function with the loop and are cut to one length, so that the loop has no
//! bounds to check, and the compiler knows that the written slice overlaps no other.

use super::Row;
use super::drift::not_finite;
use super::pieces::PairStreams;

/// The values that the impulse of a node reads.
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

/// The streams of consecutive nodes: arrays, and the index in them for the first node.
#[derive(Clone, Copy, Debug)]
pub struct Streams<'a, R> {
    pub(super) q: &'a [R],
    pub(super) node: usize,
    pub(super) rows: &'a [u32],
    pub(super) fields: &'a [f64],
    pub(super) columns: &'a [u32],
    /// The increments of a kick, and of a second one at the same places.
    pub(super) dw: [&'a [f64]; 2],
    pub(super) increments: &'a [u32],
}

impl<R> Streams<'_, R> {
    /// Returns the streams of one pair.
    #[inline(always)]
    pub(super) fn of(&self, pair: &PairStreams) -> Self {
        Self {
            rows: &self.rows[pair.rows.clone()],
            columns: &self.columns[pair.columns.clone()],
            increments: &self.increments[pair.increments.clone()],
            ..*self
        }
    }
}

/// A place in streams of known numbers.
#[derive(Clone, Copy, Debug)]
pub struct At<'s, 'a, R, const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize> {
    own: &'a [R],
    rows: &'s [&'a [R]; ROWS],
    columns: &'s [&'a [f64]; COLUMNS],
    increments: &'s [[&'a [f64]; INCREMENTS]; 2],
    kick: usize,
    place: usize,
}

impl<R, const A: usize, const B: usize, const C: usize> At<'_, '_, R, A, B, C> {
    /// Returns another place, with the increments of a kick.
    #[inline(always)]
    fn of(&self, kick: usize, place: usize) -> Self {
        Self {
            kick,
            place,
            ..*self
        }
    }
}

impl<R: Row, const A: usize, const B: usize, const C: usize> Reads<R> for At<'_, '_, R, A, B, C> {
    #[inline(always)]
    fn own(&self) -> R {
        self.own[self.place]
    }

    #[inline(always)]
    fn row(&self, number: usize) -> R {
        self.rows[number][self.place]
    }

    #[inline(always)]
    fn column(&self, number: usize) -> f64 {
        self.columns[number][self.place]
    }

    #[inline(always)]
    fn increment(&self, number: usize) -> f64 {
        self.increments[self.kick][number][self.place]
    }
}

/// Adds `impulse` at each place of the streams to `to`. The streams have at least the numbers
/// `ROWS`, `COLUMNS` and `INCREMENTS`.
#[inline(always)]
pub fn add<R: Row, const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize>(
    streams: &Streams<'_, R>,
    to: &mut [R],
    impulse: impl Fn(&At<'_, '_, R, ROWS, COLUMNS, INCREMENTS>) -> R,
) {
    put::<Add, R, ROWS, COLUMNS, INCREMENTS>(
        streams,
        to,
        &mut [],
        #[inline(always)]
        |_, at| impulse(at),
    );
}

/// The use of the impulses of a node by two kicks, of which the second may be left out. The
/// function is `#[inline(always)]`.
#[doc(hidden)]
pub trait Put {
    fn put<R: Row>(impulse: impl Fn(usize) -> R, to: &mut R);
}

/// The impulse is added.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub(super) enum Add {}

/// Both impulses are added, one after the other. They have the same derivatives, which the compiler
/// computes once, since nothing is written between them.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub(super) enum AddTwice {}

/// The impulse is written in the place of what is there.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub(super) enum Write {}

impl Put for Add {
    #[inline(always)]
    fn put<R: Row>(impulse: impl Fn(usize) -> R, to: &mut R) {
        to.add(impulse(0));
    }
}

impl Put for AddTwice {
    #[inline(always)]
    fn put<R: Row>(impulse: impl Fn(usize) -> R, to: &mut R) {
        let [first, second] = [impulse(0), impulse(1)];
        to.add(first);
        to.add(second);
    }
}

impl Put for Write {
    #[inline(always)]
    fn put<R: Row>(impulse: impl Fn(usize) -> R, to: &mut R) {
        *to = impulse(0);
    }
}

/// Puts the impulses of both kicks at each place of the streams to `to`. If `kept` is as long as
/// `to`, it gets the old rows, and the new ones are tested: returns whether all are finite.
#[inline(always)]
fn put<P: Put, R: Row, const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize>(
    streams: &Streams<'_, R>,
    to: &mut [R],
    kept: &mut [R],
    impulse: impl Fn(usize, &At<'_, '_, R, ROWS, COLUMNS, INCREMENTS>) -> R,
) -> bool {
    let m = to.len();
    let own = &streams.q[streams.node..][..m];
    // Loops over indices: where a function of an array is not inlined, or a slice may be the one of
    // the start, the bounds are checked for each node, which is then no part of a vector.
    let mut rows = [own; ROWS];
    let mut columns: [&[f64]; COLUMNS] = [&[]; COLUMNS];
    let mut increments: [[&[f64]; INCREMENTS]; 2] = [[&[]; INCREMENTS]; 2];
    #[allow(clippy::needless_range_loop)]
    {
        for k in 0..ROWS {
            rows[k] = &streams.q[streams.rows[k] as usize..][..m];
        }
        for k in 0..COLUMNS {
            columns[k] = &streams.fields[streams.columns[k] as usize..][..m];
        }
        for k in 0..INCREMENTS {
            for kick in 0..2 {
                let dw = streams.dw[kick];
                increments[kick][k] = &dw[streams.increments[k] as usize..][..m];
            }
        }
    }
    let start = At {
        own,
        rows: &rows,
        columns: &columns,
        increments: &increments,
        kick: 0,
        place: 0,
    };
    let is_tested = kept.len() == m;
    let mut bits = 0;
    // two loops, since a test within the loop is not always moved out of it
    if is_tested {
        for place in 0..m {
            kept[place] = to[place];
            P::put(
                #[inline(always)]
                |kick| impulse(kick, &start.of(kick, place)),
                &mut to[place],
            );
            for &x in R::numbers(&to[place..=place]) {
                bits |= not_finite(x);
            }
        }
    } else {
        for place in 0..m {
            P::put(
                #[inline(always)]
                |kick| impulse(kick, &start.of(kick, place)),
                &mut to[place],
            );
        }
    }
    bits == 0
}

/// The impulse of a node.
#[doc(hidden)]
pub trait Impulse<R> {
    /// Returns the impulse of a kick: 0, or 1 for the second one.
    fn at(&self, kick: usize, reads: &impl Reads<R>) -> R;
}

/// Numbers of streams as a type.
pub trait StreamCounts {
    /// Puts the impulses of both kicks at each place of the streams to `to`. If `kept` is as long
    /// as `to`, it gets the old rows, and the new ones are tested: returns whether all are finite.
    #[doc(hidden)]
    fn put<P: Put, R: Row>(
        streams: &Streams<'_, R>,
        to: &mut [R],
        kept: &mut [R],
        impulse: &impl Impulse<R>,
    ) -> bool;
}

/// Numbers of streams: of rows, of columns of fields, and of increments.
#[derive(Clone, Copy, Debug)]
pub struct Counts<const ROWS: usize, const COLUMNS: usize, const INCREMENTS: usize>;

impl<const A: usize, const B: usize, const C: usize> StreamCounts for Counts<A, B, C> {
    #[inline(always)]
    fn put<P: Put, R: Row>(
        streams: &Streams<'_, R>,
        to: &mut [R],
        kept: &mut [R],
        impulse: &impl Impulse<R>,
    ) -> bool {
        put::<P, R, A, B, C>(
            streams,
            to,
            kept,
            #[inline(always)]
            |kick, reads| impulse.at(kick, reads),
        )
    }
}
