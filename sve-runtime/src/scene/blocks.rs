//! Inner loops over consecutive sites, in blocks.
//!
//! Such a loop adds to its sites, and to sites of the loops around it. What it adds to these goes
//! into partial sums, one for each place of a block, so that the loop is made in vectors; their
//! number is fixed, and so are the bits.

use core::ops::Range;

/// Sites of a block.
const LENGTH: usize = 16;

/// Rounds below which the partial sums would cost more than they save.
const FEWEST: i64 = 32;

/// Returns the range of `count` consecutive sites from `first`; `None` if it is short or not a part
/// of `0..length`.
#[inline(always)]
pub fn consecutive(first: i64, count: i64, length: usize) -> Option<Range<usize>> {
    let end = usize::try_from(first.checked_add(count)?).ok()?;
    let first = usize::try_from(first).ok()?;
    (count >= FEWEST && end <= length).then_some(first..end)
}

/// A field with numbers of consecutive instances, if it is an array of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, T: ?Sized>(pub &'a T);

impl<'a, T: AsRef<[f64]> + ?Sized> Field<'a, T> {
    /// Returns `count` numbers from `first`; `None` if there are fewer.
    #[inline(always)]
    pub fn consecutive(&self, first: i64, count: i64) -> Option<&'a [f64]> {
        let numbers = self.0.as_ref();
        numbers.get(consecutive(first, count, numbers.len())?)
    }
}

/// The method of a field of another type, which a call finds where the type has none of its own.
pub trait NoNumbers<'a> {
    /// Returns `None`: the loop is made as it is written.
    #[inline(always)]
    fn consecutive(&self, _: i64, _: i64) -> Option<&'a [f64]> {
        None
    }
}

impl<'a, T: ?Sized> NoNumbers<'a> for Field<'a, T> {}

/// The values that a loop adds to its site and to the sites of the loops around it.
pub type Added<const D: usize, const FIXED: usize> = ([f64; D], [[f64; D]; FIXED]);

/// Makes a loop over consecutive sites `q`, which are as many as the numbers of each column. `each`
/// is `#[inline(always)]`.
#[inline(always)]
pub fn in_blocks<const D: usize, const FIXED: usize, const COLUMNS: usize>(
    q: &[[f64; D]],
    columns: [&[f64]; COLUMNS],
    to: &mut [[f64; D]],
    fixed: &mut [[f64; D]; FIXED],
    each: impl Fn([f64; D], [f64; COLUMNS]) -> Added<D, FIXED>,
) {
    let mut sums = [[[0.0; LENGTH]; D]; FIXED];
    let (blocks, rest) = q.as_chunks::<LENGTH>();
    let (to, to_rest) = to.as_chunks_mut::<LENGTH>();
    let columns = columns.map(|column| column.as_chunks::<LENGTH>());
    for (at, (q, to)) in blocks.iter().zip(to).enumerate() {
        block(q, columns.map(|column| &column.0[at]), to, &mut sums, &each);
    }
    for (at, (q, to)) in rest.iter().zip(to_rest).enumerate() {
        let (own, others) = each(*q, columns.map(|column| column.1[at]));
        for k in 0..D {
            to[k] += own[k];
            for other in 0..FIXED {
                fixed[other][k] += others[other][k];
            }
        }
    }
    for other in 0..FIXED {
        for k in 0..D {
            fixed[other][k] += sums[other][k].iter().sum::<f64>();
        }
    }
}

/// Makes one block. The arrays are arguments, so that the compiler knows that they do not overlap.
#[inline(always)]
fn block<const D: usize, const FIXED: usize, const COLUMNS: usize>(
    q: &[[f64; D]; LENGTH],
    columns: [&[f64; LENGTH]; COLUMNS],
    to: &mut [[f64; D]; LENGTH],
    sums: &mut [[[f64; LENGTH]; D]; FIXED],
    each: &impl Fn([f64; D], [f64; COLUMNS]) -> Added<D, FIXED>,
) {
    for place in 0..LENGTH {
        let (of_site, others) = each(q[place], columns.map(|column| column[place]));
        for k in 0..D {
            to[place][k] += of_site[k];
            for other in 0..FIXED {
                sums[other][k][place] += others[other][k];
            }
        }
    }
}
