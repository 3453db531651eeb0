//! Lines cut at gaps and at the edge of the view.

use std::ops::Range;

/// The pieces of a line between gaps and inside a range of values.
pub(super) fn pieces(points: &[(f64, f64)], ys: &Range<f64>) -> Vec<Vec<(f64, f64)>> {
    let mut pieces: Vec<Vec<(f64, f64)>> = vec![vec![]];
    for pair in points.windows(2) {
        let Some((from, to)) = inside(pair[0], pair[1], ys) else {
            pieces.push(vec![]);
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces.retain(|p| !p.is_empty());
    pieces
}

/// The part of a segment inside a range of values; its ends are kept exactly where they
/// are inside.
fn inside(a: (f64, f64), b: (f64, f64), ys: &Range<f64>) -> Option<((f64, f64), (f64, f64))> {
    let finite = [a.0, a.1, b.0, b.1].iter().all(|v| v.is_finite());
    let apart = a.1.max(b.1) < ys.start || a.1.min(b.1) > ys.end;
    if !finite || apart {
        return None;
    }
    let end = |p: (f64, f64)| {
        let y = p.1.clamp(ys.start, ys.end);
        if y == p.1 {
            return p;
        }
        (a.0 + (b.0 - a.0) * ((y - a.1) / (b.1 - a.1)), y)
    };
    Some((end(a), end(b)))
}

#[cfg(test)]
mod tests {
    use super::pieces;

    #[test]
    fn lines_are_cut_at_gaps_and_at_the_edge_of_the_view() {
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, f64::NAN), (4.0, 0.0), (5.0, 0.5)];
        let expected = [
            vec![(0.0, 0.0), (0.5, 1.0)],
            vec![(1.5, 1.0), (2.0, 0.0)],
            vec![(4.0, 0.0), (5.0, 0.5)],
        ];
        assert_eq!(pieces(&points, &(-1.0..1.0)), expected);
        let across = pieces(&[(0.0, -3.0), (1.0, 3.0)], &(-1.5..1.5));
        assert_eq!(across, [vec![(0.25, -1.5), (0.75, 1.5)]]);
    }
}
