//! What a diagram shows inside its axes: bands, lines and marks as paths, with their names and
//! the ranges of the axes, from which a script reads values back.

use super::frame::{FINE, Frame};
use super::look::{INK, LINE, MARK, hex, width};
use super::pieces::pieces;
use super::{Band, Figure, Line, Rug, Style};
use maud::{Markup, html};
use std::fmt::Write;

/// Height of a rug's marks as a share of the diagram's.
const RUG: f64 = 0.05;
/// Opacity of bands.
const PALE: &str = "0.25";

pub(super) fn curves(figure: &Figure, frame: &Frame) -> Markup {
    let Frame { left, top, right, bottom, xs, ys } = frame;
    let scale = 1.0 / FINE;
    html! {
        g class="curves" transform={ "translate(" (left) " " (top) ") scale(" (scale) ")" }
            data-frame={ (left) " " (top) " " (right) " " (bottom) " "
                (number(xs.start)) " " (number(xs.end)) " " (number(ys.start)) " " (number(ys.end)) }
            data-x=(figure.x.label()) data-y=(figure.y.label()) {
            @for b in &figure.bands {
                path class="band" data-label=(b.label) fill=(hex(b.colour.rgb())) fill-opacity=(PALE)
                    d=(outline(b, frame)) {}
            }
            @for l in &figure.lines {
                @if l.style.joins() { (line(l, frame)) }
                @if l.style.marks() { (dots(l, frame)) }
            }
            @if let Some(r) = &figure.rug {
                path fill="none" stroke=(hex(INK)) stroke-width=(2.0 * FINE) d=(marks(r, frame)) {}
            }
        }
    }
}

fn line(l: &Line, frame: &Frame) -> Markup {
    let mut d = String::new();
    for piece in pieces(&l.points, &frame.ys) {
        path(&mut d, piece.into_iter().map(|p| frame.place(p)));
    }
    let dashes = (l.style == Style::Dashed)
        .then(|| format!("{} {}", 3.5 * FINE * f64::from(LINE), 2.25 * FINE * f64::from(LINE)));
    let opacity = (l.style == Style::Broad).then_some("0.4");
    html! {
        path class="line" data-label=(l.label) fill="none" stroke=(hex(l.colour.rgb()))
            stroke-width=(FINE * f64::from(width(l.style))) stroke-linejoin="round"
            stroke-dasharray=[dashes] stroke-opacity=[opacity] d=(d) {}
    }
}

/// A mark at each point, all in one path: points of no length with round ends, or rings.
fn dots(l: &Line, frame: &Frame) -> Markup {
    let radius = (FINE * f64::from(MARK)) as i64;
    let rings = l.style == Style::Rings;
    let mut d = String::new();
    for &(x, y) in l.points.iter().filter(|p| p.0.is_finite() && frame.ys.contains(&p.1)) {
        let (x, y) = frame.place((x, y));
        let _ = match rings {
            true => write!(
                d,
                "M{} {y}a{radius} {radius} 0 1 0 {w} 0a{radius} {radius} 0 1 0-{w} 0",
                x - radius,
                w = 2 * radius
            ),
            false => write!(d, "M{x} {y}h0"),
        };
    }
    let stroke = if rings { FINE * f64::from(LINE) } else { 2.0 * FINE * f64::from(MARK) };
    html! {
        path class="marks" fill="none" stroke=(hex(l.colour.rgb())) stroke-width=(stroke)
            stroke-linecap="round" d=(d) {}
    }
}

/// The outline of a band, in pieces between its gaps.
fn outline(band: &Band, frame: &Frame) -> String {
    let finite = |e: &(f64, f64, f64)| e.0.is_finite() && e.1.is_finite() && e.2.is_finite();
    let cut = |y: f64| y.clamp(frame.ys.start, frame.ys.end);
    let mut d = String::new();
    for edges in band.edges.split(|e| !finite(e)).filter(|piece| !piece.is_empty()) {
        let lower = edges.iter().map(|e| (e.0, cut(e.1)));
        let upper = edges.iter().rev().map(|e| (e.0, cut(e.2)));
        path(&mut d, lower.chain(upper).map(|p| frame.place(p)));
        d.push('z');
    }
    d
}

fn marks(rug: &Rug, frame: &Frame) -> String {
    let (xs, ys) = (&frame.xs, &frame.ys);
    let top = ys.start + RUG * (ys.end - ys.start);
    let mut d = String::new();
    for &x in rug.at.iter().filter(|x| xs.contains(x) || **x == xs.end) {
        path(&mut d, [(x, ys.start), (x, top)].into_iter().map(|p| frame.place(p)));
    }
    d
}

/// Append a piece to a path: where it begins, then each step from point to point.
fn path(d: &mut String, points: impl Iterator<Item = (i64, i64)>) {
    let mut last = None;
    for (x, y) in points {
        let (start, dx, dy) = match last {
            None => ("M", x, y),
            Some((from, a, b)) => (if from { "l" } else { " " }, x - a, y - b),
        };
        // A minus sign separates as well as a space does.
        let start = if start == " " && dx < 0 { "" } else { start };
        let between = if dy < 0 { "" } else { " " };
        let _ = write!(d, "{start}{dx}{between}{dy}");
        last = Some((last.is_none(), x, y));
    }
}

/// A limit with the digits that a readout needs.
fn number(value: f64) -> String {
    format!("{value:.9e}")
}

#[cfg(test)]
mod tests {
    use super::super::Colour;
    use super::*;

    #[test]
    fn paths_are_steps_of_whole_numbers() {
        let mut d = String::new();
        path(&mut d, [(10, 20), (13, 18), (11, 18), (12, 25)].into_iter());
        path(&mut d, [(-1, -2), (0, 0)].into_iter());
        assert_eq!(d, "M10 20l3-2-2 0 1 7M-1-2l1 2");
    }

    #[test]
    fn bands_are_cut_at_gaps() {
        let frame = Frame::new(0..100, 0..100, (0.0..10.0, 0.0..10.0));
        let edge = |x: f64| (x, 2.0, 4.0);
        let edges = vec![edge(0.0), edge(1.0), (2.0, f64::NAN, f64::NAN), edge(3.0), edge(4.0)];
        let d = outline(&Band { label: String::new(), colour: Colour::Ink, edges }, &frame);
        assert_eq!((d.matches('M').count(), d.matches('z').count()), (2, 2), "{d}");
    }

    #[test]
    fn the_corners_of_the_plane_are_its_limits() {
        let frame = Frame::new(100..300, 50..150, (0.0..2.0, -1.0..1.0));
        assert_eq!(frame.place((0.0, 1.0)), (0, 0));
        assert_eq!(frame.place((2.0, -1.0)), (2000, 1000));
        assert_eq!(frame.place((0.5, 0.0)), (500, 500));
    }
}
