//! Tables of counts as shaded cells.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{COLOURS, FONT, GRID, INK, failed};
use crate::StudyError;

/// Side of a cell, and room for the labels on the left and at the top (pixels).
const CELL: i32 = 24;
const LABELS: i32 = 190;
const MARGIN: i32 = 16;
const TITLE: i32 = 34;

/// A table of counts.
#[derive(Clone, Debug)]
pub struct Matrix<'a> {
    /// Heading.
    pub title: &'a str,
    /// What the rows are, and what the columns are.
    pub axes: [&'a str; 2],
    /// Label of each row.
    pub rows: Vec<String>,
    /// Label of each column.
    pub columns: Vec<String>,
    /// Counts, row by row.
    pub counts: Vec<Vec<usize>>,
}

impl Matrix<'_> {
    /// Cells whose row and column have the same label.
    fn same(&self) -> impl Iterator<Item = (i32, i32)> {
        let column = |label: &String| self.columns.iter().position(|c| c == label);
        let cells = self.rows.iter().enumerate();
        cells.filter_map(move |(i, label)| Some((i as i32, column(label)? as i32)))
    }
}

/// Draw a table: each cell shaded by its share of the row, with the count in it. Cells whose row
/// and column have the same label are framed.
///
/// # Errors
/// [`StudyError::Figure`] when it cannot be drawn.
pub fn matrix_figure(matrix: &Matrix) -> Result<String, StudyError> {
    let (rows, columns) = (matrix.rows.len() as i32, matrix.columns.len() as i32);
    let size = (
        (LABELS + CELL * columns + 2 * MARGIN) as u32,
        (TITLE + LABELS + CELL * rows + 2 * MARGIN) as u32,
    );
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let text = |words: &str, at: (i32, i32), style: &TextStyle| {
            root.draw_text(words, style, at).map_err(failed)
        };
        let plain = TextStyle::from((FONT, 13).into_font()).color(&INK);
        let right = plain.pos(Pos::new(HPos::Right, VPos::Center));
        let up = (FONT, 13).into_font().transform(FontTransform::Rotate270);
        let up = TextStyle::from(up).color(&INK).pos(Pos::new(HPos::Left, VPos::Center));
        let centred = plain.pos(Pos::new(HPos::Center, VPos::Center));
        let heading = TextStyle::from((FONT, 18).into_font()).color(&INK);
        text(matrix.title, (MARGIN, MARGIN), &heading)?;
        let axes = format!("rows: {}; columns: {}", matrix.axes[0], matrix.axes[1]);
        text(&axes, (MARGIN, MARGIN + 24), &plain)?;
        let (left, top) = (MARGIN + LABELS, MARGIN + TITLE + LABELS);
        for (j, label) in matrix.columns.iter().enumerate() {
            text(label, (left + CELL * j as i32 + CELL / 2, top - 6), &up)?;
        }
        for (i, label) in matrix.rows.iter().enumerate() {
            let y = top + CELL * i as i32;
            text(label, (left - 6, y + CELL / 2), &right)?;
            let sum: usize = matrix.counts[i].iter().sum();
            for (j, &count) in matrix.counts[i].iter().enumerate() {
                let x = left + CELL * j as i32;
                let corners = [(x, y), (x + CELL, y + CELL)];
                let same = *label == matrix.columns[j];
                let colour = COLOURS[if same { 0 } else { 1 }];
                let share = count as f64 / sum.max(1) as f64;
                let shade = Rectangle::new(corners, colour.mix(0.75 * share).filled());
                root.draw(&shade).map_err(failed)?;
                root.draw(&Rectangle::new(corners, GRID.stroke_width(1))).map_err(failed)?;
                if count > 0 {
                    text(&count.to_string(), (x + CELL / 2, y + CELL / 2), &centred)?;
                }
            }
        }
        // Frames over the lines of their neighbours.
        for (i, j) in matrix.same() {
            let (x, y) = (left + CELL * j, top + CELL * i);
            let frame = Rectangle::new([(x, y), (x + CELL, y + CELL)], INK.stroke_width(1));
            root.draw(&frame).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_holds_its_labels_and_counts() {
        let svg = matrix_figure(&Matrix {
            title: "Confusion",
            axes: ["true", "found"],
            rows: vec!["cogging".to_owned(), "end_stop".to_owned()],
            columns: vec!["cogging".to_owned(), "nothing".to_owned()],
            counts: vec![vec![17, 0], vec![0, 23]],
        })
        .unwrap();
        for word in ["Confusion", "end_stop", "nothing", "17", "23"] {
            assert!(svg.contains(word), "{word}");
        }
    }
}
