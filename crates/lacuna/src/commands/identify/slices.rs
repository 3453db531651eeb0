//! functions.svg: each identified function against each of its arguments, through the data.

use super::choice::function;
use lacuna::charts::{Axis, Band, Colour, Figure, Grid, Line, Rug, Style};
use lacuna::identification::Columns;
use lacuna::identification::Stretch;
use lacuna::occupation::IdentifiedModel;
use lacuna::occupation::identification::Report as Chosen;
use lacuna::table::number;
use std::error::Error;

/// Points of a curve.
const POINTS: usize = 101;
/// Share of the data that the curves leave out at either end.
const TAIL: f64 = 0.01;
/// Marks of where the data are: quantiles at equal steps.
const MARKS: usize = 40;

/// One argument's values over the recordings, in order.
struct Seen(Vec<f64>);

impl Seen {
    fn quantile(&self, share: f64) -> f64 {
        self.0[(share * (self.0.len() - 1) as f64).round() as usize]
    }

    /// From the 1st to the 99th percentile; from the least to the greatest where these are the
    /// same.
    fn range(&self) -> (f64, f64) {
        match (self.quantile(TAIL), self.quantile(1.0 - TAIL)) {
            (low, high) if low < high => (low, high),
            _ => (self.quantile(0.0), self.quantile(1.0)),
        }
    }

    fn marks(&self) -> Vec<f64> {
        (0..MARKS).map(|k| self.quantile((k as f64 + 0.5) / MARKS as f64)).collect()
    }
}

/// All functions and their standard deviations where one argument runs through its range and the
/// others stay at their medians.
struct Slice {
    at: Vec<f64>,
    /// Values and standard deviations of f_i, g_i1, ..., g_im for each coordinate, point by point.
    values: Vec<Vec<(f64, f64)>>,
}

impl Slice {
    fn of(
        model: &IdentifiedModel,
        medians: &[f64],
        i: usize,
        seen: &Seen,
    ) -> Result<Self, Box<dyn Error>> {
        let (low, high) = seen.range();
        let at: Vec<f64> =
            (0..POINTS).map(|k| low + (high - low) * k as f64 / (POINTS - 1) as f64).collect();
        let mut x = medians.to_vec();
        let values = at.iter().map(|v| {
            x[i] = *v;
            known(model, &x)
        });
        let values = values.collect::<Result<_, _>>()?;
        Ok(Self { at, values })
    }
}

/// f_i, g_i1, ..., g_im for each coordinate with their standard deviations.
fn known(model: &IdentifiedModel, x: &[f64]) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let (n, m) = (model.dimension(), model.inputs());
    let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
    model.evaluate(x, &mut f, &mut g)?;
    let sd = model.standard_deviations(x)?.ok_or("the model has no standard deviations")?;
    let row = |i: usize| {
        let g = (i * m..(i + 1) * m).map(|k| (g[k], sd.g[k]));
        std::iter::once((f[i], sd.f[i])).chain(g).collect::<Vec<_>>()
    };
    Ok((0..n).flat_map(row).collect())
}

/// The diagrams: f against all arguments, g against those that it depends on; a constant g
/// against the first. A function's diagrams stand in one row.
pub fn grid(
    model: &IdentifiedModel,
    chosen: &Chosen,
    columns: &Columns,
    stretches: &[&Stretch],
) -> Result<Grid, Box<dyn Error>> {
    let d = model.arguments();
    let seen: Vec<Seen> = (0..d).map(|i| values(stretches, d, i)).collect();
    let medians: Vec<f64> = seen.iter().map(|s| s.quantile(0.5)).collect();
    let slices =
        (0..d).map(|i| Slice::of(model, &medians, i, &seen[i])).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (row, channel) in chosen.rows.iter().zip(&columns.channels) {
        for (b, block) in row.blocks.iter().enumerate() {
            let name = function(channel, b, columns);
            let entry = rows.len();
            let arguments = match (b, &block.choice.depends_on[..]) {
                (0, _) => (0..d).collect(),
                (_, []) => vec![0],
                (_, some) => some.to_vec(),
            };
            let diagram =
                |&i: &usize| diagram(&name, &columns.arguments[i], &slices[i], entry, &seen[i], d);
            rows.push(arguments.iter().map(diagram).collect());
        }
    }
    Ok(Grid { description: description(columns, &medians, &rows), rows })
}

fn values(stretches: &[&Stretch], d: usize, i: usize) -> Seen {
    let all = stretches.iter().flat_map(|s| s.data.arguments().iter().skip(i).step_by(d));
    let mut values: Vec<f64> = all.copied().collect();
    values.sort_by(f64::total_cmp);
    Seen(values)
}

fn diagram(
    name: &str,
    argument: &str,
    slice: &Slice,
    entry: usize,
    seen: &Seen,
    d: usize,
) -> Figure {
    let points = || slice.at.iter().zip(&slice.values).map(|(x, row)| (*x, row[entry]));
    let x =
        if d == 1 { argument.to_owned() } else { format!("{argument}, others at their median") };
    Figure {
        description: format!("{name} against {argument}"),
        bands: vec![Band {
            label: "± 2 standard deviations".into(),
            colour: Colour::Blue,
            edges: points().map(|(x, (y, sd))| (x, y - 2.0 * sd, y + 2.0 * sd)).collect(),
        }],
        lines: vec![Line {
            label: "identified".into(),
            colour: Colour::Blue,
            style: Style::Solid,
            points: points().map(|(x, (y, _))| (x, y)).collect(),
        }],
        rug: Some(Rug { label: "data (quantiles)".into(), at: seen.marks() }),
        ..Figure::new(Axis::linear(&x, ""), Axis::linear(name, ""))
    }
}

fn description(columns: &Columns, medians: &[f64], rows: &[Vec<Figure>]) -> String {
    let shown: Vec<&str> = rows.iter().flatten().map(|f| f.description.as_str()).collect();
    let names = columns.arguments.iter().zip(medians);
    let medians: Vec<String> = names.map(|(name, v)| format!("{name} {}", number(*v))).collect();
    format!("Identified functions: {}. Medians: {}.", shown.join(", "), medians.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_leaves_out_the_tails() {
        let seen = Seen((0..=1000).map(f64::from).collect());
        assert_eq!((seen.quantile(0.5), seen.range()), (500.0, (10.0, 990.0)));
        let marks = seen.marks();
        assert!(marks.len() == MARKS && marks[0] > 10.0 && marks[MARKS - 1] < 990.0);
        // One value nearly always: the range is that of all.
        let mut jump = vec![1.0; 999];
        jump.push(5.0);
        assert_eq!(Seen(jump).range(), (1.0, 5.0));
    }
}
