//! The missing force of each channel, as it was learned, and the named laws.

use super::{Drawing, Picture};
use crate::words;
use lacuna_charts::{Axis, Band, Colour, Figure, Line, Style};
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{ChannelMismatch, Curve, Finding};

/// Pictures by channel: each finding's law over what the recordings show beside the other laws,
/// then the curves that were learned before anything is added, over variables without a law.
pub(crate) fn missing_forces(d: &Diagnosis) -> Vec<(String, Vec<Picture>)> {
    let mut names: Vec<&String> = d.location.channels.keys().collect();
    names.extend(d.findings.iter().map(|f| &f.channel));
    names.sort();
    names.dedup();
    let one = |name: &String| (name.clone(), channel(d, name, d.location.channels.get(name)));
    names.into_iter().map(one).filter(|(_, pictures)| !pictures.is_empty()).collect()
}

fn channel(d: &Diagnosis, name: &str, mismatch: Option<&ChannelMismatch>) -> Vec<Picture> {
    let named: Vec<(&Finding, &Curve)> = d
        .findings
        .iter()
        .filter(|f| f.channel == name)
        .filter_map(|f| Some((f, f.curve.as_ref()?)))
        .collect();
    let lawless = |c: &&Curve| named.iter().all(|(_, n)| n.variable != c.variable);
    let learned = mismatch.into_iter().flat_map(|m| &m.curves).filter(lawless);
    let law = |(finding, c): &(&Finding, &Curve)| {
        let what = words::name(finding);
        picture(name, c, &format!("{what}, over {}", c.variable), Some(&what))
    };
    let bare = |c| {
        picture(
            name,
            c,
            &format!("Missing in {name} before anything is added, over {}", c.variable),
            None,
        )
    };
    named.iter().map(law).chain(learned.map(bare)).collect()
}

/// The learned force with a band of two standard deviations, and the law, if any, over it.
pub(super) fn picture(channel: &str, c: &Curve, caption: &str, law: Option<&str>) -> Picture {
    let points = |y: &[f64]| {
        let all = c.at.iter().copied().zip(y.iter().copied()).collect();
        with_gaps(all, |p: &(f64, f64)| p.0, (f64::NAN, f64::NAN))
    };
    let edges = c.at.iter().zip(&c.learned).zip(&c.std);
    let edges = edges.map(|((&x, &y), &s)| (x, y - 2.0 * s, y + 2.0 * s)).collect();
    let edges = with_gaps(edges, |e: &(f64, f64, f64)| e.0, (f64::NAN, f64::NAN, f64::NAN));
    let line = |label: &str, colour, style, values: &[f64]| {
        Line::new(label, colour, style, points(values))
    };
    // Beneath a law that is right a thin line would not be seen.
    let style = if c.law.is_empty() { Style::Solid } else { Style::Broad };
    let mut lines = vec![line("learned, no formula", Colour::Ink, style, &c.learned)];
    if !c.law.is_empty() {
        lines.push(line("named law", Colour::Blue, Style::Solid, &c.law));
    }
    let figure = Figure {
        description: description(channel, c, law),
        bands: vec![Band { label: "± 2 std".into(), colour: Colour::Ink, edges }],
        lines,
        within: view(c),
        ..Figure::new(
            Axis::linear(&c.variable, &c.variable_unit),
            Axis::linear("missing force", &c.force_unit),
        )
    };
    Picture {
        kind: "missing-force",
        of: format!("{channel} {}", c.variable),
        caption: caption.to_owned(),
        drawing: Drawing::Figure(Box::new(figure)),
    }
}

/// The points with a gap wherever values of the variable were left out, as never visited.
fn with_gaps<P: Copy>(points: Vec<P>, x: impl Fn(&P) -> f64, gap: P) -> Vec<P> {
    const APART: f64 = 1.5;
    let steps = points.windows(2).map(|pair| x(&pair[1]) - x(&pair[0]));
    let usual = steps.fold(f64::INFINITY, f64::min);
    let mut out: Vec<P> = Vec::with_capacity(points.len());
    for point in points {
        if out.last().is_some_and(|last| x(&point) - x(last) > APART * usual) {
            out.push(gap);
        }
        out.push(point);
    }
    out
}

/// Both curves with half their span around them: the band may open wide where data are few.
pub(super) fn view(c: &Curve) -> Option<(f64, f64)> {
    let curves = c.learned.iter().chain(&c.law).filter(|v| v.is_finite());
    let (low, high) =
        curves.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let half = 0.5 * (high - low);
    (half > 0.0).then_some((low - half, high + half))
}

fn description(channel: &str, c: &Curve, law: Option<&str>) -> String {
    let start = format!(
        "Missing force in the equation of {channel} over {}, learned without a formula",
        c.variable
    );
    let Some(law) = law else { return format!("{start}, with a band of two standard deviations.") };
    let inside = c.at.len().min(c.law.len()).min(c.learned.len()).min(c.std.len());
    let within = (0..inside).filter(|&k| (c.law[k] - c.learned[k]).abs() <= 2.0 * c.std[k]).count();
    format!(
        "{start}, with the law of {law} over it; the law is within two standard deviations at \
         {within} of {inside} points."
    )
}

#[cfg(test)]
mod tests {
    use super::with_gaps;

    #[test]
    fn values_that_were_left_out_are_gaps() {
        let points = vec![(0.0, 1.0), (0.5, 1.0), (2.0, 3.0), (2.5, 3.0)];
        let found = with_gaps(points.clone(), |p: &(f64, f64)| p.0, (f64::NAN, f64::NAN));
        assert_eq!(found.len(), 5);
        assert!(found[2].0.is_nan() && found[1] == points[1] && found[3] == points[2]);
    }
}
