//! What the page of a fleet shows.

use super::collected::{Collected, Diagnosed, row};
use super::quantities::{Quantity, Value};
use crate::charts::{Axis, Band, Colour, Figure, Line, Style};
use crate::discrepancy::diagnosis::{Estimate, Finding, Verdict};
use crate::effects::find;
use crate::report::number::{estimate, percent};
use crate::report::{FleetPage, FleetRow, FleetTable, class_at};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Quantities that are drawn at most: those in which machines are unlike the others first.
const DRAWN: usize = 40;
/// Standard deviations that bands and bars reach.
const REACH: f64 = 2.0;

pub(super) fn page(fleet: &Collected, linked: bool) -> FleetPage {
    let compared: Vec<&Quantity> = fleet.quantities.iter().filter(|q| q.mean.is_some()).collect();
    let mut drawn = compared.clone();
    drawn.sort_by(|a, b| least(a).total_cmp(&least(b)));
    let left = drawn.len().saturating_sub(DRAWN);
    drawn.truncate(DRAWN);
    FleetPage {
        model: fleet.model().to_owned(),
        says: vec![format!("{}.", fleet.headline()), format!("{}.", fleet.verdicts())],
        unlike: unlike(fleet, linked),
        machines: machines(fleet, linked),
        spread: FleetTable {
            head: ["What", "Found in", "Typical", "Spread from machine to machine"]
                .map(str::to_owned)
                .into(),
            rows: compared.iter().map(|q| FleetRow::of(row(q))).collect(),
        },
        figures: drawn.into_iter().map(|q| figure(fleet, q)).collect(),
        undrawn: left,
        failed: FleetTable {
            head: ["Machine", "Why"].map(str::to_owned).into(),
            rows: fleet
                .failed
                .iter()
                .map(|f| FleetRow::of(vec![f.name.clone(), f.error.clone()]))
                .collect(),
        },
    }
}

fn least(q: &Quantity) -> f64 {
    q.values.iter().filter_map(|v| v.p).fold(1.0, f64::min)
}

fn unlike(fleet: &Collected, linked: bool) -> FleetTable {
    let row = |u: &super::Unlike| {
        let because: Vec<&str> = u.because.iter().map(|r| &*r.says).collect();
        let cells = vec![u.machine.clone(), because.join("; "), probability(u.p)];
        FleetRow { link: linked.then(|| link(&u.machine)), cells }
    };
    FleetTable {
        head: ["Machine", "Why it is unlike the others", "Chance of that in a typical machine"]
            .map(str::to_owned)
            .into(),
        rows: fleet.unlike.iter().map(row).collect(),
    }
}

fn probability(p: f64) -> String {
    if p < 1e-9 {
        "below 1e-9".to_owned()
    } else if p < 1e-3 {
        format!("{p:.0e}")
    } else {
        percent(p)
    }
}

/// What each machine lacks: a column for every effect on every channel.
fn machines(fleet: &Collected, linked: bool) -> FleetTable {
    let mut columns: BTreeMap<String, usize> = BTreeMap::new();
    for f in fleet.machines.iter().flat_map(|m| &m.diagnosis.findings) {
        *columns.entry(key(f)).or_default() += 1;
    }
    // What most machines lack stands first.
    let mut columns: Vec<(String, usize)> = columns.into_iter().collect();
    columns.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
    let mut head = vec!["Machine".to_owned(), "Verdict".to_owned()];
    head.extend(columns.iter().map(|c| c.0.clone()));
    let row = |m: &Diagnosed| {
        let mut cells = vec![m.name.clone(), word(m.diagnosis.verdict).to_owned()];
        cells.extend(columns.iter().map(|(column, _)| {
            let here = m.diagnosis.findings.iter().filter(|f| key(f) == *column);
            let told: Vec<String> = here.map(numbers).collect();
            if told.is_empty() { "-".to_owned() } else { told.join("; ") }
        }));
        FleetRow { link: linked.then(|| link(&m.name)), cells }
    };
    FleetTable { head, rows: fleet.machines.iter().map(row).collect() }
}

fn key(f: &Finding) -> String {
    let other = f.other.as_ref().map_or_else(String::new, |o| format!(" and {o}"));
    format!("{}{other}", class_at(&f.class, &f.channel))
}

/// The physical numbers of a finding.
fn numbers(f: &Finding) -> String {
    let law = find(f.named_law());
    let physical =
        |name: &str| law.is_none_or(|e| e.parameters.iter().any(|p| p.name == name && p.physical));
    let one = |(name, e): (&String, &Estimate)| {
        format!("{} {}", name.replace('_', " "), estimate(e.value, e.std, &e.unit, e.at_bound))
    };
    let all: Vec<String> = f.parameters.iter().filter(|p| physical(p.0)).map(one).collect();
    format!("{} ({} sure)", all.join(", "), percent(f.probability))
}

/// A verdict in a word or two: what is missing stands beside it.
fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoMismatch => "no mismatch",
        Verdict::Miscalibrated => "miscalibrated",
        Verdict::MissingPhysics => "lacks physics",
        Verdict::SensorFault => "a sensor is wrong",
        Verdict::Unexplained => "unexplained",
    }
}

/// The page of a machine, relative to that of the fleet.
fn link(machine: &str) -> String {
    let mut out = String::new();
    for byte in machine.bytes() {
        match byte {
            b if b.is_ascii_alphanumeric() || b"-_.".contains(&b) => out.push(char::from(b)),
            b => drop(write!(out, "%{b:02X}")),
        }
    }
    format!("{out}/report.html")
}

/// The values of all machines in their order, with two standard deviations, over what is typical.
fn figure(fleet: &Collected, q: &Quantity) -> Figure {
    let mut sorted: Vec<&Value> = q.values.iter().collect();
    sorted.sort_by(|a, b| a.value.total_cmp(&b.value).then(a.machine.cmp(&b.machine)));
    let reasons =
        fleet.unlike.iter().flat_map(|u| u.because.iter().map(move |r| (&u.machine, &r.quantity)));
    let reasons: Vec<_> = reasons.collect();
    let is_unlike = |v: &Value| reasons.contains(&(&v.machine, &q.name));
    let at = |k: usize| (k + 1) as f64;
    let points = |chosen: &dyn Fn(&Value) -> bool| -> Vec<(f64, f64)> {
        let all = sorted.iter().enumerate().filter(|(_, v)| chosen(v));
        all.map(|(k, v)| (at(k), v.value)).collect()
    };
    let bar = |(k, v): (usize, &&Value)| {
        let end = |side: f64| (at(k), v.value + side * REACH * v.std);
        [end(-1.0), end(1.0), (f64::NAN, f64::NAN)]
    };
    let found = sorted.iter().enumerate().filter(|(_, v)| v.found);
    let lines = [
        ("two standard deviations", Colour::Ink, Style::Thin, found.flat_map(bar).collect()),
        ("found", Colour::Blue, Style::Dots, points(&|v| v.found && !is_unlike(v))),
        ("not found", Colour::Ink, Style::Rings, points(&|v| !v.found && !is_unlike(v))),
        ("unlike the others", Colour::Vermilion, Style::Dots, points(&is_unlike)),
    ];
    let lines = lines.into_iter().filter(|line| !line.3.is_empty());
    let (mean, spread) = (q.mean.unwrap_or(0.0), REACH * q.spread.unwrap_or(0.0));
    let told = row(q);
    let ends = [0.5, sorted.len() as f64 + 0.5];
    Figure {
        description: format!("{}: typical {}, spread {}", told[0], told[2], told[3]),
        bands: vec![Band {
            label: "typical".to_owned(),
            colour: Colour::Green,
            edges: ends.map(|x| (x, mean - spread, mean + spread)).to_vec(),
        }],
        lines: lines
            .map(|(label, colour, style, points)| Line::new(label, colour, style, points))
            .collect(),
        ..Figure::new(
            Axis::linear("machines, in the order of their values", ""),
            Axis::linear(&q.name, &q.unit),
        )
    }
}
