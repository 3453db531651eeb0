//! The terminal summary says all that matters in lines that fit.

use crate::cases::{missing, null, two_findings, unexplained};
use lacuna_discrepancy::conventions::Otherwise;
use lacuna_discrepancy::diagnosis::{Experiment, FormulaFit, RandomForce, Verdict};
use lacuna_report::summary;

#[test]
fn a_finding_is_told_with_its_numbers() {
    let text = summary(&missing(), false);
    let first = text.lines().next().unwrap();
    assert!(first.starts_with("emps lacks dry (Coulomb) friction on q (97 % sure); with it"));
    for words in [
        "falls from 4.31e-3 to 2.34e-5 m, 1.1 times the noise",
        "dry (Coulomb) friction on q: magnitude",
        "magnitude 20.41 ± 0.12 N",
        "smoothing velocity 0.00412 ± 0.00031 m/s",
        "probability 97 %",
        "or friction with a Stribeck peak at low speed on q 3 %",
        "The formula is nearly right: it leaves 3 % of the mismatch, 1.4 times the noise.",
        "viscous is 214.2 ± 1.9 N s/m instead of 203.5 (+5.3 %)",
        "0.0873 -> 0.000412 m running free; noise 2.10e-5 m",
        "Note: Stribeck friction cannot be excluded",
    ] {
        let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(joined.contains(words), "{words} in\n{text}");
    }
    assert!(!text.contains("cogging"), "a rival below 2 % is left out");
    assert!(!text.contains("mass is"), "a parameter within 2 std is left out");
}

#[test]
fn a_large_ratio_has_no_more_digits_than_it_needs() {
    let mut d = missing();
    d.findings[0].experiment = Some(Experiment {
        drive: "F".to_owned(),
        unit: "N".to_owned(),
        amplitude: 3.0,
        frequency_hz: 0.5,
        watch: "q".to_owned(),
        difference_over_noise: 4_658_774.8,
    });
    let text = summary(&d, false).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("the predictions differ there by 4.66e6 times the noise"), "{text}");
}

/// How sure the class is and how well its formula fits are two things.
#[test]
fn what_a_formula_leaves_is_told_beside_the_probability_of_its_class() {
    let told = |left, residual_over_noise| {
        let mut d = missing();
        d.formula = Some(FormulaFit { left, residual_over_noise });
        summary(&d, false).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for text in [told(0.0, 1.01), told(0.3, 2.0), told(0.8, 40.0)] {
        assert!(text.contains("probability 97 %"), "{text}");
    }
    assert!(told(0.004, 1.01).contains("The formula fits: what it leaves is noise."));
    let mut driven = missing();
    driven.formula = Some(FormulaFit { left: 0.004, residual_over_noise: 1.01 });
    let force = RandomForce { intensity: 3.0, share: 0.1, unit: "N m s^0.5".to_owned() };
    driven.driving.forces.insert("q".to_owned(), force);
    let words = summary(&driven, false).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("what it leaves is a random force"), "{words}");
    assert!(told(0.3, 2.0).contains("The formula is not quite right: it leaves 30 %"));
    assert!(told(0.8, 40.0).contains("The formula is not right: it leaves 80 %"));
    let two = summary(&two_findings(), false);
    assert!(two.contains("The formulas are nearly right: they leave 3 %"), "{two}");
    assert!(!summary(&null(), false).contains("formula"));
}

#[test]
fn recordings_that_may_be_read_otherwise_are_told_before_anything_else() {
    let mut d = unexplained();
    let with = ["the sign of tau reversed", "the sign of q reversed"].map(str::to_owned).to_vec();
    d.otherwise = Some(Otherwise { with, leaves: 1.2, found_leaves: Some(65.4), window_s: 3.75 });
    let told = |d: &_| summary(d, false).split_whitespace().collect::<Vec<_>>().join(" ");
    let text = told(&d);
    assert!(
        text.starts_with(&format!("The recordings may not be what {} reads them as", d.model)),
        "{text}"
    );
    for words in [
        "with the sign of tau reversed, or with the sign of q reversed, it leaves 1.20 times the noise over 3.75 s",
        "as they are, all that was looked for leaves 65.4 times the noise",
    ] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    d.otherwise.as_mut().unwrap().found_leaves = None;
    assert!(told(&d).contains("nothing that was looked for follows them as far"));
}

#[test]
fn an_effect_that_acts_in_a_part_of_the_range_is_told_with_it() {
    let mut d = missing();
    let curve = d.findings[0].curve.clone().unwrap();
    let (first, last) = (curve.at[0], curve.at[curve.at.len() - 1]);
    let told = |d| summary(&d, false).split_whitespace().collect::<Vec<_>>().join(" ");
    let part = [first + 0.5 * (last - first), last - 0.25 * (last - first)];
    d.findings[0].region = [(curve.variable.clone(), part)].into();
    let words = format!("acts where {} is between", curve.variable);
    assert!(told(d.clone()).contains(&words), "{}", told(d));
    d.findings[0].region = [(curve.variable.clone(), [first, last])].into();
    assert!(!told(d.clone()).contains(&words), "{}", told(d));
}

#[test]
fn every_verdict_has_a_true_sentence() {
    let starts = |d| summary(&d, false).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        starts(null()).starts_with("emps explains the recordings down to the noise: the error")
    );
    let mut far = null();
    far.fit.held_out.values_mut().for_each(|f| f.rmse_after = 8.0 * f.noise);
    let far = starts(far);
    assert!(
        far.starts_with("emps explains the recordings as well as anything that was looked for:"),
        "{far}"
    );
    assert!(far.contains("8.0 times the noise") && !far.contains("down to the noise"), "{far}");
    let wrong = starts(unexplained());
    assert!(wrong.contains("is wrong in a way that the catalogue does not explain"), "{wrong}");
    let mut d = missing();
    d.findings.clear();
    d.verdict = Verdict::Miscalibrated;
    let text = starts(d.clone());
    assert!(text.starts_with("The physics of emps is right, but viscous is 214.2 ± 1.9 N s/m"));
    d.fit.held_out.clear();
    assert!(starts(d).contains("no recording was held out to prove it"));
}

#[test]
fn an_error_that_grows_is_admitted() {
    let mut d = missing();
    let fit = d.fit.held_out.get_mut("q").unwrap();
    fit.rmse_after = 2.0 * fit.rmse_before;
    let text = summary(&d, false).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains("does not fall") && text.contains("(worse than before)"), "{text}");
}

#[test]
fn lines_fit_the_terminal_and_stay_few() {
    for d in [missing(), two_findings(), null(), unexplained()] {
        let text = summary(&d, false);
        assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
        assert!(text.lines().count() <= 13, "{text}");
        assert!(!text.contains('\u{1b}'));
    }
}

#[test]
fn colour_only_when_asked_and_names_cannot_bring_their_own() {
    let mut d = missing();
    d.findings[0].says = "\u{1b}[31mred".into();
    assert!(!summary(&d, false).contains('\u{1b}'));
    let coloured = summary(&d, true);
    assert!(coloured.starts_with("\u{1b}[1;33memps lacks"));
    assert_eq!(coloured.matches("\u{1b}[").count(), 2 * coloured.matches("\u{1b}[0m").count());
}
