//! model.json, drift.csv, effectiveness.csv and functions.svg, written whole or not at all.

use super::slices;
use lacuna::charts::grid_svg;
use lacuna::files::write_together;
use lacuna::identification::Columns;
use lacuna::identification::Stretch;
use lacuna::occupation::IdentifiedModel;
use lacuna::occupation::identification::Report as Chosen;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Most rows of the tables.
const MOST_ROWS: usize = 1000;

/// Write the files and return their paths. The model is as [`IdentifiedModel::load`] reads it.
pub fn write(
    folder: &Path,
    model: &IdentifiedModel,
    chosen: &Chosen,
    columns: &Columns,
    stretches: &[&Stretch],
) -> Result<Vec<String>, Box<dyn Error>> {
    let (drift, effectiveness) = tables(model, columns, stretches)?;
    let functions = grid_svg(&slices::grid(model, chosen, columns, stretches)?)?;
    let files = [
        ("model.json", model.to_json()),
        ("drift.csv", drift),
        ("effectiveness.csv", effectiveness),
        ("functions.svg", functions + "\n"),
    ];
    let files = files.map(|(name, text)| (folder.join(name), text));
    write_together(&files.each_ref().map(|(path, text)| (path.as_path(), text.as_str())))?;
    Ok(files.iter().map(|(path, _)| path.display().to_string()).collect())
}

/// f and g along the training samples with their standard deviations, thinned.
fn tables(
    model: &IdentifiedModel,
    columns: &Columns,
    stretches: &[&Stretch],
) -> Result<(String, String), Box<dyn Error>> {
    let (n, m, d) = (model.dimension(), model.inputs(), model.arguments());
    let header = format!("recording,{},{}", columns.time, columns.arguments.join(","));
    let (mut drift, mut effectiveness) = (header.clone(), header);
    for channel in &columns.channels {
        write!(drift, ",f_{channel},f_{channel}_sd")?;
        for input in &columns.inputs {
            write!(effectiveness, ",g_{channel}_{input},g_{channel}_{input}_sd")?;
        }
    }
    let total: usize = stretches.iter().map(|s| s.data.samples()).sum();
    let samples = stretches.iter().flat_map(|s| (0..s.data.samples()).map(move |k| (s, k)));
    let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
    for (s, k) in samples.step_by(total.div_ceil(MOST_ROWS)) {
        let x = &s.data.arguments()[k * d..(k + 1) * d];
        model.evaluate(x, &mut f, &mut g)?;
        let sd = model.standard_deviations(x)?.ok_or("the model has no standard deviations")?;
        for (text, values, sds) in [(&mut drift, &f, &sd.f), (&mut effectiveness, &g, &sd.g)] {
            write!(text, "\n{},{}", s.recording, s.data.times()[k])?;
            x.iter().try_for_each(|v| write!(text, ",{v}"))?;
            values.iter().zip(sds).try_for_each(|(v, sd)| write!(text, ",{v},{sd}"))?;
        }
    }
    drift.push('\n');
    effectiveness.push('\n');
    Ok((drift, effectiveness))
}
