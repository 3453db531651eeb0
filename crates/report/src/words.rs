//! What a diagnosis says, in sentences: the summary and the page use the same.

use crate::joints::{self, Kind};
use crate::number::{change, diverged, estimate, given, percent, plain, ratio};
use lacuna_discrepancy::conventions::Otherwise;
use lacuna_discrepancy::diagnosis::{
    Calibration, ChannelFit, Diagnosis, Estimate, Experiment, Finding, FormulaFit, ProofOutcome,
    Verdict,
};
use lacuna_effects::Effect;

/// Rivals below this probability are left out of the summary.
pub(crate) const LIKELY: f64 = 0.02;
/// A parameter that moved by more than this many standard deviations is worth a line.
const MOVED: f64 = 2.0;
/// Relative change of a parameter that rounds to 0.1 %.
const VISIBLE: f64 = 5e-4;
/// Share of the range seen below which an effect acts in a part of it.
const LOCAL: f64 = 0.5;
/// Root mean square residual, in units of the noise, up to which what is left is noise: its standard
/// deviation is known to a few hundredths.
const AS_NOISE: f64 = 1.025;
/// Root mean square residual, in units of the noise that shows from sample to sample, above which a model does not
/// explain recordings down to that noise, whatever else it may be: noise of twice its variance is another.
const OVER_NOISE: f64 = 1.5;
/// Share of a mismatch below which what a formula leaves belongs to its shape: a tenth of the squares is a third
/// of the amplitude, as between laws of one family.
const NEARLY: f64 = 0.1;
/// An error that falls by less than this share has not fallen.
const FALLS: f64 = 0.05;

/// The verdict in one line, without numbers.
#[must_use]
pub fn headline(d: &Diagnosis) -> String {
    match d.verdict {
        Verdict::NoMismatch if leaves_more_than_noise(d) => {
            format!("{} explains the recordings as well as anything that was looked for", d.model)
        }
        Verdict::NoMismatch => format!("{} explains the recordings", d.model),
        Verdict::Miscalibrated => {
            format!("{} has the right physics, with wrong parameters", d.model)
        }
        Verdict::MissingPhysics if d.findings.is_empty() => {
            format!("Physics is missing from {}", d.model)
        }
        Verdict::MissingPhysics => format!("Missing from {}: {}", d.model, list(&named(d, false))),
        Verdict::SensorFault if d.findings.is_empty() => "A sensor is wrong".to_owned(),
        Verdict::SensorFault => format!("A sensor is wrong: {}", list(&named(d, false))),
        Verdict::Unexplained if d.otherwise.is_some() => {
            format!("The recordings may not be what {} reads them as", d.model)
        }
        Verdict::Unexplained if d.proof == ProofOutcome::Worse => {
            format!("{} is wrong, and what fits best failed the proof", d.model)
        }
        Verdict::Unexplained => format!("{} is wrong in a way not in the catalogue", d.model),
    }
}

/// The verdict in one sentence, with numbers.
#[must_use]
pub fn verdict(d: &Diagnosis) -> String {
    let model = &d.model;
    if let Some(otherwise) = &d.otherwise {
        return format!("{}: {}", headline(d), read_otherwise(otherwise));
    }
    let (start, link) = match d.verdict {
        Verdict::NoMismatch if leaves_more_than_noise(d) => (headline(d), ": "),
        Verdict::NoMismatch => (format!("{model} explains the recordings down to the noise"), ": "),
        Verdict::Miscalibrated => {
            let moved: Vec<String> = moved(d).map(|(name, c)| calibration(name, c)).collect();
            let which =
                if moved.is_empty() { "its parameters are not".into() } else { list(&moved) };
            (format!("The physics of {model} is right, but {which}"), "; after calibration ")
        }
        Verdict::MissingPhysics if d.findings.is_empty() => {
            (format!("Physics is missing from {model}"), ": ")
        }
        Verdict::MissingPhysics => {
            let all = named(d, true);
            let link = if all.len() > 1 { "; with them " } else { "; with it " };
            (format!("{model} lacks {}", list(&all)), link)
        }
        Verdict::SensorFault if d.findings.is_empty() => {
            ("A sensor is wrong, not the physics".to_owned(), ": ")
        }
        Verdict::SensorFault => (
            format!("A sensor is wrong, not the physics: {}", list(&named(d, true))),
            "; with it in the model ",
        ),
        Verdict::Unexplained if d.proof == ProofOutcome::Worse => (
            format!("{model} is wrong, but what fits the training recordings failed the proof"),
            "; as it was given, ",
        ),
        Verdict::Unexplained => {
            (format!("{model} is wrong in a way that the catalogue does not explain"), ": ")
        }
    };
    let said = match telling(d) {
        Some((channel, fit)) => format!("{start}{link}{}.", outcome(channel, fit)),
        None => format!("{start}; no recording was held out to prove it."),
    };
    said + &joints::left_out(d).map_or_else(String::new, |words| format!(" {words}"))
}

/// How recordings seem to be meant, and what to do.
fn read_otherwise(o: &Otherwise) -> String {
    let leaves = |error: f64| format!("{} times the noise", plain(error, ""));
    let found = o.found_leaves.map_or_else(
        || "nothing that was looked for follows them as far".to_owned(),
        |error| format!("all that was looked for leaves {}", leaves(error)),
    );
    format!(
        "with {}, it leaves {} over {}; as they are, {found}. Correct the recordings, their units or the \
         model, and diagnose again: nothing is named in the wrong numbers.",
        o.with.join(", or with "),
        leaves(o.leaves),
        plain(o.window_s, "s"),
    )
}

/// Whether an error on held-out recordings is more than the noise that shows from sample to sample.
pub(crate) fn leaves_more_than_noise(d: &Diagnosis) -> bool {
    d.fit.held_out.values().any(|f| f.noise > 0.0 && f.rmse_after > OVER_NOISE * f.noise)
}

/// The held-out channel that tells most: where the model was worst.
#[must_use]
pub fn telling(d: &Diagnosis) -> Option<(&str, &ChannelFit)> {
    by_error(d).into_iter().next()
}

/// Held-out channels, those where the model was worst, in units of the noise, first.
#[must_use]
pub fn by_error(d: &Diagnosis) -> Vec<(&str, &ChannelFit)> {
    let mut all: Vec<_> = d.fit.held_out.iter().map(|(name, f)| (name.as_str(), f)).collect();
    let badness = |f: &ChannelFit| f.rmse_before / f.noise;
    all.sort_by(|a, b| badness(b.1).total_cmp(&badness(a.1)));
    all
}

/// What became of the error of a held-out channel.
fn outcome(channel: &str, fit: &ChannelFit) -> String {
    let (before, after) = (plain(fit.rmse_before, &fit.unit), plain(fit.rmse_after, &fit.unit));
    let of = format!("the error of {channel} on held-out recordings");
    let noise = times_noise(fit).map_or(String::new(), |n| format!(", {n}"));
    if !fit.rmse_after.is_finite() {
        return format!("the simulation of {channel} on held-out recordings diverges");
    }
    if diverged(fit.rmse_before) {
        return format!("{of} is {after}{noise}, where the model as it was diverges");
    }
    if falls(fit.rmse_before, fit.rmse_after) {
        return format!(
            "{of} falls from {}{noise}",
            change(fit.rmse_before, "to", fit.rmse_after, &fit.unit)
        );
    }
    if before == after {
        return format!("{of} is {after}{noise}");
    }
    format!("{of} does not fall ({before} before, {after} after{noise})")
}

/// Whether an error becomes smaller by more than chance.
pub(crate) fn falls(before: f64, after: f64) -> bool {
    after < (1.0 - FALLS) * before
}

/// Whether an error becomes larger by more than chance.
pub(crate) fn grows(before: f64, after: f64) -> bool {
    falls(after, before)
}

/// The error after, in words, against the noise.
pub(crate) fn times_noise(fit: &ChannelFit) -> Option<String> {
    let times = fit.rmse_after / fit.noise;
    (fit.noise > 0.0 && times.is_finite()).then(|| format!("{} times the noise", ratio(times)))
}

/// Parameters that the recordings move by more than two standard deviations, and by enough to be
/// seen in the digits that are shown.
pub fn moved(d: &Diagnosis) -> impl Iterator<Item = (&str, &Calibration)> {
    let far = |c: &Calibration| {
        let change = (c.value - c.nominal).abs();
        change > MOVED * c.std && change >= VISIBLE * c.nominal.abs()
    };
    d.calibration.iter().filter(move |(_, c)| far(c)).map(|(name, c)| (name.as_str(), c))
}

/// What the recordings say of a parameter: `p1 is 3.61 ± 0.02 kg m^2 instead of 3.473 (+3.9 %)`.
#[must_use]
pub fn calibration(name: &str, c: &Calibration) -> String {
    let value = estimate(c.value, c.std, &c.unit, c.at_bound);
    format!("{name} is {value} instead of {}{}", given(c.nominal), shift(c))
}

/// Relative change of a parameter, in parentheses; nothing where the model says zero.
pub(crate) fn shift(c: &Calibration) -> String {
    let share = 100.0 * (c.value - c.nominal) / c.nominal.abs();
    if share.is_finite() { format!(" ({share:+.1} %)") } else { String::new() }
}

/// What an effect is, in words: `dry (Coulomb) friction on q`, `dry friction that grows with the load
/// on q by tau`, `a payload on link forearm`.
#[must_use]
pub fn name(finding: &Finding) -> String {
    let by_input = lacuna_effects::find(finding.named_law()).is_some_and(Effect::names_input);
    let joined = if by_input { "by" } else { "and" };
    let other = finding.other.as_ref().map_or_else(String::new, |o| format!(" {joined} {o}"));
    format!("{}{other}", class_at(finding.named_law(), &finding.channel))
}

/// The words of a class, and where it acts.
#[must_use]
pub fn class_at(class: &str, channel: &str) -> String {
    let at = lacuna_effects::find(class).map(|e| e.acts.at(channel));
    format!("{} {}", class_words(class), at.unwrap_or_else(|| format!("on {channel}")))
}

/// How well the formulas of the findings fit, whatever their names: `the formula is nearly right: it
/// leaves 3 % of the mismatch, and 1.4 times the noise with it`.
#[must_use]
pub fn formula(d: &Diagnosis) -> Option<String> {
    let FormulaFit { left, residual_over_noise } = d.formula?;
    let (the, is, it, leaves) = match d.findings.len() {
        0 | 1 => ("the formula", "is", "it", "leaves"),
        _ => ("the formulas", "are", "they", "leave"),
    };
    if residual_over_noise < AS_NOISE {
        let fits = if is == "is" { "fits" } else { "fit" };
        // A random force adds up: predictions miss by more than the noise, and nothing names it.
        let what = match d.driving.forces.is_empty() {
            true => "noise",
            false => "a random force, which predictions cannot foresee, and noise",
        };
        return Some(format!("{the} {fits}: what {it} {leaves} is {what}"));
    }
    let how = match left {
        l if l < NEARLY => "nearly right",
        l if l <= 0.5 => "not quite right",
        _ => "not right",
    };
    let (left, times) = (percent(left), ratio(residual_over_noise));
    Some(format!("{the} {is} {how}: {it} {leaves} {left} of the mismatch, {times} times the noise"))
}

/// The part of the range in which an effect acts, where that is less than half of what the
/// recordings show: `acts where q is between 0.12 and 0.55 rad`.
#[must_use]
pub fn part(f: &Finding) -> Option<String> {
    let curve = f.curve.as_ref()?;
    let [low, high] = *f.region.get(&curve.variable)?;
    let all = curve.at.last()? - curve.at.first()?;
    let (from, to) = (plain(low, ""), plain(high, &curve.variable_unit));
    (high - low < LOCAL * all)
        .then(|| format!("acts where {} is between {from} and {to}", curve.variable))
}

/// The experiment that would tell an effect from its first rival.
#[must_use]
pub fn experiment(e: &Experiment) -> String {
    format!(
        "to tell them apart: drive {} with a sine of {} at {} and watch {}; the predictions differ \
         there by {} times the noise",
        e.drive,
        plain(e.amplitude, &e.unit),
        plain(e.frequency_hz, "Hz"),
        e.watch,
        ratio(e.difference_over_noise)
    )
}

/// The words of a class; its name with spaces where the catalogue does not have it.
#[must_use]
pub fn class_words(class: &str) -> String {
    lacuna_effects::find(class).map_or_else(|| class.replace('_', " "), |e| e.words.to_owned())
}

/// A parameter: `magnitude 20.41 ± 0.12 N`.
#[must_use]
pub fn parameter(name: &str, e: &Estimate) -> String {
    format!("{} {}", name.replace('_', " "), estimate(e.value, e.std, &e.unit, e.at_bound))
}

fn named(d: &Diagnosis, sure: bool) -> Vec<String> {
    let words = |(what, probability): (String, String)| match sure {
        true => format!("{what} ({probability} sure)"),
        false => what,
    };
    told(d).into_iter().map(words).collect()
}

/// The findings and how sure they are; those of one kind on several joints of a robot as one.
pub(crate) fn told(d: &Diagnosis) -> Vec<(String, String)> {
    let several: Vec<Kind> = joints::kinds(d).into_iter().filter(Kind::is_on_several).collect();
    let one = |f: &Finding| {
        let Some(kind) = several.iter().find(|k| k.findings().any(|other| other == f)) else {
            return (name(f), percent(f.probability));
        };
        let least = kind.findings().map(|f| f.probability).fold(1.0, f64::min);
        (kind.name(), format!("at least {}", percent(least)))
    };
    let mut told: Vec<(String, String)> = vec![];
    for words in d.findings.iter().map(one) {
        if !told.contains(&words) {
            told.push(words);
        }
    }
    told
}

/// `a`, `a and b`, `a, b and c`.
pub(crate) fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
