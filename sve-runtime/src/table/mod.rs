//! Tables of numbers with names, and their formats: CSV, arrays of `NumPy`, Parquet.
//!
//! Input: columns. Output: a file, written atomically. Invariant: every format keeps the bits of
//! all numbers. Statistics, histograms and states make their columns, and have the functions of
//! `table_writers`.

pub(crate) mod csv;
#[cfg(feature = "npy")]
mod npy;
#[cfg(feature = "parquet")]
mod parquet;
mod states;
mod xyz;

#[cfg(feature = "npy")]
pub(crate) use npy::frames_header;
pub use states::{SaveError, StateTable};
pub use xyz::Xyz;

/// The values of a column.
pub(crate) enum Values {
    /// Numbers of paths, or of a path.
    #[cfg_attr(not(feature = "ensemble"), allow(dead_code))]
    Counts(Vec<u64>),
    Numbers(Vec<f64>),
}

/// Columns of equal length.
pub(crate) struct Table {
    /// The content of a row, for formats that name the table.
    #[cfg_attr(not(feature = "parquet"), allow(dead_code))]
    pub(crate) name: &'static str,
    pub(crate) columns: Vec<(String, Values)>,
}

impl Table {
    /// Returns the number of rows.
    fn rows(&self) -> usize {
        match self.columns.first() {
            Some((_, Values::Counts(counts))) => counts.len(),
            Some((_, Values::Numbers(numbers))) => numbers.len(),
            None => 0,
        }
    }
}

/// Gives a type with a function `table` the functions that write it. Their documentation begins
/// with `$what`.
macro_rules! table_writers {
    ($type:ty, $what:literal) => {
        impl $type {
            #[doc = concat!("Writes ", $what, " as CSV: a line of names, then one for each row. A number that does not exist is an empty field.")]
            ///
            /// Numbers are written with the digits that give back their bits.
            ///
            /// # Errors
            /// The errors of the writer.
            pub fn write_csv(&self, to: impl ::std::io::Write) -> ::std::io::Result<()> {
                self.table().write_csv(to)
            }

            #[doc = concat!("Writes ", $what, " as CSV into a file; see [`write_csv`](Self::write_csv).")]
            ///
            /// The file is complete or not written at all: it replaces an existing one atomically.
            ///
            /// # Errors
            /// If the file cannot be written; the error names its path, and nothing of the file
            /// remains.
            pub fn to_csv(&self, path: impl AsRef<::std::path::Path>) -> ::std::io::Result<()> {
                $crate::file::write(path.as_ref(), |file| self.write_csv(file))
            }

            #[doc = concat!("Writes ", $what, " as a structured array of `NumPy`, whose fields are the columns of [`write_csv`](Self::write_csv): `numpy.load(\"x.npy\")[\"t\"]`.")]
            ///
            /// A number that does not exist is NaN. Where there are hundreds of columns their names
            /// exceed what `numpy.load` reads unasked, 10,000 bytes; it reads them with
            /// `max_header_size=10**6`.
            ///
            /// # Errors
            /// The errors of the writer.
            #[cfg(feature = "npy")]
            pub fn write_npy(&self, to: impl ::std::io::Write) -> ::std::io::Result<()> {
                self.table().write_npy(to)
            }

            #[doc = concat!("Writes ", $what, " as an array of `NumPy` into a file; see [`write_npy`](Self::write_npy).")]
            ///
            /// The file is complete or not written at all: it replaces an existing one atomically.
            ///
            /// # Errors
            /// If the file cannot be written; the error names its path, and nothing of the file
            /// remains.
            #[cfg(feature = "npy")]
            pub fn to_npy(&self, path: impl AsRef<::std::path::Path>) -> ::std::io::Result<()> {
                $crate::file::write(path.as_ref(), |file| self.write_npy(file))
            }

            #[doc = concat!("Writes ", $what, " as Parquet, with the columns of [`write_csv`](Self::write_csv), all of them required.")]
            ///
            /// A number that does not exist is NaN.
            ///
            /// # Errors
            /// The errors of the writer.
            #[cfg(feature = "parquet")]
            pub fn write_parquet(&self, to: impl ::std::io::Write + Send) -> ::std::io::Result<()> {
                self.table().write_parquet(to)
            }

            #[doc = concat!("Writes ", $what, " as Parquet into a file; see [`write_parquet`](Self::write_parquet).")]
            ///
            /// The file is complete or not written at all: it replaces an existing one atomically.
            ///
            /// # Errors
            /// If the file cannot be written; the error names its path, and nothing of the file
            /// remains.
            #[cfg(feature = "parquet")]
            pub fn to_parquet(&self, path: impl AsRef<::std::path::Path>) -> ::std::io::Result<()> {
                $crate::file::write(path.as_ref(), |file| self.write_parquet(file))
            }
        }
    };
}

pub(crate) use table_writers;
