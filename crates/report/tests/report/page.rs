//! The page holds every number, is well formed, stands alone and stays small.

use crate::cases::{missing, null, proof, two_findings, unexplained};
use lacuna_discrepancy::Diagnosis;
use lacuna_report::number::{percent, with_std};
use lacuna_report::{Proof, page};

const MODEL: &str = "name = \"emps\"\n[[effect]]\nclass = \"coulomb_friction\" # < & >\n";

fn cases() -> Vec<(&'static str, Diagnosis, Vec<Proof>)> {
    let two = ["q1", "q2", "dq1", "dq2"].map(|c| proof("held_1.csv", c, 4_000)).to_vec();
    let mut away = proof("run <b>7</b>.csv", "q<2>", 500);
    away.before.iter_mut().enumerate().for_each(|(k, v)| *v *= (0.02 * k as f64).exp());
    let mut right = proof("trajectory.csv", "q", 2_000);
    right.before.clone_from(&right.after);
    vec![
        ("missing", missing(), vec![proof("trajectory.csv", "q", 24_000)]),
        ("two_findings", two_findings(), two),
        ("null", null(), vec![right]),
        ("unexplained", unexplained(), vec![away]),
    ]
}

/// Write each page into the test's folder, to be looked at, and give it to a check.
fn each(check: impl Fn(&str, &Diagnosis, &str)) {
    for (name, d, series) in cases() {
        let html = page(&d, MODEL, &series);
        let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.html"));
        std::fs::write(file, &html).unwrap();
        check(name, &d, &html);
    }
}

#[test]
fn every_finding_is_there_with_its_numbers() {
    each(|name, d, html| {
        for f in &d.findings {
            assert!(html.contains(&format!("<code>{}</code>", f.class)), "{name}");
            let law = lacuna_effects::find(&f.class).unwrap().formula;
            assert!(html.contains(&law.replace('<', "&lt;")), "{name}: {law}");
            assert!(html.contains(&percent(f.probability)), "{name}");
            for (parameter, e) in &f.parameters {
                let number = with_std(e.value, e.std, &e.unit);
                assert!(html.contains(&number), "{name}: {parameter} {number}");
            }
        }
        for (parameter, c) in &d.calibration {
            assert!(html.contains(&with_std(c.value, c.std, &c.unit)), "{name}: {parameter}");
        }
        for note in &d.notes {
            assert!(html.contains(note.as_str()), "{name}: {note}");
        }
        assert!(html.contains("class = &quot;coulomb_friction&quot; # &lt; &amp; &gt;"));
    });
}

#[test]
fn tags_are_balanced() {
    each(|name, _, html| assert_eq!(unbalanced(html), None, "{name}"));
    assert_eq!(unbalanced("<p><b></p></b>"), Some("p closes b".into()));
    assert_eq!(unbalanced("<p><br>"), Some("p is not closed".into()));
}

#[test]
fn it_needs_nothing_from_elsewhere() {
    each(|name, _, html| {
        for from in ["src=", "<script", "<link", "url(", "@import", "<iframe", "href=\"h"] {
            assert!(!html.contains(from), "{name}: {from}");
        }
    });
}

#[test]
fn every_figure_has_words_and_every_link_a_target() {
    each(|name, _, html| {
        let figures = html.matches("<svg ").count();
        assert!(figures > 0, "{name}");
        assert_eq!(html.matches("role=\"img\" aria-label=\"").count(), figures, "{name}");
        for link in html.split("href=\"#").skip(1) {
            let id = link.split('"').next().unwrap();
            assert!(html.contains(&format!("id=\"{id}\"")), "{name}: {id}");
        }
    });
}

#[test]
fn names_are_escaped() {
    each(|name, d, html| {
        assert!(!html.contains("<script>") && !html.contains("<b>"), "{name}");
        if name == "unexplained" {
            assert!(html.contains("arm &lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;sons"));
            assert!(html.contains("q&lt;2&gt;"), "{}", d.model);
        }
    });
}

#[test]
fn long_and_many_series_stay_below_three_megabytes() {
    let html = page(&missing(), MODEL, &[proof("long.csv", "q", 100_000)]);
    assert!(html.len() < 200_000, "{}", html.len());
    let many: Vec<Proof> = (0..80).map(|k| proof(&format!("{k}.csv"), "q", 100_000)).collect();
    let html = page(&missing(), MODEL, &many);
    assert!(html.len() < 3_000_000, "{}", html.len());
    assert!(html.contains("20 more series are not drawn"));
}

#[test]
fn series_of_unequal_or_no_length_do_not_stop_the_page() {
    let mut short = proof("short.csv", "q", 50);
    short.before.truncate(3);
    short.after.clear();
    let html = page(&missing(), MODEL, &[short, Proof::default()]);
    assert!(html.contains("No figure: a figure needs at least one finite point"));
    assert_eq!(unbalanced(&html), None);
}

/// The first element that is closed out of order or not at all.
fn unbalanced(html: &str) -> Option<String> {
    let mut open: Vec<&str> = Vec::new();
    for tag in html.split('<').skip(1).map(|t| t.split('>').next().unwrap_or("")) {
        let name = tag.trim_start_matches('/').split_whitespace().next().unwrap_or("");
        let void = ["!DOCTYPE", "meta", "br"].contains(&name) || tag.ends_with('/');
        match tag.starts_with('/') {
            _ if void => {}
            false => open.push(name),
            true => match open.pop() {
                Some(last) if last == name => {}
                last => return Some(format!("{name} closes {}", last.unwrap_or("nothing"))),
            },
        }
    }
    open.pop().map(|name| format!("{name} is not closed"))
}
