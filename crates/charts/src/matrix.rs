//! Tables of counts as shaded cells.

use super::Colour;
use super::look::{GRID, INK, Surface, dress, hex};
use maud::{Markup, html};

/// Side of a cell, and room for the labels on the left and at the top.
const CELL: usize = 26;
const LABELS: usize = 190;
const MARGIN: usize = 16;
const HEAD: usize = 44;
const TEXT: usize = 14;
const TITLE: usize = 19;
/// Opacity of a cell that holds all of its row.
const DARKEST: f64 = 0.75;

/// A table of counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matrix {
    /// What it shows, in words, for those who do not see it.
    pub description: String,
    /// Heading.
    pub title: String,
    /// What the rows are, and what the columns are.
    pub axes: [String; 2],
    /// Label of each row.
    pub rows: Vec<String>,
    /// Label of each column.
    pub columns: Vec<String>,
    /// Counts, row by row; what goes beyond the labels is not drawn.
    pub counts: Vec<Vec<usize>>,
}

/// The table as one SVG text: each cell shaded by its share of the row, with the count in it.
/// Cells whose row and column have the same label are framed, and shaded blue in place of
/// vermilion.
#[must_use]
pub fn matrix_svg(matrix: &Matrix, surface: Surface) -> String {
    let (rows, columns) = (matrix.rows.len(), matrix.columns.len());
    let (left, top) = (MARGIN + LABELS, MARGIN + HEAD + LABELS);
    let (width, height) = (left + CELL * columns + MARGIN, top + CELL * rows + MARGIN);
    let middle = |start: usize, k: usize| start + CELL * k + CELL / 2;
    let axes = format!("rows: {}; columns: {}", matrix.axes[0], matrix.axes[1]);
    let drawn = html! {
        (text(MARGIN, MARGIN + TITLE, "start", TITLE, &matrix.title))
        (text(MARGIN, MARGIN + TITLE + 26, "start", TEXT, &axes))
        @for (j, label) in matrix.columns.iter().enumerate() {
            @let (x, y) = (middle(left, j) + TEXT / 3, top - 8);
            g transform={ "rotate(-90 " (x) " " (y) ")" } { (text(x, y, "start", TEXT, label)) }
        }
        @for (i, (label, counts)) in matrix.rows.iter().zip(&matrix.counts).enumerate() {
            @let y = middle(top, i) + TEXT / 3;
            (text(left - 8, y, "end", TEXT, label))
            @for (j, (column, &count)) in matrix.columns.iter().zip(counts).enumerate() {
                @let share = count as f64 / counts.iter().sum::<usize>().max(1) as f64;
                (cell((left + CELL * j, top + CELL * i), label == column, share))
                @if count > 0 { (text(middle(left, j), y, "middle", TEXT, &count.to_string())) }
            }
        }
        // Frames over the lines of their neighbours.
        @for (i, label) in matrix.rows.iter().enumerate() {
            @if let Some(j) = matrix.columns.iter().position(|c| c == label) {
                rect x=(left + CELL * j) y=(top + CELL * i) width=(CELL) height=(CELL)
                    fill="none" stroke=(hex(INK)) {}
            }
        }
    };
    let size = (width as u32, height as u32);
    dress(&drawn.into_string(), &matrix.description, size, surface)
}

fn cell((x, y): (usize, usize), same: bool, share: f64) -> Markup {
    let colour = if same { Colour::Blue } else { Colour::Vermilion };
    html! {
        rect x=(x) y=(y) width=(CELL) height=(CELL) fill=(hex(colour.rgb()))
            fill-opacity=(format!("{:.3}", DARKEST * share)) stroke=(hex(GRID)) {}
    }
}

fn text(x: usize, y: usize, anchor: &str, size: usize, words: &str) -> Markup {
    html! {
        text x=(x) y=(y) text-anchor=(anchor) font-family="sans-serif" font-size=(size)
            fill=(hex(INK)) { (words) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_holds_its_labels_and_counts() {
        let texts = |words: [&str; 2]| words.map(str::to_owned);
        let svg = matrix_svg(
            &Matrix {
                description: "Found classes by true class".into(),
                title: "Confusion".into(),
                axes: texts(["true", "found"]),
                rows: texts(["one", "two<three"]).into(),
                columns: texts(["one", "nothing"]).into(),
                counts: vec![vec![17, 0], vec![0, 23]],
            },
            Surface::Own,
        );
        for word in ["Confusion", "two&lt;three", "nothing", ">17<", ">23<"] {
            assert!(svg.contains(word), "{word}");
        }
        // Four cells and the ground; one frame, where row and column are the same.
        assert_eq!((svg.matches("<rect").count(), svg.matches("fill=\"none\"").count()), (6, 1));
    }
}
