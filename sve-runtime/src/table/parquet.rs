//! Tables as Parquet.
//!
//! Input: a table. Output: a file of one row group, whose columns are those of the CSV table.

use std::io::{self, Write};
use std::sync::Arc;

use ::parquet::basic::{LogicalType, Repetition, Type as Physical};
use ::parquet::data_type::{DoubleType, Int64Type};
use ::parquet::errors::ParquetError;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::{Type, TypePtr};

use super::{Table, Values};

impl Table {
    pub(crate) fn write_parquet(&self, to: impl Write + Send) -> io::Result<()> {
        self.write_group(to).map_err(|error| match error {
            // An error of the writer keeps its kind.
            ParquetError::External(source) => match source.downcast::<io::Error>() {
                Ok(error) => *error,
                Err(source) => io::Error::other(source),
            },
            error => io::Error::other(error),
        })
    }

    fn write_group(&self, to: impl Write + Send) -> Result<(), ParquetError> {
        let fields = self.columns.iter().map(field).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder(self.name).with_fields(fields);
        let properties = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(to, Arc::new(schema.build()?), properties)?;
        let mut group = file.next_row_group()?;
        for (_, values) in &self.columns {
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

/// Returns a column of the schema.
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
