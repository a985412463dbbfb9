//! The data that loops read as they are written: rows, fields and integers with checked indices.

use super::{IndexError, Instance, Row};

/// Returns an index as a position; one out of every range if it is negative.
#[inline(always)]
pub fn position(index: i64) -> usize {
    usize::try_from(index).unwrap_or(usize::MAX)
}

/// Returns a found entry of an array.
///
/// # Errors
/// The index, if nothing was found.
#[inline(always)]
pub fn place<T>(
    found: Option<T>,
    index: i64,
    length: usize,
    text: &'static str,
) -> Result<T, IndexError> {
    found.ok_or(IndexError {
        text,
        index,
        length,
        instance: Instance::default(),
    })
}

/// Checks an index.
///
/// # Errors
/// The index, if it is out of range.
#[inline(always)]
pub fn check(index: i64, length: usize, text: &'static str) -> Result<(), IndexError> {
    place(
        (position(index) < length).then_some(()),
        index,
        length,
        text,
    )
}

/// Returns a row; zeros if the index is out of range.
#[inline(always)]
pub fn row_if_any<R: Row>(rows: &[R], index: i64) -> R {
    rows.get(position(index)).copied().unwrap_or(R::ZERO)
}

/// Adds a row to another one; nothing if the index is out of range.
#[inline(always)]
pub fn accumulate<R: Row>(to: &mut [R], index: i64, row: R) {
    if let Some(to) = to.get_mut(position(index)) {
        to.add(row);
    }
}

/// Returns a quotient, rounded towards zero.
///
/// # Errors
/// A zero divisor.
#[inline(always)]
pub fn quotient(a: i64, b: i64, text: &'static str) -> Result<i64, IndexError> {
    place((b != 0).then(|| a.wrapping_div(b)), a, 0, text)
}

/// Returns a remainder with the sign of `a`.
///
/// # Errors
/// A zero divisor.
#[inline(always)]
pub fn remainder(a: i64, b: i64, text: &'static str) -> Result<i64, IndexError> {
    place((b != 0).then(|| a.wrapping_rem(b)), a, 0, text)
}

/// An integer of a field.
pub trait Integer: Copy {
    /// Returns the integer; one out of every range if it is too large.
    fn value(self) -> i64;
}

macro_rules! integers {
    ($($integer:ty)*) => {$(
        impl Integer for $integer {
            #[inline(always)]
            fn value(self) -> i64 {
                i64::try_from(self).unwrap_or(i64::MAX)
            }
        }
    )*};
}

integers!(u8 u16 u32 u64 usize i8 i16 i32 i64 isize);

/// Returns an integer of a field.
#[inline(always)]
pub fn integer<T: Integer>(integer: T) -> i64 {
    integer.value()
}
