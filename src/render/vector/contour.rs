//! The zero line of a function on the page, by marching squares with linear interpolation: walls of any kind are drawn
//! where their separation is zero.

use crate::page::{Path, PathBuilder};
use glam::DVec2;
use std::collections::BTreeMap;

/// Squares along the longer side of a page. Within a square, a circle of the page's size has an error of a
/// ten-thousandth of a square.
const SQUARES: f64 = 480.0;

/// An edge of a square: its lower or left end, and whether it goes up.
type Edge = (usize, usize, bool);

/// The line on which `of` is zero, on a page of this size; `None` if `of` has no zero there.
pub(super) fn zero([wide, high]: [f64; 2], of: impl Fn(f64, f64) -> f64) -> Option<Path> {
    let side = wide.max(high) / SQUARES;
    let [columns, rows] = [wide, high].map(|length| (length / side).ceil() as usize);
    let values: Vec<Vec<f64>> = (0..=rows)
        .map(|row| (0..=columns).map(|column| of(column as f64 * side, row as f64 * side)).collect())
        .collect();
    let point = |(column, row, up): Edge| {
        let [from, to] = [values[row][column], if up { values[row + 1][column] } else { values[row][column + 1] }];
        let part = from / (from - to);
        let along = if up { DVec2::Y } else { DVec2::X };
        side * (DVec2::new(column as f64, row as f64) + part * along)
    };
    let mut next: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for row in 0..rows {
        for column in 0..columns {
            let edges = [(column, row, false), (column + 1, row, true), (column, row + 1, false), (column, row, true)];
            let corners = [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)];
            let inside = corners.map(|(row, column)| values[row][column] > 0.0);
            let cut: Vec<Edge> = (0..4).filter(|k| inside[*k] != inside[(k + 1) % 4]).map(|k| edges[k]).collect();
            // At a saddle either pairing is valid; consecutive crossings are paired.
            for pair in cut.chunks_exact(2) {
                next.entry(pair[0]).or_default().push(pair[1]);
                next.entry(pair[1]).or_default().push(pair[0]);
            }
        }
    }
    chained(next, point)
}

/// Joins segments to lines; each line starts at an end if it has one.
fn chained(mut next: BTreeMap<Edge, Vec<Edge>>, point: impl Fn(Edge) -> DVec2) -> Option<Path> {
    let mut builder = PathBuilder::new();
    while let Some(start) = next.iter().find(|(_, ends)| ends.len() == 1).or(next.iter().next()).map(|(edge, _)| *edge)
    {
        let mut at = start;
        let place = |edge| point(edge).as_vec2();
        builder.move_to(place(at).x, place(at).y);
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            if next.get(&at).is_some_and(Vec::is_empty) {
                next.remove(&at);
            }
            if let Some(back) = next.get_mut(&to) {
                back.retain(|edge| *edge != at);
                if back.is_empty() {
                    next.remove(&to);
                }
            }
            builder.line_to(place(to).x, place(to).y);
            at = to;
        }
        next.remove(&start);
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiny_skia::PathSegment;

    fn points(path: &Path) -> (usize, Vec<DVec2>) {
        let of = |segment| match segment {
            PathSegment::MoveTo(p) | PathSegment::LineTo(p) => Some(DVec2::new(f64::from(p.x), f64::from(p.y))),
            _ => None,
        };
        let begun = path.segments().filter(|segment| matches!(segment, PathSegment::MoveTo(_))).count();
        (begun, path.segments().filter_map(of).collect())
    }

    #[test]
    fn a_circle_is_one_closed_line_and_a_channel_two_straight_ones() {
        let round = |x: f64, y: f64| 100.0 - DVec2::new(x - 200.0, y - 150.0).length();
        let (begun, round) = points(&zero([400.0, 300.0], round).unwrap());
        assert!(begun == 1 && round.first() == round.last() && round.len() > 400);
        assert!(round.iter().all(|p| (p.distance(DVec2::new(200.0, 150.0)) - 100.0).abs() < 2e-3));
        let (begun, channel) = points(&zero([400.0, 300.0], |_, y| 50.3 - (y - 150.0).abs()).unwrap());
        assert!(begun == 2 && channel.iter().all(|p| ((p.y - 150.0).abs() - 50.3).abs() < 1e-3));
        assert!(zero([400.0, 300.0], |_, _| f64::INFINITY).is_none());
    }
}
