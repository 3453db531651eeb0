//! Prediction: the state at the start of a run is found, and nothing else is fitted.

use crate::machines::{
    Bench, INVERTED_NOISE, ON_PENDULUM, ON_TANKS, ON_TWO_MASS, held_upright, inverted,
};
use lacuna_discrepancy::likelihood::Problem;
use lacuna_discrepancy::prediction::windows;
use lacuna_discrepancy::{Dataset, Observed, Predictor};
use lacuna_plants::{Model, Substeps};

/// On noise-free data of the model itself, a free run follows the whole recording: the
/// state after the warm-up is right to a millionth of the range.
#[test]
fn a_free_run_of_the_true_model_follows_noise_free_data() {
    for bench in [ON_PENDULUM, ON_TWO_MASS, ON_TANKS] {
        let bench = Bench { noise: 0.0, ..bench };
        let model = bench.model();
        let dataset = Dataset::new(&model, &bench.record(&model, 40, 1)).expect("a dataset");
        let run = Predictor::new(&model, &dataset).free_run(&dataset.recordings[0], 50);
        for k in 0..dataset.outputs.len() {
            let share = run.rmse(&dataset.recordings[0], k) / (2.0 * dataset.half_range(k));
            assert!(share < 1e-6, "{} {}: {share}", model.name, dataset.outputs[k].name);
        }
        assert_eq!(run.counted, 50..bench.samples);
    }
}

#[test]
fn the_windowed_error_of_the_true_model_is_the_noise() {
    for bench in [ON_PENDULUM, ON_TWO_MASS, ON_TANKS] {
        let model = bench.model();
        let dataset = Dataset::new(&model, &bench.record(&model, 41, 1)).expect("a dataset");
        let observed = &dataset.recordings[0];
        let horizon = bench.step * bench.samples as f64 / 8.0;
        let run = Predictor::new(&model, &dataset).windowed(observed, horizon);
        assert_eq!(run.counted, 0..bench.samples);
        let (sum, count) = (0..dataset.outputs.len())
            .map(|k| run.squares(observed, k))
            .fold((0.0, 0), |(s, n), (a, b)| (s + a, n + b));
        // Each of eight windows spends as many degrees of freedom as the machine has states.
        let free = (count - 8 * model.machine_states()) as f64;
        let share = (sum / free).sqrt() / bench.noise;
        // Standard deviation of a standard deviation: 1 / sqrt(2 n).
        assert!((share - 1.0).abs() < 4.0 / (2.0 * free).sqrt(), "{}: {share}", model.name);
    }
}

/// A model that is wrong predicts worse the longer it must.
#[test]
fn longer_horizons_are_harder_for_a_wrong_model() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"constant_force\"\nchannel = \"q\"\nforce = 0.1";
    let model = bench.model();
    let dataset =
        Dataset::new(&model, &bench.record(&bench.truth(effect), 42, 1)).expect("a dataset");
    let predictor = Predictor::new(&model, &dataset);
    let error =
        |h: f64| predictor.windowed(&dataset.recordings[0], h).rmse(&dataset.recordings[0], 0);
    let errors = [0.1, 0.4, 1.5, 5.0].map(error);
    assert!(errors.windows(2).all(|e| e[0] < e[1]), "{errors:?}");
    assert!(errors[0] < 1.3 * bench.noise && errors[3] > 20.0 * bench.noise, "{errors:?}");
}

/// A pendulum that a controller holds upside down: what is left alone there falls, and each second takes an error of
/// its beginning six hundred times as far. Its beginning is found all the same, and steps are as long as the machine's
/// own growth of errors lets them be.
#[test]
fn the_beginning_of_a_machine_that_runs_away_is_found() {
    let (model, noise) = (inverted(""), INVERTED_NOISE);
    let recording = held_upright("run", &model, (0.5, 44));
    let dataset = Dataset::new(&model, &[recording]).expect("a dataset");
    let predictor = Predictor::new(&model, &dataset);
    assert!(predictor.integration().steps_a_sample <= 2, "{:?}", predictor.integration());
    for horizon in [0.5, 1.0, 1.5, 2.0] {
        let observed = &dataset.recordings[0];
        let error = predictor.windowed(observed, horizon).rmse(observed, 0) / noise;
        assert!((0.9..1.1).contains(&error), "{horizon} s: {error} noises");
    }
}

/// A model that runs away into a wall where the machine never was: a proof, which lets it run, needs short steps there,
/// and a search, which does not, none.
#[test]
fn steps_of_a_search_are_those_of_where_the_machine_was() {
    let text = |force: &str| {
        format!(
            "name = \"mass\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\nunit = \"m\"\n\
             [[input]]\nname = \"u\"\n[mechanics]\nmass = [[\"1\"]]\nforce = [\"u - 0.5 * v {force}\"]\n"
        )
    };
    let read = |force: &str| Model::from_text(&text(force), "model.toml").expect("a model");
    let truth = read("- 25 * q");
    let model = read("+ 9 * q - 1e5 * max(q - 3, 0) + 1e5 * max(-3 - q, 0)");
    let bench = Bench { start: 0.02, ..ON_PENDULUM };
    let dataset = Dataset::new(&model, &bench.record(&truth, 46, 1)).expect("a dataset");
    let runs = Predictor::new(&model, &dataset).integration();
    assert!(runs.steps_a_sample > 4 || runs.cut_where_slopes_jump, "{runs:?}");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    assert_eq!(problem.substeps(&model.values(), &[], false), Substeps::even(1));
}

/// A light slider in dry friction needs short steps where it turns, and there alone; a pendulum needs none.
#[test]
fn steps_are_cut_where_friction_turns() {
    let text = "name = \"slider\"\n[[coordinate]]\nname = \"q\"\nvelocity = \"v\"\nunit = \"m\"\n\
        [[input]]\nname = \"u\"\n[recordings]\ninput_hold = \"zero-order\"\n\
        [mechanics]\nmass = [[\"0.01\"]]\nforce = [\"u - 0.02 * tanh(v / 0.0004) - 3 * q - 0.2 * v\"]\n";
    let model = Model::from_text(text, "model.toml").expect("a model");
    let bench = Bench { text, samples: 1200, step: 0.005, amplitude: (0.5, 1.0), ..ON_PENDULUM };
    let dataset = Dataset::new(&model, &bench.record(&model, 45, 1)).expect("a dataset");
    let found = Predictor::new(&model, &dataset).integration();
    assert!(found.cut_where_slopes_jump && found.steps_a_sample <= 2, "{found:?}");
    assert!(found.error_over_noise < 0.01, "{found:?}");
    let model = ON_PENDULUM.model();
    let dataset = Dataset::new(&model, &ON_PENDULUM.record(&model, 45, 1)).expect("a dataset");
    let found = Predictor::new(&model, &dataset).integration();
    assert!(!found.cut_where_slopes_jump && found.steps_a_sample == 1, "{found:?}");
}

#[test]
fn missing_samples_do_not_count_and_do_not_hurt() {
    let bench = ON_PENDULUM;
    let model = bench.model();
    let mut recording = bench.record(&model, 43, 1);
    let q = recording[0].columns.iter_mut().find(|c| c.name == "q").expect("q is there");
    q.values.iter_mut().skip(200).step_by(7).for_each(|v| *v = f64::NAN);
    q.values[400..450].fill(f64::NAN);
    let measured = q.values.iter().filter(|v| v.is_finite()).count();
    let dataset = Dataset::new(&model, &recording).expect("a dataset");
    let observed = &dataset.recordings[0];
    let run = Predictor::new(&model, &dataset).windowed(observed, 1.0);
    assert_eq!(run.squares(observed, 0).1, measured);
    assert!((run.rmse(observed, 0) / bench.noise - 1.0).abs() < 0.15);
    assert!(run.outputs[0].iter().all(|v| v.is_finite()));
}

#[test]
fn windows_cover_every_sample_once() {
    let even: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
    let jittered: Vec<f64> =
        (0..700).map(|k| f64::from(k) + 0.3 * f64::from(k % 13).sin()).map(|t| 0.02 * t).collect();
    let late: Vec<f64> = even.iter().map(|t| 1.7e9 + t).collect();
    for times in [&even[..], &jittered, &late, &even[..5], &even[..2]] {
        for horizon in [0.03, 0.11, 1.0, 2.37, 9.0, 1e4] {
            let windows = windows(&at(times), horizon);
            let mut next = 0;
            for w in &windows {
                assert_eq!(w.start, next, "horizon {horizon}: {windows:?}");
                assert!(w.len() >= 2);
                next = w.end;
            }
            assert_eq!(next, times.len(), "horizon {horizon}");
        }
    }
    assert_eq!(windows(&at(&even), 1e4).len(), 1);
    assert_eq!(windows(&at(&even), 1.0).len(), 10);
}

/// A recording of nothing at these times.
fn at(times: &[f64]) -> Observed {
    let (times, none) = (times.to_vec(), String::new());
    let (commands, outputs, lost, anew, cleaned) = (vec![], vec![], vec![], vec![], vec![]);
    Observed { name: none, times, commands, outputs, dropped: 0, lost, anew, cleaned }
}

/// Fine sampling that turns coarse: windows with a single sample join their neighbours.
#[test]
fn windows_cover_uneven_sampling_too() {
    let fine = (0..400).map(|k| 0.001 * f64::from(k));
    let coarse = (1..120).map(|k| 0.399 + 0.0035 * f64::from(k));
    let times: Vec<f64> = fine.chain(coarse).collect();
    for horizon in [0.002, 0.006, 0.05] {
        let all = windows(&at(&times), horizon);
        assert!(all.iter().all(|r| r.len() >= 2), "{horizon}");
        assert_eq!(all[0].start, 0);
        assert!(all.windows(2).all(|p| p[0].end == p[1].start), "{horizon}");
        assert_eq!(all[all.len() - 1].end, times.len());
    }
}
