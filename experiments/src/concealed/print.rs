//! The results in words.

use super::deviations::Coverage;
use super::proportion::Proportion;
use super::reliability::Reliability;
use super::row::Row;
use super::sealed::Name;
use super::study::Results;
use super::summary::{Names, Summary};

/// One line of a case.
pub fn row(row: &Row) {
    let names = |names: &[Name]| match names {
        [] => "nothing".to_owned(),
        names => {
            let words: Vec<_> =
                names.iter().map(|n| format!("{}@{}", n.class, n.channel)).collect();
            words.join(", ")
        }
    };
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    println!(
        "{} {:<16} verdict {} named {}/{} false {} {:6.1} s  error/noise {:>8} -> {:>6}  {} found: {}{}",
        row.case,
        row.plant,
        if row.score.verdict_right { "ok" } else { "NO" },
        row.score.named,
        row.score.effects,
        row.score.false_findings,
        row.seconds,
        number(row.before_over_noise),
        number(row.after_over_noise),
        if row.truth.is_empty() { row.topic.clone() } else { names(&row.truth) },
        row.crash.clone().map_or_else(|| names(&row.findings), |c| format!("no answer: {c}")),
        if row.f1.is_empty() { String::new() } else { format!("; F1 {:.2?}", row.f1) },
    );
}

/// The tables.
pub fn results(results: &Results) {
    println!("\n{} cases, seeds {:?}, {}", results.cases, results.seeds, results.tool);
    println!("counts with Wilson's 95 % interval\n");
    let order = ["catalogue", "off-formula", "local", "null", "machines", "all"];
    for name in order {
        if let Some(summary) = results.groups.get(name) {
            group(name, summary);
        }
    }
    reliability("findings by the probability that they claim", &results.reliability);
}

/// The table of reliability.
pub fn reliability(what: &str, r: &Reliability) {
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.3}"));
    println!(
        "{what}: {}, expected calibration error {}, Brier score {}",
        r.findings,
        number(r.calibration_error),
        number(r.brier)
    );
    for bin in r.bins.iter().filter(|b| b.right.of > 0) {
        let claimed = number(bin.claimed);
        println!("  {:.2} to {:.2}: claimed {claimed}, right {}", bin.from, bin.to, bin.right);
    }
}

fn group(name: &str, s: &Summary) {
    println!("{name}: {} cases", s.cases);
    println!("  {:<22} {:<24} peers (discrepancy SINDy)", "", "lacuna");
    let line = |what: &str, ours: String, theirs: Option<String>| {
        println!("  {what:<22} {ours:<24} {}", theirs.unwrap_or_default());
    };
    let both = |what: &str, f: &dyn Fn(&Names) -> String| {
        line(what, f(&s.names), Some(f(&s.peer)));
    };
    both("named", &|n| n.named.to_string());
    both("named in the top two", &|n| n.named_top2.to_string());
    both("right channel", &|n| n.channel.to_string());
    both("false findings", &|n| n.false_findings.to_string());
    both("null with findings", &|n| n.null_with_findings.to_string());
    let alone = |what: &str, p: &Proportion| line(what, p.to_string(), None);
    alone("right verdict", &s.verdicts);
    alone("exactly right", &s.exactly_right);
    let number = |x: Option<f64>| x.map_or("-".to_owned(), |x| format!("{x:.2}"));
    let errors = format!("{} -> {}", number(s.before_over_noise), number(s.after_over_noise));
    line("error/noise, median", errors, None);
    alone("after within 1.2", &s.after_within_1_2);
    line("made worse", s.made_worse.to_string(), None);
    if let Some((f1, count)) = s.localisation_f1 {
        line("localisation F1", format!("{f1:.2} ({count} effects)"), None);
    }
    if let Some(Coverage { findings, parameters }) = &s.coverage {
        alone("numbers within 2 sd", findings);
        alone("parameters within 2 sd", parameters);
    }
    let [median, worst] = s.seconds;
    line("seconds", format!("{median:.1} median, {worst:.1} worst"), None);
    line("no answer", s.crashes.to_string(), Some(s.peer_failed.to_string()));
}
