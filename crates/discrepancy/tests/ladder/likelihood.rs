//! Multiple shooting: parameters come back, and their standard deviations are honest.

use crate::findings::classes;
use crate::machines::{Bench, ON_CARRIAGE, ON_PENDULUM, ON_TANKS, diagnosed};
use lacuna_discrepancy::likelihood::{
    Effort, FULL, Fit, FitError, Hypothesis, LAST, Problem, STILL, What,
};
use lacuna_discrepancy::search::chain::{begin, grow, lengthen};
use lacuna_discrepancy::{Dataset, Decision};
use lacuna_plants::model::ModelEffect;
use lacuna_plants::{Model, Substeps};

/// Errors of all parameters in units of their standard deviations, over several seeds, and the mean square residual
/// of each fit in units of the noise.
fn standardised_errors(bench: Bench, seeds: std::ops::Range<u64>) -> (Vec<f64>, Vec<f64>) {
    let mut residuals = vec![];
    let bench = Bench { samples: bench.samples / 2, ..bench };
    let model = bench.model();
    let mut truth = model.clone();
    for (p, share) in truth.parameters.iter_mut().zip([1.06, 0.93, 1.04]) {
        p.value += (share - 1.0) * 10.0 * p.std();
    }
    let errors = seeds
        .flat_map(|seed| {
            let dataset = Dataset::new(&model, &bench.record(&truth, seed, 2)).expect("a dataset");
            let problem = Problem::new(&model, &dataset).expect("a problem");
            let begun = Fit::begin(&problem, Hypothesis::of(&model), 3).expect("a fit");
            let fit = lengthen(begun, Decision::default().window_misfit);
            // Windows grow to the whole recording.
            assert_eq!(fit.windowed.level, 0, "{} seed {seed}", model.name);
            residuals.push(fit.reduced());
            let (truth, std) = (truth.values(), fit.parameter_std(1.0));
            let free = (0..truth.len()).filter(|&k| model.parameters[k].std() > 0.0);
            free.map(|k| (fit.hypothesis.parameters[k] - truth[k]) / std[k]).collect::<Vec<_>>()
        })
        .collect();
    (errors, residuals)
}

fn rms(z: &[f64]) -> f64 {
    (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt()
}

#[test]
fn parameters_are_recovered_with_standard_deviations_that_cover() {
    for (bench, seeds) in [(ON_PENDULUM, 60..68), (ON_TANKS, 70..78)] {
        let (z, residuals) = standardised_errors(bench, seeds);
        assert!(residuals.iter().all(|r| (0.9..1.1).contains(r)), "{residuals:?}");
        assert!(z.len() >= 16);
        assert!(z.iter().all(|z| z.abs() < 4.0), "{z:?}");
        // Deviations that cover have rms 1; sixteen or more of them scatter about it.
        assert!((0.4..1.6).contains(&rms(&z)), "{z:?}");
    }
}

#[test]
fn standard_deviations_cover_what_they_say() {
    let mut all = vec![];
    for (bench, seeds) in [(ON_PENDULUM, 1000..1040), (ON_TANKS, 1040..1080)] {
        let (z, residuals) = standardised_errors(bench, seeds);
        let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
        assert!((0.9..1.1).contains(&mean), "{residuals:?}");
        assert!(z.len() >= 80);
        assert!(z.iter().all(|z| z.abs() < 4.0), "{z:?}");
        // Deviations that cover have rms 1; eighty or more of them scatter about it.
        assert!((0.8..1.2).contains(&rms(&z)), "{z:?}");
        all.extend(z);
    }
    let within = all.iter().filter(|z| z.abs() < 2.0).count() as f64 / all.len() as f64;
    // 95.4 % of normal errors, give or take the chance of so many.
    assert!((0.93..0.98).contains(&within), "{within} of {}", all.len());
}

#[test]
fn an_effect_is_fitted_from_a_rough_start() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 0.25";
    let truth = bench.truth(effect);
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&truth, 80, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let start = ModelEffect { parameters: vec![0.1], ..truth.effects[0].clone() };
    let scales = problem.scales_of(&start);
    let begun =
        Fit::begin(&problem, Hypothesis::of(&model).with(start, &scales), 4).expect("a fit");
    let fit = lengthen(begun, Decision::default().window_misfit);
    let found = &fit.effects(1.0)[0];
    let std = found.std[0].expect("a fitted parameter has a standard deviation");
    assert!((found.parameters[0] - 0.25).abs() < 4.0 * std, "{} +- {std}", found.parameters[0]);
    assert!(std > 0.0 && std < 0.05, "{std}");
    assert!((0.9..1.1).contains(&fit.reduced()), "{}", fit.reduced());
    // What is left is white noise of the size that was estimated.
    assert!(fit.temperature() < 3.0, "{}", fit.temperature());
}

/// A law and its special case are told apart by a few nats; what coarser steps err by adds up to more over all samples. The
/// special case goes by the steps of the law.
#[test]
fn a_special_case_is_judged_by_the_same_steps() {
    let bench = Bench { noise: 1e-4, ..ON_PENDULUM };
    let model = bench.model();
    let effect = |class: &str, numbers: &str| {
        let text = format!("[[effect]]\nclass = \"{class}\"\nchannel = \"q\"\n{numbers}");
        bench.truth(&text)
    };
    let truth = effect("coulomb_friction", "magnitude = 0.05\nsmoothing_velocity = 0.01");
    let richer = effect(
        "stribeck_friction",
        "coulomb = 0.05\nstatic = 0.05\nstribeck_velocity = 0.1\nsmoothing_velocity = 0.01",
    );
    let dataset = Dataset::new(&model, &bench.record(&truth, 86, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let supposing = |m: &Model| {
        let effect = m.effects[0].clone();
        let scales = problem.scales_of(&effect);
        Hypothesis::of(&model).with(effect, &scales)
    };
    let mut rich = Fit::begin(&problem, supposing(&richer), 0).expect("a fit");
    rich.substeps = Substeps::even(16);
    let rich = rich.refit_alike(rich.hypothesis.clone(), FULL).expect("a fit");
    let squares = |fit: &Fit| fit.reduced() * fit.count as f64;
    let own = rich.refit(supposing(&truth), FULL).expect("a fit");
    let alike = rich.refit_alike(supposing(&truth), FULL).expect("a fit");
    assert_eq!(alike.substeps, rich.substeps);
    assert_ne!(own.substeps, rich.substeps);
    let apart = (squares(&alike) - squares(&rich)).abs();
    assert!(apart < 8.0, "{apart}; in steps of its own {}", squares(&own) - squares(&rich));
    let leads = [&alike, &own].map(|fit| rich.gain_over(fit));
    assert!((leads[0] - leads[1]).abs() < 1.0, "{leads:?}");
}

/// What windows say of a small effect by their linearised selves is what fits without them say.
#[test]
fn windows_that_are_left_out_say_by_their_derivatives_what_they_say() {
    let bench = ON_PENDULUM;
    let model = bench.model();
    for (seed, stiffness) in [(82, 1e-5), (83, 3e-5), (84, 0.0), (85, 0.0)] {
        let effect = format!(
            "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = {stiffness}"
        );
        let truth = bench.truth(&effect);
        let dataset = Dataset::new(&model, &bench.record(&truth, seed, 2)).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let start = ModelEffect { parameters: vec![1e-5], ..truth.effects[0].clone() };
        let scales = problem.scales_of(&start);
        let h = Hypothesis::of(&model).with(start, &scales);
        let with = Fit::begin(&problem, h.clone(), 2).expect("a fit");
        let without = with.refit(h.without(0), FULL).expect("a fit");
        let marked = [true, false, false, true, false, true, false, false];
        let [a, b] = [&with, &without].map(|fit| {
            let leaving = fit.leaving_out().expect("windows");
            leaving.predicted(&marked, FULL).expect("a prediction").concat()
        });
        let squares = |r: &[f64]| r.iter().map(|r| r * r).sum::<f64>();
        let size: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum();
        let drop = squares(&b) - squares(&a);
        let leaving = with.leaving_out().expect("windows");
        let said = leaving.said_of(0, &marked).expect("it vanishes");
        assert!((said.size / size - 1.0).abs() < 0.1, "seed {seed}: {said:?}, {size}");
        assert!((said.drop - drop).abs() < 0.1 * size, "seed {seed}: {said:?}, {drop} of {size}");
    }
}

#[test]
fn held_parameters_stay_where_they_are() {
    let bench = Bench { samples: 400, ..ON_PENDULUM };
    let mut model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 81, 1)).expect("a dataset");
    for p in &mut model.parameters {
        p.value *= 1.05;
    }
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let fit = Fit::begin(&problem, Hypothesis::of(&model).held(), 3).expect("a fit");
    assert_eq!(fit.hypothesis.parameters, model.values());
    assert_eq!(fit.parameter_std(1.0), [0.0; 3]);
}

/// Memory of an effect runs on from window to window: the windows' borders leave no trace.
#[test]
fn memory_does_not_know_of_windows() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"viscoelastic\"\nchannel = \"q\"\nstiffness = 0.4\ntime_constant = 0.8";
    let truth = bench.truth(effect);
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&truth, 82, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let scales = problem.scales_of(&truth.effects[0]);
    let h = Hypothesis::of(&model).with(truth.effects[0].clone(), &scales);
    for level in [4, 0] {
        let fit = Fit::begin(&problem, h.clone(), level).expect("a fit");
        let fit = fit.refit(fit.hypothesis.clone(), FULL).expect("a fit");
        assert!((0.9..1.1).contains(&fit.reduced()), "level {level}: {}", fit.reduced());
        let std = fit.effects(1.0)[0].std[1].expect("a standard deviation");
        let tau = fit.hypothesis.supposed()[0].parameters[1];
        assert!((tau - 0.8).abs() < 4.0 * std, "level {level}: {tau} +- {std}");
    }
}

/// What was begun in a few windows is judged in all of them. Memory runs through those between, so that they are
/// there from the beginning.
#[test]
fn laws_with_memory_are_judged_by_all_samples() {
    let bench = ON_PENDULUM;
    let effect =
        "[[effect]]\nclass = \"hysteresis\"\nchannel = \"q\"\nstiffness = 1\nbeta = 2\ngamma = 1";
    let truth = bench.truth(effect);
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 83, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let base = Fit::begin(&problem, Hypothesis::of(&model), 4).expect("a fit");
    let law = truth.effects[0].clone();
    let h = base.hypothesis.clone().with(law, &problem.scales_of(&truth.effects[0]));
    let begun = begin(&base, h).expect("a fit");
    assert!(begun.count < base.count && !begun.is_of_all_of(&base), "{}", begun.count);
    let grown = grow(&base, &base, begun).expect("a fit");
    assert!(grown.is_of_all_of(&base), "{} of {}", grown.count, base.count);
    // Nothing is missing.
    assert!(grown.gain_over(&base) < 0.0, "{} nats", grown.gain_over(&base));
}

/// Steps are chosen for a model as it was fitted. One that is stiffer is foretold in finer ones before it is said to
/// diverge.
#[test]
fn what_is_stiff_is_foretold_in_finer_steps() {
    let bench = ON_PENDULUM;
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 84, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let base = Fit::begin(&problem, Hypothesis::of(&model), 2).expect("a fit");
    let windows: usize = base.windowed.windows.iter().map(Vec::len).sum();
    let foretold = |coefficient: f64| {
        let drag = bench.truth(&format!(
            "[[effect]]\nclass = \"viscous_friction\"\nchannel = \"q\"\ncoefficient = {coefficient:.1}"
        ));
        let law = drag.effects[0].clone();
        let h = base.hypothesis.clone().with(law, &problem.scales_of(&drag.effects[0]));
        base.foretold(h, &vec![true; windows])
    };
    // Runge-Kutta of fourth order is stable up to 2.78 over a step.
    let limit = 2.78 * base.substeps.count as f64 / bench.step * model.values()[0];
    let found = foretold(4.0 * limit).expect("finer steps follow it");
    assert!(found.iter().flatten().all(|r| r.is_finite()));
    assert!(matches!(foretold(4000.0 * limit), Err(FitError::Diverged(_))));
}

/// More evidence for the effect that is there than for one that is not, and for neither where
/// nothing is missing.
#[test]
fn evidence_prefers_what_is_there() {
    let bench = ON_PENDULUM;
    let model = bench.model();
    let cubic = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 0.25";
    let drag = "[[effect]]\nclass = \"quadratic_drag\"\nchannel = \"q\"\ncoefficient = 0.004";
    for (truth, right) in [(bench.truth(cubic), Some(0)), (bench.model(), None)] {
        let dataset = Dataset::new(&model, &bench.record(&truth, 83, 2)).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let plain = Fit::begin(&problem, Hypothesis::of(&model), 3).expect("a fit");
        let effort = Effort { steps: 20, least: 0.01, undamped: false };
        let gains: Vec<f64> = [cubic, drag]
            .into_iter()
            .map(|e| {
                let effect = bench.truth(e).effects[0].clone();
                let scales = problem.scales_of(&effect);
                let h = plain.hypothesis.clone().with(effect, &scales);
                let fit = plain.refit(h, effort).expect("a fit");
                fit.gain_over(&plain)
            })
            .collect();
        match right {
            Some(k) => assert!(gains[k] > 20.0 && gains[k] > gains[1 - k] + 20.0, "{gains:?}"),
            None => assert!(gains.iter().all(|g| *g < 5.0), "{gains:?}"),
        }
    }
}

/// What is missed without an effect, from its posterior alone, is what a fit without it says: where nothing is
/// missing, where it hardly counts and where it does.
#[test]
fn what_is_missed_is_told_without_another_fit() {
    let bench = Bench { noise: 2e-2, ..ON_PENDULUM };
    let model = bench.model();
    for stiffness in [0.0, 0.001, 0.005, 0.02, 0.05] {
        let of = |k: f64| {
            format!("[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = {k}")
        };
        let truth = bench.truth(&of(stiffness));
        let dataset = Dataset::new(&model, &bench.record(&truth, 85, 2)).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let effect = bench.truth(&of(0.01)).effects[0].clone();
        let scales = problem.scales_of(&effect);
        let plain = Fit::begin(&problem, Hypothesis::of(&model), 3).expect("a fit");
        let effort = Effort { steps: 30, least: 1e-3, undamped: false };
        let fit =
            plain.refit(plain.hypothesis.clone().with(effect, &scales), effort).expect("a fit");
        let without = fit.refit(fit.hypothesis.clone().without(0), effort).expect("a fit");
        let temperature = fit.temperature();
        let missed = fit.missed(0, temperature).expect("it has an amplitude");
        let gain = fit.gain_over(&without);
        // Without the last one the model ends elsewhere, where no posterior is normal: neither doubts it.
        let close = (missed - gain).abs() < 0.3 + 0.1 * gain.abs();
        let beyond_doubt = stiffness == 0.05 && missed > 1e4 && gain > 1e4;
        assert!(close || beyond_doubt, "{stiffness}: {missed} {gain}");
    }
}

/// An actuator's gain times a sensor's scale is what recordings of a carriage tell: without one of two that stand along that
/// valley all else, states too, begins where it belongs without it.
#[test]
fn without_one_of_two_that_do_the_same() {
    let bench = Bench { amplitude: (0.6, 1.2), ..ON_CARRIAGE };
    let truth = bench.truth("[[effect]]\nclass = \"gain_error\"\nchannel = \"u\"\ngain = 1.05");
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&truth, 87, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let scale = "[[effect]]\nclass = \"sensor_scale\"\nchannel = \"x\"\nscale = 0.99";
    let mut gain = truth.effects[0].clone();
    gain.parameters = vec![1.05 / 0.99];
    let scale = bench.truth(scale).effects[0].clone();
    let with = |h: Hypothesis, e: &ModelEffect| h.with(e.clone(), &problem.scales_of(e));
    let both = with(with(Hypothesis::of(&model), &scale), &gain);
    let begun = Fit::still(&problem, both, 0).expect("a fit");
    // The states alone, so that the effects stand where they were put.
    let fit = begun.states_at(0).expect("a fit");
    assert!(fit.reduced() < 1.2, "{}", fit.reduced());
    let leapt = fit.leapt_without(0, STILL).expect("both vanish");
    let plain = fit.without(0, STILL).expect("a fit");
    let left = [&fit, &leapt, &plain].map(Fit::reduced);
    assert!(left[1] < 1.01 * left[0] && left[2] > 10.0 * left[0], "{left:?}");
    let gain = leapt.hypothesis.supposed()[0].parameters[0] / leapt.hypothesis.parameters[0];
    assert!((gain - 1.05).abs() < 0.01, "{gain}");
}

/// Laplace's evidence against the integral that it stands for, by quadrature over the amplitude:
/// of either sign, and of a magnitude whose prior has its mass on one side.
#[test]
fn evidence_is_the_integral_over_the_prior() {
    let bench = Bench { samples: 400, ..ON_PENDULUM };
    let model = bench.model();
    let effort = Effort { steps: 30, least: 1e-6, undamped: false };
    for (class, parameter, truth, sides) in
        [("cubic_stiffness", "stiffness", 0.25, 1.0), ("quadratic_drag", "coefficient", 0.02, 2.0)]
    {
        let text =
            format!("[[effect]]\nclass = \"{class}\"\nchannel = \"q\"\n{parameter} = {truth}");
        let machine = bench.truth(&text);
        let dataset = Dataset::new(&model, &bench.record(&machine, 84, 2)).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let without = Hypothesis::of(&model).held();
        let plain = Fit::begin(&problem, without.clone(), 3).expect("a fit");
        let plain = plain.refit(without.clone(), effort).expect("a fit");
        let effect = machine.effects[0].clone();
        let with = without.with(effect.clone(), &problem.scales_of(&effect));
        let sd = with.free[0].sd;
        let fit = plain.refit(with.clone(), effort).expect("a fit");
        // chi^2 over the amplitude, the states fitted at each.
        let (best, width) = (fit.hypothesis.theta()[0], fit.std(1.0)[0]);
        let step = 0.25 * width;
        let integral: f64 = (-24..=24)
            .map(|k| {
                let amplitude = best + step * f64::from(k);
                let mut h = with.clone();
                h.set(&[amplitude]);
                let chi2 = fit.refit(h.held(), effort).expect("a fit").chi2;
                let prior = (-0.5 * (amplitude / sd).powi(2)).exp() * sides
                    / (sd * std::f64::consts::TAU.sqrt());
                prior * (-0.5 * (chi2 - fit.chi2)).exp() * step
            })
            .sum();
        let expected = integral.ln() - 0.5 * (fit.chi2 - plain.chi2);
        let found = fit.log_evidence(1.0) - plain.log_evidence(1.0);
        assert!((found - expected).abs() < 0.05, "{class}: {found} nats, by quadrature {expected}");
    }
}

/// The mismatch of each recording is its own, and all together are that of the fit.
#[test]
fn mismatch_by_recording_adds_up() {
    let bench = ON_PENDULUM;
    let heavier =
        Bench { text: Box::leak(bench.text.replace("value = 0.4", "value = 0.5").into()), ..bench };
    let mut recordings = bench.record(&bench.model(), 79, 3);
    recordings[1] = heavier.record(&heavier.model(), 79, 2).remove(1);
    let model = bench.model();
    let data = Dataset::new(&model, &recordings).expect("the recordings fit");
    let problem = Problem::new(&model, &data).expect("it is one");
    let held = Hypothesis::of(&model).held();
    let fit = Fit::begin(&problem, held, 3).expect("it follows");
    let by_recording = fit.excess_by_recording();
    let [first, other, third] = by_recording[..] else { panic!("{by_recording:?}") };
    // All are of one length.
    let mean = by_recording.iter().sum::<f64>() / 3.0;
    assert!((mean / fit.excess() - 1.0).abs() < 1e-9, "{mean} {}", fit.excess());
    assert!(other > 10.0 * first.max(third).max(0.1), "{by_recording:?}");
}

/// A cart that a moving wall drives by a spring: its mass, its spring and its friction by one factor are the same
/// motion.
const DRIVEN_BY_A_WALL: &str = r#"
name = "cart"
[parameters]
m = { value = 1.3, unit = "kg", tolerance = 0.1 }
k = { value = 6.0, unit = "N/m", tolerance = 0.1 }
c = { value = 0.8, unit = "N s/m", tolerance = 0.2 }
[[input]]
name = "wall"
unit = "m"
actuator = false
noise = 0
[[coordinate]]
name = "q"
velocity = "v"
unit = "m"
[mechanics]
mass = [["m"]]
force = ["-k*(q - wall) - c*v"]
"#;

#[test]
fn what_no_sample_tells_is_where_its_prior_has_it() {
    // Samples tell the rest so well that a step which is damped by a share of that hardly moves the factor.
    let bench =
        Bench { text: DRIVEN_BY_A_WALL, samples: 2000, amplitude: (0.5, 1.5), ..ON_PENDULUM };
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 41, 1)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let mut h = Hypothesis::of(&model);
    h.parameters.iter_mut().for_each(|p| *p *= 0.85);
    let fit = Fit::begin(&problem, h, 0).expect("a fit");
    // Of one factor alone, the spread of all three priors; .5 of a nat from where they are best.
    let spread = (1.0 / (1.0 / 0.01 + 1.0 / 0.01 + 1.0 / 0.04f64)).sqrt();
    let nominal = model.values();
    let std = fit.parameter_std(1.0);
    for ((p, nominal), std) in fit.hypothesis.parameters.iter().zip(&nominal).zip(std) {
        assert!((p / nominal - 1.0).abs() < 0.3 * spread, "{p} of {nominal}");
        assert!((std / nominal / spread - 1.0).abs() < 0.1, "{std} of {nominal}");
    }
}

/// A slider whose motor and gear count by their product alone.
const GEARED: &str = r#"
name = "slider"
[parameters]
motor = { value = 2.0, unit = "N/A", tolerance = 0.1 }
gear = { value = 3.0, unit = "1", tolerance = 0.1 }
[[input]]
name = "i"
unit = "A"
[[coordinate]]
name = "q"
velocity = "v"
unit = "m"
[mechanics]
mass = [["1"]]
force = ["motor*gear*i - 2*v - 10*q"]
"#;

/// The values of a fit from the nominal ones, each times one of these factors, and the nominal ones.
fn refitted_from(bench: Bench, factors: &[f64]) -> Vec<(f64, f64)> {
    let model = bench.model();
    let dataset = Dataset::new(&model, &bench.record(&model, 41, 1)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let mut h = Hypothesis::of(&model);
    h.parameters.iter_mut().zip(factors).for_each(|(p, factor)| *p *= factor);
    let fit = Fit::begin(&problem, h, 0).and_then(|fit| fit.further(LAST)).expect("a fit");
    fit.hypothesis.parameters.iter().copied().zip(model.values()).collect()
}

#[test]
fn what_exact_samples_do_not_tell_is_where_its_prior_has_it() {
    // What they tell, they tell to a millionth of its tolerance and better: any share of that holds what they do not.
    let cart = Bench { text: DRIVEN_BY_A_WALL, noise: 1e-8, amplitude: (0.5, 1.5), ..ON_PENDULUM };
    // The valley along which two factors have one product is bent.
    let slider = Bench { text: GEARED, noise: 1e-6, ..cart };
    for (bench, factors) in [(cart, &[0.85, 0.85, 0.85][..]), (slider, &[0.8, 1.25])] {
        for (p, nominal) in refitted_from(bench, factors) {
            assert!((p / nominal - 1.0).abs() < 0.01, "{p} of {nominal}");
        }
    }
}

/// What moves by itself tells forces and inertia but for a factor in common. A cubic spring that the model did not know had drawn
/// that factor away before it was named.
#[test]
fn what_is_reported_is_at_the_bottom_of_a_valley() {
    let effect = "[[effect]]\nclass = \"cubic_stiffness\"\nchannel = \"q\"\nstiffness = 3.0";
    let bench = Bench { text: DRIVEN_BY_A_WALL, noise: 1e-6, amplitude: (0.5, 1.5), ..ON_PENDULUM };
    let (model, truth) = (bench.model(), bench.truth(effect));
    for seed in 42..45 {
        let diagnosis = diagnosed(&model, &bench.record(&truth, seed, 3)).diagnosis;
        assert_eq!(classes(&diagnosis), ["cubic_stiffness"], "seed {seed}");
        for (name, found) in &diagnosis.calibration {
            let off = (found.value - found.nominal) / found.std;
            assert!(off.abs() < 1.0, "seed {seed}: {name} is off by {off} standard deviations");
        }
    }
}

#[test]
fn standard_deviations_of_sums_know_of_covariances() {
    let bench = ON_PENDULUM;
    let effect = "[[effect]]\nclass = \"stribeck_friction\"\nchannel = \"q\"\ncoulomb = 0.1\nstatic = 0.2\n\
        stribeck_velocity = 0.3\nsmoothing_velocity = 0.02";
    let (model, truth) = (bench.model(), bench.truth(effect));
    let dataset = Dataset::new(&model, &bench.record(&truth, 91, 2)).expect("a dataset");
    let problem = Problem::new(&model, &dataset).expect("a problem");
    let scales = problem.scales_of(&truth.effects[0]);
    let h = Hypothesis::of(&model).with(truth.effects[0].clone(), &scales);
    let fit = Fit::begin(&problem, h, 2).expect("a fit");
    // Internal: the friction at speed, and how much higher it is at rest.
    let covariance = fit.covariance(1.0).expect("it is finite");
    let entry = |j| fit.hypothesis.free.iter().position(|f| f.what == What::Effect(0, j)).unwrap();
    let (a, b) = (entry(0), entry(1));
    let apart = covariance[(a, a)] + covariance[(b, b)];
    let of_sum = apart + 2.0 * covariance[(a, b)];
    let told = fit.effects(1.0)[0].std[1].expect("it is fitted");
    assert!((told / of_sum.sqrt() - 1.0).abs() < 1e-3, "{told}, {}", of_sum.sqrt());
    assert!((of_sum / apart - 1.0).abs() > 0.02, "{of_sum} of {apart}");
}
