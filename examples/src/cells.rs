//! Cells of a grid as lines through their rows. An area of one colour has few lines, and no gaps in
//! a vector file.

use std::ops::Range;

/// Returns, for each colour, the runs of cells that have it, with a point that is not finite before
/// each run. The cells are given row by row, from the least y; a cell without a colour is not
/// drawn.
pub fn runs<const COLORS: usize>(
    cells: &[Option<usize>],
    columns: usize,
    x: &Range<f64>,
    y: &Range<f64>,
) -> [Vec<(f64, f64)>; COLORS] {
    let mut lines: [Vec<(f64, f64)>; COLORS] = std::array::from_fn(|_| Vec::new());
    let rows = cells.len() / columns;
    let at = |column: usize| x.start + (x.end - x.start) * column as f64 / columns as f64;
    for (row, cells) in cells.chunks(columns).enumerate() {
        let y = y.start + (y.end - y.start) * (row as f64 + 0.5) / rows as f64;
        let mut column = 0;
        for run in cells.chunk_by(|left, right| left == right) {
            let end = column + run.len();
            if let Some(color) = run[0] {
                lines[color].extend([(f64::NAN, y), (at(column), y), (at(end), y)]);
            }
            column = end;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_a_line() {
        let cells = [Some(1), Some(1), None, Some(0), None, None];
        let [first, second] = runs(&cells, 3, &(0.0..3.0), &(0.0..1.0));
        assert_eq!(first[1..], [(0.0, 0.75), (1.0, 0.75)]);
        assert_eq!(second[1..], [(0.0, 0.25), (2.0, 0.25)]);
    }
}
