//! What the identification chose, and what it could not tell, in words.

use lacuna::identification::Columns;
use lacuna::occupation::identification::{BlockChoice, Report, Warning};
use lacuna::table::{Table, number};

/// Kernels, noise and windows.
pub fn text(report: &Report, columns: &Columns) -> String {
    let mut table = Table::new(&[
        "function",
        "kernel",
        "width in each argument",
        "lambda",
        "landmarks",
        "rms",
        "sd",
    ]);
    for (row, channel) in report.rows.iter().zip(&columns.channels) {
        for (b, block) in row.blocks.iter().enumerate() {
            table.row(vec![
                function(channel, b, columns),
                block.choice.kernel.family.to_string(),
                widths(&block.choice, columns),
                number(block.lambda),
                block.landmarks.to_string(),
                number(block.rms),
                number(block.sd),
            ]);
        }
    }
    let mut out = table.text();
    out += "  Rms and sd: of the function and of its standard deviation, over the recordings.\n";
    let noise: Vec<String> = columns
        .channels
        .iter()
        .zip(&report.noise_sd)
        .map(|(channel, sd)| format!("{channel} {}", number(*sd)))
        .collect();
    out += &format!(
        "  {} windows of at most {} s; noise: {}\n",
        report.windows,
        number(report.window_seconds),
        noise.join(", ")
    );
    out
}

/// `f of q1`, `g of q1 by tau1`.
pub fn function(channel: &str, block: usize, columns: &Columns) -> String {
    match block {
        0 => format!("f of {channel}"),
        j => format!("g of {channel} by {}", columns.inputs[j - 1]),
    }
}

fn widths(choice: &BlockChoice, columns: &Columns) -> String {
    let width =
        |&i: &usize| format!("{} {}", columns.arguments[i], number(choice.kernel.widths[i]));
    let used: Vec<String> = choice.depends_on.iter().map(width).collect();
    if used.is_empty() { "constant".to_owned() } else { used.join(", ") }
}

/// What the data cannot tell.
pub fn warnings(report: &Report, columns: &Columns) -> Vec<String> {
    let said = report.warnings.iter().map(|w| warning(w, columns));
    said.chain(no_effect(report, columns)).collect()
}

/// Effectivenesses that are smaller than their standard deviation, where no warning says so yet:
/// they are better known than before the data, and still may be none.
fn no_effect(report: &Report, columns: &Columns) -> Vec<String> {
    let said = |i: usize, j: usize| {
        report.warnings.iter().any(|w| {
            matches!(w, Warning::NotExcited { input, coordinate, .. } if (*coordinate, *input) == (i, j))
        })
    };
    let mut out = Vec::new();
    for (i, row) in report.rows.iter().enumerate() {
        for (j, block) in row.blocks.iter().skip(1).enumerate() {
            if block.sd > block.rms && !said(i, j) {
                out.push(format!(
                    "'{}' may have no effect on '{}': g is {} (rms) with a standard deviation of {}; if it has one, \
                     move that input more, and by itself",
                    columns.inputs[j],
                    columns.channels[i],
                    number(block.rms),
                    number(block.sd)
                ));
            }
        }
    }
    out
}

fn warning(warning: &Warning, columns: &Columns) -> String {
    match warning {
        Warning::NotExcited { input, coordinate, unknown, .. } => format!(
            "the recordings hardly tell what '{}' does to '{}': the standard deviation of g is {:.0} % of what it was \
             before them; move that input more, and by itself",
            columns.inputs[*input],
            columns.channels[*coordinate],
            100.0 * unknown
        ),
        Warning::NoData { coordinate, block, share } => format!(
            "{}: in {:.0} % of the box that the recordings span there are too few data, and the prior speaks; look at \
             the standard deviations before you trust it there",
            function(&columns.channels[*coordinate], *block, columns),
            100.0 * share
        ),
    }
}
