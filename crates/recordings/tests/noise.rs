//! The noise estimate against the true noise of the blind cases.

mod shared;

use lacuna_recordings::{Recording, RecordingSource, estimate_noise_pooled};

/// Relative errors of the estimated noise of every measured coordinate of every case.
///
/// Quantised coordinates carry no other noise, and their "noise_sd" is half the quantum:
/// there the quantum is compared, and the noise with that of rounding, q / sqrt(12).
#[test]
fn noise_of_the_blind_cases() {
    let Some(blind) = shared::folder("blind") else { return };
    let (mut white, mut quanta, mut rounding) = (Vec::new(), Vec::new(), Vec::new());
    for case in shared::sorted_entries(&blind.join("truth")) {
        let text = std::fs::read_to_string(case.join("truth.json")).unwrap();
        let truth: serde_json::Value = serde_json::from_str(&text).unwrap();
        let folder = blind.join("cases").join(case.file_name().unwrap()).join("recordings");
        let runs: Vec<Recording> = shared::sorted_entries(&folder)
            .into_iter()
            .map(|file| lacuna_recordings::read(&RecordingSource::file(file), "t").unwrap())
            .collect();
        for (channel, sd) in truth["noise_sd"].as_array().unwrap().iter().enumerate() {
            let sd = sd.as_f64().unwrap();
            // The coordinates come first in every file, in the order of the truth.
            let pooled: Vec<(&[f64], &[f64])> =
                runs.iter().map(|r| (&r.time[..], &r.columns[channel].values[..])).collect();
            let found = estimate_noise_pooled(&pooled).unwrap();
            if truth["quantised"] == true {
                quanta.push((found.quantum.unwrap() / (2.0 * sd) - 1.0).abs());
                rounding.push(found.sd / (2.0 * sd / 12f64.sqrt()) - 1.0);
            } else {
                assert_eq!(found.quantum, None, "{}", case.display());
                white.push((found.sd / sd - 1.0).abs());
            }
        }
    }
    let [median, .., ninety, _, worst] = percentiles("white noise, |error of sd|", white);
    assert!(median < 0.015 && ninety < 0.03 && worst < 0.05);
    assert!(percentiles("quantised, |error of quantum|", quanta)[4] < 1e-3);
    let over = percentiles("quantised, sd over q/sqrt(12)", rounding);
    assert!(over[0] < 0.01 && over[4] < 0.1);
}

/// The 50, 75, 90, 95 and 100 % points, printed.
fn percentiles(what: &str, mut errors: Vec<f64>) -> [f64; 5] {
    errors.sort_by(f64::total_cmp);
    let points = [0.5, 0.75, 0.9, 0.95, 1.0];
    let found = points.map(|share| errors[(share * (errors.len() - 1) as f64) as usize]);
    println!("{what}, {} channels, 50/75/90/95/100 %: {found:.5?}", errors.len());
    found
}
