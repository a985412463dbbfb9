//! Results of studies as CSV files, in a format that all compared programs share.
//!
//! Input: records. Output: a header line with the names of the columns, then one line for each
//! record; and the records of such a file. Invariant: numbers that were written are read with the
//! same bits. An unknown number is an empty field.

use std::io::{self, BufRead, Write};
use std::path::Path;

use ::csv::{Error, ErrorKind, Position, Reader, StringRecord, WriterBuilder};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::StudyError;

/// The fields of a record, in their order.
const COLUMNS: &str = "problem,method,h,error,error_se,weak_error,weak_error_se,energy_error,\
    energy_drift,ns_per_step,ns_spread,time_to_solution_s,newton_iterations,failures,source";

/// One line of a file of results: one method with one step size (or tolerance) on one problem.
/// Numbers that are not known are `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Record {
    /// Name of the problem.
    pub problem: String,
    /// Name of the method.
    pub method: String,
    /// Step size; `None` for methods that choose their step sizes.
    #[serde(with = "finite")]
    pub h: Option<f64>,
    /// Strong error at the horizon: the root mean square, over paths, of the distance from the
    /// reference.
    #[serde(with = "finite")]
    pub error: Option<f64>,
    /// Standard error of `error`.
    #[serde(with = "finite")]
    pub error_se: Option<f64>,
    /// Weak error of the problem's first observable.
    #[serde(with = "finite")]
    pub weak_error: Option<f64>,
    /// Standard error of `weak_error`.
    #[serde(with = "finite")]
    pub weak_error_se: Option<f64>,
    /// Largest difference of the invariant from its first value.
    #[serde(with = "finite")]
    pub energy_error: Option<f64>,
    /// Secular change of the invariant in a unit of time.
    #[serde(with = "finite")]
    pub energy_drift: Option<f64>,
    /// Nanoseconds for one step of one path.
    #[serde(with = "finite")]
    pub ns_per_step: Option<f64>,
    /// Half the distance between the quartiles of `ns_per_step`.
    #[serde(with = "finite")]
    pub ns_spread: Option<f64>,
    /// Seconds for one path to the horizon.
    #[serde(with = "finite")]
    pub time_to_solution_s: Option<f64>,
    /// Newton iterations for one step.
    #[serde(with = "finite")]
    pub newton_iterations: Option<f64>,
    /// Number of paths that failed.
    #[serde(deserialize_with = "zero_unless_known")]
    pub failures: u64,
    /// The program, with its version.
    pub source: String,
}

/// Writes a header line with the names of the columns, then one line for each record.
///
/// ```
/// use sve_runtime::study::{Record, read_csv, write_csv};
///
/// let (problem, method) = ("Kubo".into(), "midpoint".into());
/// let record = Record { problem, method, h: Some(0.1), ..Record::default() };
/// let mut file = Vec::new();
/// write_csv(&mut file, &[record.clone()])?;
/// assert_eq!(read_csv(&file[..])?, [record]);
/// # Ok::<(), sve_runtime::study::StudyError>(())
/// ```
///
/// # Errors
/// [`StudyError::Io`] when the writer fails.
pub fn write_csv(to: impl Write, records: &[Record]) -> Result<(), StudyError> {
    let mut lines = WriterBuilder::new().has_headers(false).from_writer(to);
    (lines.write_record(COLUMNS.split(','))).map_err(io::Error::from)?;
    for record in records {
        lines.serialize(record).map_err(io::Error::from)?;
    }
    // a buffered writer ignores errors when it is dropped
    Ok(lines.flush()?)
}

/// Writes records into a file; see [`write_csv`]. The file is complete or not written at all: it
/// replaces an existing one atomically.
///
/// # Errors
/// [`StudyError::Io`] if the file cannot be written; the error names its path, and nothing of the
/// file remains.
pub fn to_csv(path: impl AsRef<Path>, records: &[Record]) -> Result<(), StudyError> {
    let path = path.as_ref();
    let mut text = Vec::new();
    write_csv(&mut text, records)?;
    Ok(crate::file::write(path, |file| file.write_all(&text))?)
}

/// Reads records that [`write_csv`] or another program wrote. The columns can have any order. The
/// columns `problem` and `method` are required, and unknown columns are ignored.
///
/// # Errors
/// [`StudyError::Csv`] with the number of the wrong line; [`StudyError::Io`] if the reader fails.
pub fn read_csv(mut from: impl BufRead) -> Result<Vec<Record>, StudyError> {
    let mut text = String::new();
    from.read_to_string(&mut text)?;
    let mut lines = Reader::from_reader(text.as_bytes());
    let head = lines.headers().map_err(io::Error::from)?.clone();
    if head.is_empty() {
        return Err(wrong(
            1,
            "the line with the names of the columns is missing",
        ));
    }
    for needed in ["problem", "method"] {
        if !head.iter().any(|name| name == needed) {
            return Err(wrong(1, format!("there is no column `{needed}`")));
        }
    }
    let (mut last, mut records) = (None, Vec::new());
    for fields in lines.records() {
        let fields = fields.map_err(|error| unread(&error, &text))?;
        let line = || line_of(fields.position(), &text);
        let record = fields.deserialize(Some(&head));
        records.push(record.map_err(|error| wrong(line(), mistake(&error, &head, &fields)))?);
        last = fields.position().cloned();
    }
    // The reader takes a field whose quotation mark is not closed up to the end of the text.
    if text.matches('"').count() % 2 == 1 {
        let line = line_of(last.as_ref(), &text);
        return Err(wrong(line, "a quotation mark is not closed"));
    }
    Ok(records)
}

/// Says what is wrong with the fields of a line.
fn mistake(error: &Error, head: &StringRecord, fields: &StringRecord) -> String {
    let field = match error.kind() {
        ErrorKind::Deserialize { err, .. } => err.field().map(|field| field as usize),
        _ => None,
    };
    match field.and_then(|at| Some((fields.get(at)?, head.get(at)?))) {
        Some((field, column)) => format!("`{field}` is no number for the column `{column}`"),
        None => error.to_string(),
    }
}

/// Returns the error of a line that has not one field for each column.
fn unread(error: &Error, text: &str) -> StudyError {
    let line = line_of(error.position(), text);
    match error.kind() {
        ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => wrong(line, format!("{len} fields under {expected_len} columns")),
        _ => wrong(line, error.to_string()),
    }
}

/// Returns the number of the first line with content after a position, since a position of the
/// reader stands before the empty lines that the reader skips.
fn line_of(at: Option<&Position>, text: &str) -> usize {
    let at = at.map_or(0, |at| at.byte() as usize);
    let is_break = |byte: &u8| matches!(byte, b'\r' | b'\n');
    let breaks = text.bytes().skip(at).take_while(is_break).count();
    let before = text.bytes().take(at + breaks);
    1 + before.filter(|&byte| byte == b'\n').count()
}

fn wrong(line: usize, what: impl Into<String>) -> StudyError {
    StudyError::Csv {
        line,
        what: what.into(),
    }
}

/// Numbers that are known only if they are finite.
mod finite {
    use super::{Deserialize as _, Deserializer, Serializer};

    #[allow(clippy::ref_option)] // the signature that serde calls
    pub(super) fn serialize<S: Serializer>(x: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        match x {
            Some(x) if x.is_finite() => to.serialize_f64(*x),
            _ => to.serialize_none(),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        Ok(Option::<f64>::deserialize(from)?.filter(|x| x.is_finite()))
    }
}

fn zero_unless_known<'de, D: Deserializer<'de>>(from: D) -> Result<u64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, Record, StudyError, read_csv, write_csv};

    #[test]
    fn records_are_read_with_the_bits_that_were_written() {
        let records = [
            Record {
                problem: "a \"problem\", quoted\nin two lines".into(),
                method: "m".into(),
                h: Some(0.1),
                error: Some(1.0 / 3.0),
                error_se: Some(5e-324),
                weak_error: Some(-0.0),
                weak_error_se: Some(f64::MAX),
                energy_error: Some(1e-17),
                energy_drift: Some(-2.0 / 7.0),
                ns_per_step: Some(12.5),
                ns_spread: Some(0.25),
                time_to_solution_s: Some(1e-9 / 3.0),
                newton_iterations: Some(2.1),
                failures: u64::MAX,
                source: "sve, 1".into(),
            },
            Record::default(),
        ];
        let mut file = Vec::new();
        write_csv(&mut file, &records).unwrap();
        assert!(file.starts_with(format!("{COLUMNS}\n").as_bytes()));
        assert_eq!(read_csv(&file[..]).unwrap(), records);
    }

    #[test]
    fn columns_can_be_in_any_order_and_missing() {
        let text = "method,remark,problem,error,failures\r\nm,x,p,1e-3,\r\n\r\nn,,p,nan,2\r\n";
        let records = read_csv(text.as_bytes()).unwrap();
        assert_eq!(records.len(), 2);
        assert_eq!((&*records[0].problem, records[0].error), ("p", Some(1e-3)));
        assert_eq!((&*records[1].method, records[1].error), ("n", None));
        assert_eq!((records[0].failures, records[1].failures), (0, 2));
    }

    #[test]
    fn errors_have_the_number_of_their_line() {
        let message = |text: &str| match read_csv(text.as_bytes()) {
            Err(StudyError::Csv { line, what }) => (line, what),
            other => panic!("{other:?}"),
        };
        assert_eq!(message("").0, 1);
        assert!(message("problem,h\n").1.contains("`method`"));
        let (line, what) = message("problem,method,h\np,m,1\np,m,x\n");
        assert_eq!((line, what.contains("`x`")), (3, true));
        let (line, what) = message("problem,method\np,m\np,\"m\n");
        assert_eq!((line, &*what), (3, "a quotation mark is not closed"));
        let (_, what) = message("method,problem,h\np,m,x\n");
        assert_eq!(what, "`x` is no number for the column `h`");
        for breaks in ["\n", "\r\n"] {
            let (line, what) = message(&["problem,method", "p,m", "", "", "p", ""].join(breaks));
            assert_eq!((line, &*what), (5, "1 fields under 2 columns"));
            let (line, _) = message(&["problem,method,h", "p,\"m", "n\",1", "p,m,x"].join(breaks));
            assert_eq!(line, 4);
        }
    }
}
