//! Errors before and after in units of the noise, a row each on one logarithmic axis.

use super::look::{GRID, INK, LINE, Surface, TEXT, dress, hex};
use super::{ChartError, Colour};
use maud::{Markup, html};
use plotters::prelude::RGBColor;

/// Errors of one channel over its noise; one that is not finite is a model that diverges.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratio {
    /// The channel.
    pub label: String,
    /// The model as it was.
    pub before: f64,
    /// The augmented model.
    pub after: f64,
    /// Both, in words.
    pub says: String,
}

/// Rows of errors over the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Ratios {
    /// What it shows, in words, for those who do not see it.
    pub description: String,
    /// From top to bottom.
    pub rows: Vec<Ratio>,
}

const WIDTH: i32 = 920;
const HEAD: i32 = 72;
const ROW: i32 = 112;
const FOOT: i32 = 118;
/// Height of the lines in a row, which must not cross its words.
const LINES: i32 = 62;
/// Where the axis begins and ends.
const ENDS: (i32, i32) = (40, 860);
const RADIUS: i32 = 15;
/// Characters of a name that are drawn.
const LONGEST: usize = 24;
/// Powers of ten that an axis spans at most; what lies beyond stands at its end.
const MOST: f64 = 8.0;

/// The rows as one SVG text, as wide as its container.
///
/// # Errors
/// [`ChartError::Empty`] when no row has a finite positive ratio.
pub fn ratios_svg(ratios: &Ratios, surface: Surface) -> Result<String, ChartError> {
    let axis = Axis::of(&ratios.rows).ok_or(ChartError::Empty { lines: ratios.rows.len() })?;
    let bottom = HEAD + ROW * ratios.rows.len() as i32;
    let drawn = html! {
        (legend())
        (axis.ticks(ratios.rows.len() as i32))
        @for (k, row) in ratios.rows.iter().enumerate() {
            (axis.row(row, HEAD + ROW * k as i32))
        }
    };
    let size = (WIDTH as u32, (bottom + FOOT) as u32);
    Ok(dress(&drawn.into_string(), &ratios.description, size, surface))
}

/// Powers of ten at both ends.
struct Axis {
    low: f64,
    high: f64,
}

impl Axis {
    fn of(rows: &[Ratio]) -> Option<Self> {
        let shown = |v: &f64| v.is_finite() && *v > 0.0;
        let all = rows.iter().flat_map(|r| [r.before, r.after]).filter(shown).map(f64::log10);
        let (low, high) =
            all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        (low <= high).then(|| {
            let low = (low - 0.1).min(-0.3);
            Self { low, high: (high + 0.1).max(1.0).min(low + MOST) }
        })
    }

    fn place(&self, ratio: f64) -> i32 {
        let share = (ratio.log10() - self.low) / (self.high - self.low);
        let share = if share.is_nan() { 1.0 } else { share.clamp(0.0, 1.0) };
        ENDS.0 + (share * f64::from(ENDS.1 - ENDS.0)).round() as i32
    }

    /// Powers of ten, the noise itself the plainest: lines beneath the words of each row.
    fn ticks(&self, rows: i32) -> Markup {
        let bottom = HEAD + ROW * rows;
        let step = if self.high - self.low > 5.0 { 2 } else { 1 };
        let powers = (self.low.ceil() as i32..=self.high.floor() as i32).filter(|p| p % step == 0);
        html! {
            @for power in powers {
                @let x = self.place(10_f64.powi(power));
                @let (colour, width) = if power == 0 { (INK, LINE) } else { (GRID, 2) };
                @for end in (1..=rows).map(|k| HEAD + ROW * k) {
                    line x1=(x) x2=(x) y1=(end - LINES) y2=(end) stroke=(hex(colour))
                        stroke-width=(width) {}
                }
                (text(x, bottom + TEXT + 4, "middle", INK, &power_of_ten(power)))
            }
            (text(WIDTH / 2, bottom + 2 * TEXT + 14, "middle", INK, "error in units of the noise (1 = the noise floor)"))
        }
    }

    fn row(&self, row: &Ratio, top: i32) -> Markup {
        let (from, to, y) = (self.place(row.before), self.place(row.after), top + 78);
        html! {
            (text(ENDS.0, top + TEXT, "start", INK, &short(&row.label)))
            (text(ENDS.1, top + TEXT, "end", INK, &row.says))
            line x1=(from) x2=(to) y1=(y) y2=(y) stroke=(hex(INK)) stroke-width="3" {}
            (hollow(from, y))
            (full(to, y))
        }
    }
}

fn legend() -> Markup {
    html! {
        (hollow(ENDS.0 + RADIUS, 34))
        (text(ENDS.0 + 46, 48, "start", INK, "model before"))
        (full(ENDS.0 + 375, 34))
        (text(ENDS.0 + 406, 48, "start", INK, "model after"))
    }
}

fn hollow(x: i32, y: i32) -> Markup {
    let colour = hex(Colour::Vermilion.rgb());
    html! { circle cx=(x) cy=(y) r=(RADIUS - 3) fill="none" stroke=(colour) stroke-width="7" {} }
}

fn full(x: i32, y: i32) -> Markup {
    html! { circle cx=(x) cy=(y) r=(RADIUS) fill=(hex(Colour::Blue.rgb())) {} }
}

fn text(x: i32, y: i32, anchor: &str, colour: RGBColor, words: &str) -> Markup {
    html! {
        text x=(x) y=(y) text-anchor=(anchor) font-family="sans-serif" font-size=(TEXT - 3)
            fill=(hex(colour)) { (words) }
    }
}

/// A name as long as there is space for beside the numbers.
fn short(label: &str) -> String {
    if label.chars().count() <= LONGEST {
        return label.to_owned();
    }
    let start: String = label.chars().take(LONGEST - 1).collect();
    format!("{start}…")
}

fn power_of_ten(power: i32) -> String {
    match power {
        0..=3 => 10_i32.pow(power.unsigned_abs()).to_string(),
        -2..=-1 => 10_f64.powi(power).to_string(),
        _ => format!("1e{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(rows: Vec<Ratio>) -> Result<String, ChartError> {
        ratios_svg(&Ratios { description: "errors".into(), rows }, Surface::Own)
    }

    fn row(label: &str, before: f64, after: f64) -> Ratio {
        Ratio { label: label.into(), before, after, says: format!("{before} → {after}") }
    }

    #[test]
    fn rows_have_their_numbers_and_the_axis_its_powers() {
        let text = svg(vec![row("q<1>", 205.2, 1.11), row("b", f64::INFINITY, 3.0)]).unwrap();
        for words in ["q&lt;1&gt;", "205.2 → 1.11", "inf → 3", ">100<", ">1<"] {
            assert!(text.contains(words), "{words}");
        }
        let long = svg(vec![row(&"x".repeat(40), 2.0, 1.0)]).unwrap();
        assert!(long.contains(&format!(">{}…<", "x".repeat(23))));
        assert_eq!(svg(vec![row("a", f64::NAN, 0.0)]), Err(ChartError::Empty { lines: 1 }));
    }

    #[test]
    fn the_axis_is_logarithmic_and_ends_somewhere() {
        let axis = Axis::of(&[row("a", 1e3, 1.0)]).unwrap();
        let (a, b, c) = (axis.place(1.0), axis.place(10.0), axis.place(100.0));
        assert!((c - b - (b - a)).abs() <= 1 && b > a, "{a} {b} {c}");
        let long = Axis::of(&[row("a", 1e30, 1.0)]).unwrap();
        assert_eq!(long.place(1e30), ENDS.1);
        assert!(long.place(1.0) > ENDS.0);
        assert_eq!(long.place(f64::NAN), ENDS.1);
    }
}
