//! Results of studies as CSV files, in a format that all compared programs share.
//!
//! Input: records. Output: a header line with the names in [`COLUMNS`], then one line for each record; and the records of such a file.
//! Invariant: numbers that were written are read with the same bits. Fields with a comma, a quotation mark or a line break are quoted
//! as in RFC 4180. An unknown number is an empty field.

use std::io::{BufRead, Write};
use std::path::Path;

use super::StudyError;

/// Names of the columns of a file, in the order in which they are written.
pub const COLUMNS: [&str; 15] = {
    let mut names = [""; 15];
    let mut column = 0;
    while column < names.len() {
        names[column] = FIELDS[column].0;
        column += 1;
    }
    names
};

/// A column, and where a record has its value.
type Field = (&'static str, fn(&mut Record) -> Value<'_>);

/// The value of a record in a column.
enum Value<'r> {
    Text(&'r mut String),
    Number(&'r mut Option<f64>),
    Count(&'r mut u64),
}

/// The columns.
const FIELDS: [Field; 15] = [
    ("problem", |of| Value::Text(&mut of.problem)),
    ("method", |of| Value::Text(&mut of.method)),
    ("h", |of| Value::Number(&mut of.h)),
    ("error", |of| Value::Number(&mut of.error)),
    ("error_se", |of| Value::Number(&mut of.error_se)),
    ("weak_error", |of| Value::Number(&mut of.weak_error)),
    ("weak_error_se", |of| Value::Number(&mut of.weak_error_se)),
    ("energy_error", |of| Value::Number(&mut of.energy_error)),
    ("energy_drift", |of| Value::Number(&mut of.energy_drift)),
    ("ns_per_step", |of| Value::Number(&mut of.ns_per_step)),
    ("ns_spread", |of| Value::Number(&mut of.ns_spread)),
    ("time_to_solution_s", |of| {
        Value::Number(&mut of.time_to_solution_s)
    }),
    ("newton_iterations", |of| {
        Value::Number(&mut of.newton_iterations)
    }),
    ("failures", |of| Value::Count(&mut of.failures)),
    ("source", |of| Value::Text(&mut of.source)),
];

/// One line of a file of results: one method with one step size (or tolerance) on one problem. Numbers that are not known are `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Name of the problem.
    pub problem: String,
    /// Name of the method.
    pub method: String,
    /// Step size; `None` for methods that choose their step sizes.
    pub h: Option<f64>,
    /// Strong error at the horizon: the root mean square, over paths, of the distance from the reference.
    pub error: Option<f64>,
    /// Standard error of `error`.
    pub error_se: Option<f64>,
    /// Weak error of the problem's first observable.
    pub weak_error: Option<f64>,
    /// Standard error of `weak_error`.
    pub weak_error_se: Option<f64>,
    /// Largest difference of the invariant from its first value.
    pub energy_error: Option<f64>,
    /// Secular change of the invariant in a unit of time.
    pub energy_drift: Option<f64>,
    /// Nanoseconds for one step of one path.
    pub ns_per_step: Option<f64>,
    /// Half the distance between the quartiles of `ns_per_step`.
    pub ns_spread: Option<f64>,
    /// Seconds for one path to the horizon.
    pub time_to_solution_s: Option<f64>,
    /// Newton iterations for one step.
    pub newton_iterations: Option<f64>,
    /// Number of paths that failed.
    pub failures: u64,
    /// The program, with its version.
    pub source: String,
}

/// Writes a header line with the names of the columns, then one line for each record.
///
/// ```
/// use sve_runtime::study::{Record, read_csv, write_csv};
///
/// let record = Record { problem: "Kubo".into(), method: "midpoint".into(), h: Some(0.1), ..Record::default() };
/// let mut file = Vec::new();
/// write_csv(&mut file, &[record.clone()])?;
/// assert_eq!(read_csv(&file[..])?, [record]);
/// # Ok::<(), sve_runtime::study::StudyError>(())
/// ```
///
/// # Errors
/// [`StudyError::Io`] when the writer fails.
pub fn write_csv(mut to: impl Write, records: &[Record]) -> Result<(), StudyError> {
    writeln!(to, "{}", COLUMNS.join(","))?;
    for record in records {
        let mut record = record.clone();
        let fields = FIELDS.map(|(_, field)| match field(&mut record) {
            Value::Text(text) => quoted(text),
            Value::Number(&mut Some(x)) if x.is_finite() => format!("{x:e}"),
            Value::Number(_) => String::new(),
            Value::Count(count) => count.to_string(),
        });
        writeln!(to, "{}", fields.join(","))?;
    }
    // a buffered writer ignores errors when it is dropped
    Ok(to.flush()?)
}

/// Writes records into a file; see [`write_csv`]. The file is complete or not written at all: it replaces an existing one atomically.
///
/// # Errors
/// [`StudyError::Io`] if the file cannot be written; the error names its path, and nothing of the file remains.
pub fn to_csv(path: impl AsRef<Path>, records: &[Record]) -> Result<(), StudyError> {
    let path = path.as_ref();
    let mut text = Vec::new();
    write_csv(&mut text, records)?;
    Ok(crate::file::write(path, |file| file.write_all(&text))?)
}

/// Reads records that [`write_csv`] or another program wrote. The columns can have any order. The columns `problem` and `method` are
/// required, and unknown columns are ignored. Line breaks within a field are not supported.
///
/// # Errors
/// [`StudyError::Csv`] with the number of the wrong line; [`StudyError::Io`] if the reader fails.
pub fn read_csv(from: impl BufRead) -> Result<Vec<Record>, StudyError> {
    let mut lines = from.lines().enumerate();
    let Some((_, head)) = lines.next() else {
        return Err(wrong(
            1,
            "the line with the names of the columns is missing",
        ));
    };
    let head = fields(1, &head?)?;
    for needed in ["problem", "method"] {
        if !head.iter().any(|name| name == needed) {
            return Err(wrong(1, format!("there is no column `{needed}`")));
        }
    }
    let mut records = Vec::new();
    for (at, text) in lines {
        let (line, text) = (at + 1, text?);
        if text.trim().is_empty() {
            continue;
        }
        let fields = fields(line, &text)?;
        if fields.len() != head.len() {
            let what = format!("{} fields under {} columns", fields.len(), head.len());
            return Err(wrong(line, what));
        }
        let mut record = Record::default();
        for (name, field) in head.iter().zip(&fields) {
            record.set(name, field).map_err(|what| wrong(line, what))?;
        }
        records.push(record);
    }
    Ok(records)
}

impl Record {
    /// Parses the field of a column and stores its value.
    fn set(&mut self, column: &str, field: &str) -> Result<(), String> {
        let Some((_, value)) = FIELDS.iter().find(|(name, _)| *name == column) else {
            return Ok(());
        };
        match (value(self), field.trim()) {
            (Value::Text(text), _) => field.clone_into(text),
            (Value::Number(number), "") => *number = None,
            (Value::Number(number), field) => {
                *number = Some(parsed(column, field)?).filter(|x: &f64| x.is_finite());
            }
            (Value::Count(_), "") => {}
            (Value::Count(count), field) => *count = parsed(column, field)?,
        }
        Ok(())
    }
}

fn parsed<T: core::str::FromStr>(column: &str, field: &str) -> Result<T, String> {
    field
        .parse()
        .map_err(|_| format!("`{field}` is no number for the column `{column}`"))
}

fn wrong(line: usize, what: impl Into<String>) -> StudyError {
    StudyError::Csv {
        line,
        what: what.into(),
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Splits a line into its fields and removes their quotation marks.
fn fields(line: usize, text: &str) -> Result<Vec<String>, StudyError> {
    let mut fields = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = text.trim_end_matches('\r').chars().peekable();
    while let Some(character) = characters.next() {
        let last = fields.len() - 1;
        match character {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                characters.next();
                fields[last].push('"');
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => fields.push(String::new()),
            other => fields[last].push(other),
        }
    }
    if is_quoted {
        return Err(wrong(line, "a quotation mark is not closed"));
    }
    Ok(fields)
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, Record, StudyError, read_csv, write_csv};

    #[test]
    fn records_are_read_with_the_bits_that_were_written() {
        let records = [
            Record {
                problem: "a \"problem\", quoted".into(),
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
        assert!(file.starts_with(COLUMNS.join(",").as_bytes()));
        assert_eq!(read_csv(&file[..]).unwrap(), records);
    }

    #[test]
    fn columns_can_be_in_any_order_and_missing() {
        let text = "method,remark,problem,error\r\nm,x,p,1e-3\r\n\r\nn,,p,nan\r\n";
        let records = read_csv(text.as_bytes()).unwrap();
        assert_eq!(records.len(), 2);
        assert_eq!((&*records[0].problem, records[0].error), ("p", Some(1e-3)));
        assert_eq!((&*records[1].method, records[1].error), ("n", None));
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
        assert_eq!(message("problem,method\np\n").0, 2);
        assert_eq!(message("problem,method\np,\"m\n").0, 2);
    }
}
