//! The summary for a terminal.

use crate::number::{change, percent, plain};
use crate::words;
use lacuna_discrepancy::diagnosis::{ChannelFit, Diagnosis, Finding, Verdict};

/// Columns of a line.
const WIDTH: usize = 100;
/// Channels whose fit is written out; the page has all.
const CHANNELS: usize = 2;

const BOLD: &str = "1";
const GOOD: &str = "1;32";
const BAD: &str = "1;33";
const DIM: &str = "2";

/// A diagnosis in about ten lines of at most 100 columns: the verdict, each finding with its
/// parameters, probability and rivals, how well the formulas fit, parameters that moved, the fit on held-out recordings
/// before and after against the noise, and the notes. With `colour`, in ANSI colours.
#[must_use]
pub fn summary(diagnosis: &Diagnosis, colour: bool) -> String {
    let mut out = Lines { text: String::new(), colour };
    let good = diagnosis.verdict == Verdict::NoMismatch;
    out.add(if good { GOOD } else { BAD }, 0, &words::verdict(diagnosis));
    for finding in &diagnosis.findings {
        out.add(BOLD, 2, &details(finding));
    }
    if let Some(formula) = words::formula(diagnosis) {
        out.add("", 2, &sentence(&formula));
    }
    let experiment = diagnosis.findings.iter().find_map(|f| f.experiment.as_ref());
    if let Some(experiment) = experiment {
        out.add("", 2, &words::experiment(experiment));
    }
    let moved: Vec<String> =
        words::moved(diagnosis).map(|(name, c)| words::calibration(name, c)).collect();
    if !moved.is_empty() && diagnosis.verdict != Verdict::Miscalibrated {
        out.add("", 2, &format!("Calibrated: {}", moved.join("; ")));
    }
    fit(&mut out, diagnosis);
    for note in &diagnosis.notes {
        out.add(DIM, 2, &format!("Note: {note}"));
    }
    out.text
}

/// A finding with its numbers, its rivals and the part of the range it acts in.
fn details(f: &Finding) -> String {
    let numbers: Vec<String> =
        f.parameters.iter().map(|(name, e)| words::parameter(name, e)).collect();
    let mut parts = vec![numbers.join(", "), format!("probability {}", percent(f.probability))];
    let rivals = f.alternatives.iter().filter(|a| a.probability > words::LIKELY);
    parts.extend(rivals.map(|a| {
        format!("or {} {}", words::class_at(&a.class, &a.channel), percent(a.probability))
    }));
    parts.extend(words::part(f));
    parts.retain(|p| !p.is_empty());
    format!("{}: {}", words::name(f), parts.join("; "))
}

/// Words as a sentence.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map_or(String::new(), |c| c.to_uppercase().to_string());
    format!("{first}{}.", letters.as_str())
}

fn fit(out: &mut Lines, d: &Diagnosis) {
    let channels = words::by_error(d);
    if channels.is_empty() {
        return;
    }
    let more = channels.len().saturating_sub(CHANNELS);
    let others = if more > 0 { format!(" ({more} more on the page)") } else { String::new() };
    out.add("", 2, &format!("Error on held-out recordings (rms), before -> after{others}:"));
    for (name, fit) in channels.iter().take(CHANNELS) {
        out.add("", 4, &channel(name, fit));
    }
}

fn channel(name: &str, f: &ChannelFit) -> String {
    let arrow = |before, after| change(before, "->", after, &f.unit);
    let worse = words::grows(f.rmse_before, f.rmse_after)
        || words::grows(f.free_run_before, f.free_run_after);
    format!(
        "{name}: {} over {}, {} running free; noise {}{}",
        arrow(f.rmse_before, f.rmse_after),
        plain(f.horizon_s, "s"),
        arrow(f.free_run_before, f.free_run_after),
        plain(f.noise, &f.unit),
        if worse { " (worse than before)" } else { "" }
    )
}

struct Lines {
    text: String,
    colour: bool,
}

impl Lines {
    /// Add a paragraph, broken into lines; continuation lines are indented further.
    fn add(&mut self, style: &str, indent: usize, paragraph: &str) {
        for (k, line) in wrap(paragraph, WIDTH - indent - 2).iter().enumerate() {
            let space = " ".repeat(if k == 0 { indent } else { indent + 2 });
            let line = match self.colour && !style.is_empty() {
                true => format!("{space}\x1b[{style}m{line}\x1b[0m\n"),
                false => format!("{space}{line}\n"),
            };
            self.text.push_str(&line);
        }
    }
}

/// Break text at spaces into lines of at most `width` characters, and a longer word inside.
/// Control characters of names, which a terminal would obey, are left out.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let characters: Vec<char> = word.chars().filter(|c| !c.is_control()).collect();
        for piece in characters.chunks(width) {
            match lines.last_mut() {
                Some(line) if line.chars().count() + 1 + piece.len() <= width => {
                    line.push(' ');
                    line.extend(piece);
                }
                _ => lines.push(piece.iter().collect()),
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn lines_break_at_spaces_and_inside_long_words() {
        assert_eq!(wrap("one two three", 8), ["one two", "three"]);
        assert_eq!(wrap("abcdefghij k", 4), ["abcd", "efgh", "ij k"]);
        assert_eq!(wrap("a\x1b[31mb\nc", 20), ["a[31mb c"]);
        assert!(wrap("", 8).is_empty());
    }
}
