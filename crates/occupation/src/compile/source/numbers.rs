//! Tables as text; numbers are the shortest that are read back the same.

use lacuna_realtime::Eight;

/// Most characters of a line.
const LINE: usize = 96;

/// A list in the given brackets, broken into lines.
pub(super) fn list(values: impl IntoIterator<Item = String>, brackets: [&str; 2]) -> String {
    let mut text = brackets[0].to_owned();
    let mut line = 0;
    for value in values {
        let starts = line == 0 || line + value.len() + 2 > LINE;
        text.push_str(if starts { "\n    " } else { " " });
        line = if starts { 4 } else { line + 1 } + value.len() + 1;
        text.push_str(&value);
        text.push(',');
    }
    text.push('\n');
    text.push_str(brackets[1]);
    text
}

/// Shortest text that is read back the same.
pub(super) fn number(value: f64) -> String {
    format!("{value:?}")
}

pub(super) fn floats(values: &[f64], brackets: [&str; 2]) -> String {
    list(values.iter().map(|v| number(*v)), brackets)
}

pub(super) fn integers(values: &[u16], brackets: [&str; 2]) -> String {
    list(values.iter().map(u16::to_string), brackets)
}

/// Blocks of eight numbers, a line each.
pub(super) fn eights(values: &[Eight], brackets: [&str; 2]) -> String {
    let row = |row: &Eight| {
        let numbers: Vec<String> = row.0.iter().map(|v| number(*v)).collect();
        format!("    {}{}{},\n", brackets[0], numbers.join(", "), brackets[1])
    };
    let rows: String = values.iter().map(row).collect();
    format!("{}\n{rows}{}", brackets[0], brackets[1])
}
