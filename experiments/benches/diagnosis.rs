//! Time of one diagnosis of a drawn case with two coordinates, and of one screening of the
//! catalogue along its fitted motion.

use divan::{Bencher, black_box};
use experiments::concealed::case::{Case, plans};
use experiments::concealed::sealed::{Group, Matter};
use lacuna_discrepancy::candidates::{Candidate, candidates};
use lacuna_discrepancy::diagnose::{Options, diagnose, split};
use lacuna_discrepancy::likelihood::{FULL, Fit, Hypothesis, Problem};
use lacuna_discrepancy::screen::Screen;
use lacuna_discrepancy::{Dataset, Watch};
use lacuna_plants::Model;

fn main() {
    divan::main();
}

/// Seed of the case; the studies draw from others.
const SEED: u64 = 21;
/// Plans among which a case with two coordinates is looked for: half of the plants have two.
const PLANS: usize = 12;
/// Windows a recording of the screened fit: 2 to this power.
const LEVEL: u32 = 2;

/// The model and recordings of the first drawn case with two coordinates and missing physics.
fn case() -> (Model, Dataset) {
    let mut plans = plans(SEED, PLANS, Some(Group::Catalogue)).into_iter();
    let two = plans.find_map(|plan| {
        let case = Case::draw(SEED, &plan).expect("a case can be drawn");
        let model = case.files.read().expect("its model is valid");
        let fits = model.coordinates.len() == 2 && case.sealed.matter == Matter::MissingPhysics;
        fits.then_some((case, model))
    });
    let (case, model) = two.expect("one of the cases has two coordinates");
    let data = Dataset::new(&model, &case.recordings).expect("its recordings fit its model");
    (model, data)
}

#[divan::bench(sample_count = 5)]
fn whole_diagnosis(bencher: Bencher) {
    let (model, data) = case();
    let (training, held_out) = split(&data);
    bencher.bench_local(|| {
        diagnose(black_box(&model), &training, &held_out, Options::default(), &Watch::default())
            .expect("a diagnosis")
            .diagnosis
    });
}

#[divan::bench(sample_count = 20)]
fn screening(bencher: Bencher) {
    let (model, data) = case();
    let problem = Problem::new(&model, &data).expect("a problem");
    let fit = Fit::begin(&problem, Hypothesis::of(&model), LEVEL).expect("a fit");
    let fit = fit.refit(fit.hypothesis.clone(), FULL).expect("a fit");
    let states: Vec<usize> = (0..model.channels())
        .map(|channel| model.coordinate_index(channel))
        .filter(|state| data.output_of_state(*state).is_some())
        .collect();
    let all: Vec<Candidate> = candidates(&model, &states);
    bencher.bench_local(|| Screen::new(black_box(&fit)).expect("a screen").score(&all));
}
