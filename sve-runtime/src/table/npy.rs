//! Tables as arrays of `NumPy`.
//!
//! Input: a table, or frames of sites. Output: a one-dimensional structured array, a record for
//! each row or frame. Invariant: little-endian on every machine; the data start at a multiple of 64
//! bytes.
//!
//! Source: the format as `NumPy` documents it, `numpy.lib.format`, versions 1.0 and, for names
//! beyond ASCII, 3.0.

use std::io::{self, Write};

use super::{Table, Values};

impl Table {
    pub(crate) fn write_npy(&self, mut to: impl Write) -> io::Result<()> {
        let field = |(name, values): &(String, Values)| {
            let kind = match values {
                Values::Counts(_) => "<u8",
                Values::Numbers(_) => "<f8",
            };
            format!("({}, '{kind}'), ", literal(name))
        };
        let fields: String = self.columns.iter().map(field).collect();
        let rows = self.rows();
        let header =
            format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({rows},), }}");
        to.write_all(&preamble(&header))?;
        for row in 0..rows {
            for (_, values) in &self.columns {
                match values {
                    Values::Counts(counts) => to.write_all(&counts[row].to_le_bytes())?,
                    Values::Numbers(numbers) => to.write_all(&numbers[row].to_le_bytes())?,
                }
            }
        }
        to.flush()
    }
}

/// Returns the bytes before an array of frames, records of a time `t` and of rows `q` and `p` of
/// `sites` times `numbers` numbers.
pub(crate) fn frames_header(frames: usize, sites: usize, numbers: usize) -> Vec<u8> {
    let shape = match numbers {
        1 => format!("({sites},)"),
        _ => format!("({sites}, {numbers})"),
    };
    let fields = format!("('t', '<f8'), ('q', '<f8', {shape}), ('p', '<f8', {shape})");
    preamble(&format!(
        "{{'descr': [{fields}], 'fortran_order': False, 'shape': ({frames},), }}"
    ))
}

/// Returns the bytes before the data: magic, version, length of the header, the header padded with
/// spaces to a multiple of 64.
fn preamble(header: &str) -> Vec<u8> {
    let short = header.is_ascii() && header.len() < 65_000;
    let fixed = if short { 10 } else { 12 };
    let length = (fixed + header.len() + 1).next_multiple_of(64) - fixed;
    let mut bytes = b"\x93NUMPY".to_vec();
    if short {
        bytes.extend([1, 0]);
        bytes.extend((length as u16).to_le_bytes());
    } else {
        bytes.extend([3, 0]);
        bytes.extend((length as u32).to_le_bytes());
    }
    bytes.extend(header.as_bytes());
    bytes.resize(fixed + length - 1, b' ');
    bytes.push(b'\n');
    bytes
}

/// Returns a string as a literal of Python.
fn literal(name: &str) -> String {
    let mut literal = String::from("'");
    for c in name.chars() {
        match c {
            '\'' | '\\' => literal.extend(['\\', c]),
            // Python refuses some control characters within a literal.
            _ if c.is_control() => literal.extend(format!("\\u{:04x}", u32::from(c)).chars()),
            _ => literal.push(c),
        }
    }
    literal + "'"
}

#[cfg(test)]
mod tests {
    use super::literal;

    #[test]
    fn names_are_literals_of_python() {
        assert_eq!(literal("a 'b' \\ ä"), r"'a \'b\' \\ ä'");
        assert_eq!(literal("\0\n\t"), r"'\u0000\u000a\u0009'");
    }
}
