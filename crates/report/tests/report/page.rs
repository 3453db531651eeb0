//! The page holds every number, is well formed, stands alone and stays small.

use crate::cases::{HOSTILE, missing, null, proof, robot, two_findings, unexplained};
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::conventions::Otherwise;
use lacuna_discrepancy::diagnosis::{Finding, Joint};
use lacuna_report::number::{percent, with_std};
use lacuna_report::{Proof, files, page};

const COMMAND: &str = "lacuna diagnose model.toml 'run <1>.csv' --out found";

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
        ("robot", robot(), vec![proof("held_1.csv", "elbow", 4_000)]),
        ("null", null(), vec![right]),
        ("unexplained", unexplained(), vec![away, proof("run.csv", HOSTILE, 600)]),
    ]
}

/// Write each page into the test's folder, to be looked at, and give it to a check.
fn each(check: impl Fn(&str, &Diagnosis, &str)) {
    for (name, d, series) in cases() {
        let html = page(&d, MODEL, &series, COMMAND);
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

/// A robot has many joints: what is missing stands in one table, and their friction side by side.
#[test]
fn findings_of_a_robot_are_told_by_joint() {
    let html = page(&robot(), MODEL, &[], COMMAND);
    for part in [
        "Missing from arm: dry friction on both joints and a payload on link lower",
        "The URDF has no friction on either of its two joints.",
        "<th scope=\"col\">Joint</th><th scope=\"col\">dry friction</th><th scope=\"col\">a payload</th>",
        "<th scope=\"row\">elbow</th>",
        "coulomb 0.350 ± 0.010 N m, static 0.500 ± 0.020 N m",
        "<td data-label=\"a payload\">0.300 ± 0.010 kg (99.0 %)</td>",
        "Friction of the joints",
        "<figcaption>elbow: friction with a Stribeck peak at low speed</figcaption>",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let pictures = files(&robot(), &[]);
    assert_eq!(pictures.iter().filter(|f| f.name.contains("-friction-")).count(), 2);
    // One joint is no table, and a file that has friction is not said to have none.
    let mut one = robot();
    one.findings.truncate(1);
    let joints = &mut one.robot.as_mut().expect("a robot").joints;
    joints.iter_mut().for_each(|j| j.friction = 0.1);
    let html = page(&one, MODEL, &[], COMMAND);
    assert!(!html.contains("by joint") && !html.contains("has no friction"));
}

/// Twenty findings are a sentence where those of one kind are told together.
#[test]
fn findings_of_one_kind_are_told_together() {
    let mut d = robot();
    let robot = d.robot.as_mut().expect("a robot");
    for name in ["forearm", "wrist"] {
        let joint = Joint { name: name.into(), input: name.into(), ..robot.joints[0].clone() };
        robot.joints.push(Joint { velocity: format!("{name}_vel"), link: name.into(), ..joint });
    }
    let html = page(&d, MODEL, &[], COMMAND);
    for part in [
        "Missing from arm: dry friction on shoulder and elbow and a payload on link lower",
        "arm lacks dry friction on shoulder and elbow (at least 88 % sure)",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let forearm = Finding { channel: "forearm".into(), ..d.findings[0].clone() };
    d.findings.push(forearm);
    let part = "Missing from arm: dry friction on all joints but wrist and a payload on link lower";
    assert!(page(&d, MODEL, &[], COMMAND).contains(part));
}

#[test]
fn a_variation_of_a_class_has_its_own_words_and_formula() {
    let mut d = missing();
    d.findings[0].class = "hidden_resonance".into();
    d.findings[0].law = Some("elastic_drive".into());
    let html = page(&d, MODEL, &[proof("trajectory.csv", "q", 400)], COMMAND);
    let [own, class] =
        ["elastic_drive", "hidden_resonance"].map(|c| lacuna_effects::find(c).unwrap());
    assert!(html.contains(own.formula));
    assert!(html.contains(&format!("{} on q", own.words)));
    assert!(!html.contains(&format!("{} on q", class.words)));
}

#[test]
fn what_may_be_a_mistake_in_the_recordings_is_no_missing_force_that_is_sure() {
    let mut d = unexplained();
    let html = |d: &Diagnosis| page(d, MODEL, &[], COMMAND);
    assert!(html(&d).contains("that something is missing"));
    let with = vec!["the sign of tau reversed".to_owned()];
    d.otherwise = Some(Otherwise { with, leaves: 1.2, found_leaves: None, window_s: 3.75 });
    let html = html(&d);
    assert!(html.contains("The recordings may not be what"));
    assert!(!html.contains("that something is missing") && html.contains("Still unexplained"));
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
        for from in ["<script ", "<link", "url(h", "@import", "<iframe", "<img", "href=\"h"] {
            assert!(!html.contains(from), "{name}: {from}");
        }
        // One script, in the page, that makes no markup of text and asks for nothing.
        assert_eq!(html.matches("<script>").count(), 1, "{name}");
        assert_eq!(html.matches("</script>").count(), 1, "{name}");
        for call in ["innerHTML", "outerHTML", "insertAdjacentHTML", "eval(", "fetch(", "import("] {
            assert!(!html.contains(call), "{name}: {call}");
        }
        assert!(html.contains("content=\"default-src 'none'; "), "{name}");
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
        assert!(!html.contains("<script>alert") && !html.contains("<b>"), "{name}");
        assert!(!html.contains("<img") && !html.contains("onerror=\""), "{name}");
        if name == "unexplained" {
            assert!(html.contains("arm &lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;sons"));
            assert!(html.contains("q&lt;2&gt;"), "{}", d.model);
            let escaped = "&lt;img src=x onerror=&quot;alert(1)&quot;&gt;";
            assert!(html.contains(&format!("data-channel=\"{escaped}\"")));
            assert!(html.contains(&format!("{escaped} - model (m)")));
            assert!(html.contains(&format!("in the equation of {escaped}")));
        }
    });
}

#[test]
fn long_and_many_series_stay_below_three_megabytes() {
    let html = page(&missing(), MODEL, &[proof("long.csv", "q", 100_000)], COMMAND);
    assert!(html.len() < 200_000, "{}", html.len());
    // Jumps over the whole range take the most digits.
    let wild = |k: usize| {
        let mut p = proof(&format!("{k}.csv"), "q", 100_000);
        let jump = |k: usize| ((k * 7919) % 1009) as f64 / 1009.0 - 0.5;
        p.measured = (0..p.time.len()).map(jump).collect();
        p.before = (0..p.time.len()).map(|k| jump(k * k)).collect();
        p.after = (0..p.time.len()).map(|k| jump(3 * k + 1)).collect();
        p
    };
    let many: Vec<Proof> = (0..80).map(wild).collect();
    let html = page(&missing(), MODEL, &many, COMMAND);
    assert!(html.len() < 3_000_000, "{}", html.len());
    assert!(html.contains("20 more series are not drawn"));
}

#[test]
fn series_of_unequal_or_no_length_do_not_stop_the_page() {
    let mut short = proof("short.csv", "q", 50);
    short.before.truncate(3);
    short.after.clear();
    let html = page(&missing(), MODEL, &[short, Proof::default()], COMMAND);
    assert!(
        !html.contains("No figure") && !html.contains("finite point"),
        "what is empty is left out"
    );
    assert!(html.matches("<figure").count() > 3, "and nothing else");
    assert_eq!(unbalanced(&html), None);
}

#[test]
fn each_series_has_its_run_residuals_and_autocorrelation() {
    let series = [proof("a.csv", "q", 4_000), proof("b.csv", "q", 4_000)];
    let html = page(&missing(), MODEL, &series, COMMAND);
    for (words, times) in [
        ("<article class=\"series\"", 2),
        ("Residuals: measured minus model", 2),
        ("± 2 std noise\n</text>", 2),
        ("Autocorrelation of the residuals<", 2),
        ("95 % white noise\n</text>", 2),
        ("data-label=\"model before\"", 2),
    ] {
        assert_eq!(html.matches(words).count(), times, "{words}");
    }
    // 100 lags of 24 s / 4000, each two of them: up to the twentieth part of the series.
    assert!(html.contains("up to a lag of 1.20 s"), "lags");
}

#[test]
fn curves_can_be_read_back_from_the_paths() {
    let html = page(&missing(), MODEL, &[], COMMAND);
    let figure = html.split("data-x=\"dq (m/s)\"").next().unwrap();
    let frame = figure.rsplit("data-frame=\"").next().unwrap().split('"').next().unwrap();
    let frame: Vec<f64> = frame.split(' ').map(|n| n.parse().unwrap()).collect();
    let path = html.split("data-label=\"named law\"").nth(1).unwrap();
    let d = path.split(" d=\"M").nth(1).unwrap().split('"').next().unwrap();
    let start = d.split('l').next().unwrap().replace('-', " -");
    let start: Vec<f64> = start.split_whitespace().map(|n| n.parse().unwrap()).collect();
    let [left, top, right, bottom, x0, x1, y0, y1] = frame[..] else { panic!("{frame:?}") };
    let x = x0 + start[0] / (10.0 * (right - left)) * (x1 - x0);
    let y = y1 - start[1] / (10.0 * (bottom - top)) * (y1 - y0);
    // A ten-thousandth of the range, about.
    assert!((x + 0.15).abs() < 1e-4, "{x}");
    assert!((y - 20.41).abs() < 0.02, "{y}");
}

#[test]
fn the_missing_force_is_drawn_named_or_not() {
    each(|name, d, html| {
        let drawn = html.matches("learned, no formula\n</text>").count();
        let named = html.matches("named law\n</text>").count();
        let expected = match name {
            // The law over velocity, and over time what was learned before.
            "missing" => (2, 1),
            "two_findings" => (1, 1),
            // Each where it is, and side by side.
            "robot" => (4, 4),
            "null" => (0, 0),
            _ => (2 * d.location.channels.len(), 0),
        };
        assert_eq!((drawn, named), expected, "{name}");
    });
    let html = page(&unexplained(), MODEL, &[], COMMAND);
    assert!(html.contains("that something is missing, most of it in the equation of q2"));
    assert!(html.contains("before anything is added, over dq"));
    assert_eq!(unbalanced(&html), None);
}

#[test]
fn it_tells_how_to_repeat_it_and_what_was_left_out() {
    each(|name, _, html| {
        assert!(
            html.contains("lacuna diagnose model.toml 'run &lt;1&gt;.csv' --out found"),
            "{name}"
        );
        assert!(html.contains("a diagnosis draws no random numbers"), "{name}");
        assert!(html.contains("12 rows that are missing in the recordings"), "{name}");
        assert!(html.contains("; outliers: 3 of q; the states"), "{name}");
        assert!(html.contains("the states current, which no recording measures"), "{name}");
    });
}

#[test]
fn the_errors_are_shown_against_the_noise() {
    each(|name, d, html| {
        assert_eq!(html.matches("1 = the noise floor").count(), 1, "{name}");
        assert!(!d.fit.held_out.is_empty());
    });
    // 4.31e-3 m and 2.34e-5 m over a noise of 2.1e-5 m.
    let html = page(&missing(), MODEL, &[], COMMAND);
    assert!(html.contains("210× → 1.1×"));
    // And 2.3e-5 m on the recordings that were fitted.
    assert!(html.contains("the error there is at most 1.1 times the noise, in q."));
    let mut blind = missing();
    blind.fit.held_out.clear();
    assert!(!page(&blind, MODEL, &[], COMMAND).contains("noise floor"));
}

#[test]
fn pictures_are_files_that_stand_alone() {
    for (name, d, series) in cases() {
        let written = files(&d, &series);
        let html = page(&d, MODEL, &series, COMMAND);
        assert_eq!(written.len(), html.matches("<svg ").count(), "{name}");
        for (k, f) in written.iter().enumerate() {
            assert!(f.name.starts_with(&format!("{:02}-", k + 1)), "{}", f.name);
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
            assert!(f.name.chars().all(plain) && f.name.ends_with(".svg"), "{}", f.name);
            assert!(f.svg.contains("xmlns=\"http://www.w3.org/2000/svg\""), "{}", f.name);
            assert!(f.svg.contains("class=\"ground\""), "{}", f.name);
            assert!(!f.svg.contains("<img") && unbalanced(&f.svg).is_none(), "{}", f.name);
        }
    }
}

/// The first element that is closed out of order or not at all.
fn unbalanced(html: &str) -> Option<String> {
    let mut open: Vec<&str> = Vec::new();
    let (start, rest) = html.split_once("<script>").unwrap_or((html, ""));
    let end = rest.split_once("</script>").map_or("", |(_, end)| end);
    let tags = [start, end].into_iter().flat_map(|part| part.split('<').skip(1));
    for tag in tags.map(|t| t.split('>').next().unwrap_or("")) {
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
