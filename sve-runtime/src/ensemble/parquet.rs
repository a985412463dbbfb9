//! The statistics of a summary as Parquet.
//!
//! Input: a [`Summary`]. Output: a file of one row group, whose columns are those of the CSV table.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use ::parquet::basic::{LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{Type, TypePtr};

use super::Summary;
use super::csv::Values;

impl Summary {
    /// Writes the statistics as Parquet: a row for each recorded time, with the columns of [`write_csv`](Self::write_csv), all of them
    /// required; a number that does not exist is NaN.
    ///
    /// # Errors
    /// The errors of the writer.
    pub fn write_parquet(&self, to: impl Write + Send) -> io::Result<()> {
        self.table(to).map_err(io::Error::other)
    }

    /// Writes the statistics as Parquet into a file; see [`write_parquet`](Self::write_parquet). The file is complete or not
    /// written at all: it replaces an existing one atomically.
    ///
    /// # Errors
    /// If the file cannot be written; the error names its path, and nothing of the file remains.
    pub fn to_parquet(&self, path: impl AsRef<Path>) -> io::Result<()> {
        crate::file::write(path.as_ref(), |file| self.write_parquet(file))
    }

    fn table(&self, to: impl Write + Send) -> Result<(), ParquetError> {
        let columns = self.columns();
        let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder("summary").with_fields(fields);
        let properties = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(to, Arc::new(schema.build()?), properties)?;
        let mut group = file.next_row_group()?;
        for (_, values) in &columns {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            match values {
                Values::Counts(counts) => {
                    let counts: Vec<i64> = counts.iter().map(|&n| n.cast_signed()).collect();
                    let column = column.typed::<Int64Type>();
                    column.write_batch(&counts, None, None)?;
                }
                Values::Numbers(numbers) => {
                    let column = column.typed::<DoubleType>();
                    column.write_batch(numbers, None, None)?;
                }
            }
            column.close()?;
        }
        group.close()?;
        file.close()?;
        Ok(())
    }
}

/// A column of the schema.
fn field((name, values): &(String, Values)) -> Result<TypePtr, ParquetError> {
    let field = match values {
        Values::Counts(_) => {
            let unsigned = LogicalType::integer(64, false);
            Type::primitive_type_builder(name, Physical::INT64).with_logical_type(Some(unsigned))
        }
        Values::Numbers(_) => Type::primitive_type_builder(name, Physical::DOUBLE),
    };
    field
        .with_repetition(Repetition::REQUIRED)
        .build()
        .map(Arc::new)
}
