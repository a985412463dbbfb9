//! Lines cut at a rectangle, and points thinned to the number that an eye can distinguish.
//!
//! Cutting is by Liang and Barsky (1984): each segment's parameter interval is narrowed edge by
//! edge.

use std::collections::HashSet;
use std::ops::Range;

type Point = (f64, f64);

/// Returns the parts of a polyline inside `x` × `y`. A point that is not finite ends a part.
pub(crate) fn polyline(points: &[Point], x: &Range<f64>, y: &Range<f64>) -> Vec<Vec<Point>> {
    let mut parts: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let Some((from, to)) = segment(pair[0], pair[1], x, y) else {
            open = false;
            continue;
        };
        match parts.last_mut() {
            Some(part) if open && from == pair[0] => part.push(to),
            _ => parts.push(vec![from, to]),
        }
        open = to == pair[1];
    }
    parts
}

fn segment(from: Point, to: Point, x: &Range<f64>, y: &Range<f64>) -> Option<(Point, Point)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    // The branch also covers points so far apart that their distance overflows.
    if ![from.0, from.1, to.0, to.1, dx, dy]
        .iter()
        .all(|z| z.is_finite())
    {
        return None;
    }
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (direction, room) in [
        (-dx, from.0 - x.start),
        (dx, x.end - from.0),
        (-dy, from.1 - y.start),
        (dy, y.end - from.1),
    ] {
        if direction == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if direction < 0.0 {
            enter = enter.max(room / direction);
        } else {
            leave = leave.min(room / direction);
        }
    }
    let at = |s: f64| (from.0 + s * dx, from.1 + s * dy);
    (enter <= leave).then(|| {
        let start = if enter == 0.0 { from } else { at(enter) };
        (start, if leave == 1.0 { to } else { at(leave) })
    })
}

/// Returns points of a polyline at least `distance` from the point before; the last point is kept.
pub(crate) fn thin_line(points: &[(i32, i32)], distance: f64) -> Vec<(i32, i32)> {
    let mut kept: Vec<(i32, i32)> = Vec::new();
    for (k, &(x, y)) in points.iter().enumerate() {
        let far = kept
            .last()
            .is_none_or(|&(u, v)| f64::from(x - u).hypot(f64::from(y - v)) >= distance);
        if far || k + 1 == points.len() {
            kept.push((x, y));
        }
    }
    kept
}

/// Returns one point for each cell of a grid with spacing `cell`, at most about `limit` points,
/// evenly along the sequence.
pub(crate) fn thin_dots(points: &[(i32, i32)], cell: i32, limit: usize) -> Vec<(i32, i32)> {
    let mut taken = HashSet::new();
    let cells: Vec<(i32, i32)> = points
        .iter()
        .copied()
        .filter(|&(x, y)| taken.insert((x.div_euclid(cell), y.div_euclid(cell))))
        .collect();
    let stride = cells.len().div_ceil(limit.max(1)).max(1);
    cells.into_iter().step_by(stride).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_of_a_length_that_overflows_is_left_out() {
        let points = [(-1e308, 0.5), (1e308, 0.5), (0.5, 0.5), (0.6, 0.5)];
        let parts = polyline(&points, &(0.0..1.0), &(0.0..1.0));
        assert!(
            parts
                .iter()
                .flatten()
                .all(|p| p.0.is_finite() && p.1.is_finite())
        );
        assert_eq!(parts.last().unwrap().last(), Some(&(0.6, 0.5)));
    }

    #[test]
    fn a_line_that_leaves_and_returns_has_two_parts() {
        let points = [(0.0, 0.5), (2.0, 0.5), (2.0, 0.25), (0.0, 0.25)];
        let parts = polyline(&points, &(0.0..1.0), &(0.0..1.0));
        assert_eq!(
            parts,
            [vec![(0.0, 0.5), (1.0, 0.5)], vec![(1.0, 0.25), (0.0, 0.25)]]
        );
    }

    #[test]
    fn nothing_that_is_not_finite_survives() {
        let points = [
            (0.0, 0.0),
            (f64::NAN, 0.5),
            (1.0, f64::INFINITY),
            (0.5, 0.5),
            (0.75, 0.5),
        ];
        let parts = polyline(&points, &(0.0..1.0), &(0.0..1.0));
        assert_eq!(parts, [vec![(0.5, 0.5), (0.75, 0.5)]]);
    }

    #[test]
    fn dots_are_thinned_to_the_limit() {
        let points: Vec<(i32, i32)> = (0..1000).map(|k| (k, 0)).collect();
        assert_eq!(thin_dots(&points, 2, 10_000).len(), 500);
        assert_eq!(thin_dots(&points, 2, 100).len(), 100);
    }
}
