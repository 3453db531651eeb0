//! Laws that stand beside simpler ones: each is named where it acts, with its size.

use crate::findings::{classes, conceal, names, number};
use crate::machines::{Bench, ON_CARRIAGE, ON_PENDULUM, ON_TANKS, ON_TWO_MASS, diagnosed};
use lacuna_discrepancy::diagnosis::Verdict;
use lacuna_excitation::{add_gaussian_noise, rng};
use lacuna_plants::Model;
use lacuna_recordings::Recording;

/// An entry of a model file.
fn effect(class: &str, channel: &str, numbers: &str) -> String {
    format!("[[effect]]\nclass = \"{class}\"\nchannel = \"{channel}\"\n{numbers}")
}

/// Two masses joined stiffly, so that the play of the joint is most of their difference.
fn stiff() -> Bench {
    let text = ON_TWO_MASS.text.replace("value = 40", "value = 300");
    Bench { text: Box::leak(text.into_boxed_str()), noise: 1e-4, ..ON_TWO_MASS }
}

#[test]
fn play_in_the_joint_of_two_masses() {
    let truth =
        effect("transmission_backlash", "x1", "other = \"x2\"\nstiffness = 300\ngap = 0.02");
    let d = conceal(stiff(), 301, &truth);
    names(&d, "transmission_backlash", "x2", &[("gap", 0.02)]);
    assert_eq!(d.findings[0].other.as_deref(), Some("x1"));
    assert_eq!(d.findings[0].parameters["gap"].unit, "m");
}

#[test]
fn a_joint_of_two_masses_that_rubs() {
    let truth = effect(
        "coupling_friction",
        "x1",
        "other = \"x2\"\nmagnitude = 0.5\nsmoothing_velocity = 0.01",
    );
    let d = conceal(ON_TWO_MASS, 302, &truth);
    names(&d, "coupling_friction", "x2", &[("magnitude", 0.5)]);
}

/// A spring about a point that is not 0 is a spring beside a constant force: no stop that the carriage never leaves, and
/// nothing that would relax if it were watched for longer.
#[test]
fn a_spring_about_a_point() {
    for (seed, stiffness, point) in
        [(321, 0.5, 0.3), (322, 3.0, -1.0), (323, 3.0, 0.3), (324, 0.5, -1.0)]
    {
        let spring = effect("linear_stiffness", "x", &format!("stiffness = {stiffness:.1}\n"));
        let rest = effect("constant_force", "x", &format!("force = {:.2}\n", stiffness * point));
        let d = conceal(ON_CARRIAGE, seed, &(spring + &rest));
        assert_eq!(classes(&d), ["constant_force", "linear_stiffness"], "{seed}");
        let spring = number(&d, "linear_stiffness", "stiffness");
        let rest = number(&d, "constant_force", "force") / spring;
        assert!((spring / stiffness - 1.0).abs() < 0.01, "{seed}: {spring}");
        assert!((rest - point).abs() < 0.01, "{seed}: {rest}");
    }
}

/// Beside a constant force friction seems to differ between the directions, which alone says most of it, and which has no
/// peak where it begins to move.
#[test]
fn friction_with_a_peak_on_a_slope() {
    for seed in [331, 332] {
        let friction = effect(
            "stribeck_friction",
            "x",
            "coulomb = 0.3\nstatic = 0.5\nstribeck_velocity = 0.05\nsmoothing_velocity = 0.002\n",
        );
        let slope = effect("constant_force", "x", "force = -0.15\n");
        let d = conceal(ON_CARRIAGE, seed, &(friction + &slope));
        assert_eq!(classes(&d), ["constant_force", "stribeck_friction"], "{seed}");
        for (class, name, truth) in
            [("constant_force", "force", -0.15), ("stribeck_friction", "static", 0.5)]
        {
            let value = number(&d, class, name);
            assert!((value / truth - 1.0).abs() < 0.1, "{seed}: {class} {name} {value}");
        }
    }
}

/// Each rubs on the ground. One law between them does the work of both, and gains most at first.
#[test]
fn two_masses_that_rub_alike() {
    let rubs = |x: &str, magnitude: f64| {
        let numbers = format!("magnitude = {magnitude:.1}\nsmoothing_velocity = 0.02\n");
        effect("coulomb_friction", x, &numbers)
    };
    let d = conceal(ON_TWO_MASS, 307, &(rubs("x1", 0.8) + &rubs("x2", 0.5)));
    let mut found: Vec<_> = d.findings.iter().map(|f| (&*f.channel, &*f.class)).collect();
    found.sort_unstable();
    assert_eq!(found, [("x1", "coulomb_friction"), ("x2", "coulomb_friction")]);
    for (channel, magnitude) in [("x1", 0.8), ("x2", 0.5)] {
        let finding = d.findings.iter().find(|f| f.channel == channel).expect("it was found");
        assert!(
            (finding.parameters["magnitude"].value - magnitude).abs() < 0.02,
            "{}",
            finding.says
        );
    }
}

#[test]
fn friction_that_grows_along_the_way() {
    let truth = effect(
        "position_friction",
        "q",
        "magnitude = 0.06\nslope = 0.05\nsmoothing_velocity = 0.02",
    );
    let d = conceal(ON_PENDULUM, 303, &truth);
    names(&d, "position_friction", "q", &[("magnitude", 0.06), ("slope", 0.05)]);
    assert_eq!(d.findings[0].parameters["slope"].unit, "N m/rad");
}

#[test]
fn friction_that_warms_up() {
    let truth = effect(
        "time_friction",
        "q",
        "initial = 0.12\nfinal = 0.04\ntime_constant = 2.5\nsmoothing_velocity = 0.02",
    );
    let d = conceal(ON_PENDULUM, 304, &truth);
    let numbers = [("initial", 0.12), ("final", 0.04), ("time_constant", 2.5)];
    names(&d, "coulomb_friction", "q", &numbers);
    assert_eq!(d.findings[0].law.as_deref(), Some("time_friction"));
    assert_eq!(d.findings[0].depends_on, ["dq", "t"]);
}

#[test]
fn a_damper_whose_loop_stiffens() {
    let truth = effect("hysteresis", "q", "stiffness = 0.3\nbeta = 2\ngamma = -2.6");
    let d = conceal(ON_PENDULUM, 305, &truth);
    names(&d, "hysteresis", "q", &[("stiffness", 0.3), ("beta", 2.0), ("gamma", -2.6)]);
}

/// A spring that gives way is bent, and has no loop: a force of the position is told, whichever.
#[test]
fn a_spring_that_softens_is_no_hysteresis() {
    let text = ON_PENDULUM.text.replace("tau ", "tau - 0.9*0.45*tanh(q/0.45) ");
    assert_ne!(text, ON_PENDULUM.text);
    let truth = Model::from_text(&text, "truth.toml").expect("the truth is right");
    for seed in 320..323 {
        let recordings = ON_PENDULUM.record(&truth, seed, 3);
        let d = diagnosed(&ON_PENDULUM.model(), &recordings).diagnosis;
        assert_eq!(d.verdict, Verdict::MissingPhysics, "seed {seed}");
        for f in &d.findings {
            assert_eq!(f.depends_on, ["q"], "seed {seed}: {}", f.says);
        }
    }
}

/// A machine whose model is right but for a spring of this formula, which the catalogue does not have.
fn beside_a_spring(model: &str, formula: &str) -> (Bench, Model) {
    let bench = Bench { text: Box::leak(model.to_owned().into_boxed_str()), ..ON_PENDULUM };
    let truth = model.replace("tau ", &format!("tau - {formula} "));
    assert_ne!(truth, bench.text);
    (bench, Model::from_text(&truth, "truth.toml").expect("the truth is right"))
}

/// What the nearest formula leaves of another is little where the model is followed, however much it becomes in the end,
/// and no law of its own.
#[test]
fn what_the_nearest_formula_leaves_is_no_further_law() {
    let linear = ON_PENDULUM.text.replace("mgl*sin(q)", "mgl*q");
    let (bench, truth) = beside_a_spring(&linear, "0.2*atan(q/0.3)");
    for seed in 340..344 {
        let d = diagnosed(&bench.model(), &bench.record(&truth, seed, 3)).diagnosis;
        let found: Vec<_> = d.findings.iter().map(|f| (&*f.class, &f.depends_on[..])).collect();
        assert_eq!(found.len(), 1, "seed {seed}: {found:?}");
        assert_eq!(found[0].1, ["q"], "seed {seed}: {found:?}");
    }
}

/// Nor are several laws together, which with the first are but a curve of its variable.
#[test]
fn a_formula_is_not_spelled_in_three_laws() {
    let (bench, truth) = beside_a_spring(ON_PENDULUM.text, "0.5*q/(1+abs(q)/0.3)");
    for seed in [340, 343] {
        let d = diagnosed(&bench.model(), &bench.record(&truth, seed, 3)).diagnosis;
        assert_eq!(classes(&d), ["cubic_stiffness"], "seed {seed}");
        let fit = &d.fit.held_out["q"];
        assert!(fit.rmse_after < 0.1 * fit.rmse_before, "seed {seed}: {fit:?}");
    }
}

/// A curve that is learned from half of the motion says nothing of the other half: what speaks against it when most of
/// it is known must show in a smaller part.
#[test]
fn a_spring_that_no_formula_comes_near_is_a_curve() {
    let (bench, truth) = beside_a_spring(ON_PENDULUM.text, "0.3*q*exp(-(q/0.8)^2)");
    let d = diagnosed(&bench.model(), &bench.record(&truth, 342, 3)).diagnosis;
    let found: Vec<_> = d.findings.iter().map(|f| (&*f.class, &f.depends_on[..])).collect();
    assert_eq!(found, [("unknown_function", &["q".to_owned()][..])]);
    let fit = &d.fit.held_out["q"];
    assert!(fit.rmse_after < 1.5 * fit.noise, "{fit:?}");
}

/// A carriage that rubs as dry friction does that is no smooth law: where no force moves it, it stands still.
#[test]
fn what_stands_still_has_no_peak_of_friction() {
    const FRICTION: f64 = 0.4;
    // Steps of Euler's within a sample, the friction as far as it can take the speed.
    const STEPS: usize = 1000;
    let bench = Bench { noise: 1e-4, ..ON_CARRIAGE };
    let mut recordings = bench.record(&bench.model(), 380, 3);
    for (run, r) in recordings.iter_mut().enumerate() {
        let named = |r: &Recording, name: &str| r.columns.iter().position(|c| c.name == name);
        let (u, x) = (named(r, "u").expect("an input"), named(r, "x").expect("a place"));
        let (mut place, mut speed, step) = (0.0, 0.0f64, bench.step / STEPS as f64);
        let mut places = vec![];
        for force in r.columns[u].values.clone() {
            places.push(place);
            for _ in 0..STEPS {
                let pushed = speed + step * (force - 2.0 * speed);
                speed = pushed.signum() * (pushed.abs() - step * FRICTION).max(0.0);
                place += step * speed;
            }
        }
        add_gaussian_noise(&mut places, bench.noise, &mut rng(381, run as u64)).expect("noise");
        r.columns[x].values = places;
    }
    let d = diagnosed(&bench.model(), &recordings).diagnosis;
    names(&d, "coulomb_friction", "x", &[("magnitude", FRICTION)]);
}

/// Of more periods over the way than a grid of wavenumbers could cover.
#[test]
fn cogging_over_many_pitches() {
    let bench = Bench {
        samples: 3000,
        step: 0.004,
        amplitude: (10.0, 40.0),
        frequency: (0.5, 4.0),
        ..ON_CARRIAGE
    };
    let d = conceal(bench, 382, &effect("cogging", "x", "amplitude = 1.5\nwavenumber = 23\n"));
    names(&d, "cogging", "x", &[("amplitude", 1.5), ("wavenumber", 23.0)]);
}

/// Of more periods in a recording than a grid of frequencies could cover.
#[test]
fn a_disturbance_that_repeats_often() {
    let truth = effect(
        "periodic_disturbance",
        "q",
        "amplitude = 0.5\nangular_frequency = 97.3\nphase = 1.0",
    );
    let d = conceal(ON_PENDULUM, 370, &truth);
    let truth = [("amplitude", 0.5), ("angular_frequency", 97.3)];
    names(&d, "periodic_disturbance", "q", &truth);
}

/// In a log that counts seconds since 1970 the phase is told where the recordings begin: that of 1970 no frequency is
/// known well enough to tell.
#[test]
fn a_disturbance_in_seconds_since_1970() {
    let truth = effect(
        "periodic_disturbance",
        "q",
        "amplitude = 0.5\nangular_frequency = 9.3\nphase = 1.0",
    );
    let mut recordings = ON_PENDULUM.record(&ON_PENDULUM.truth(&truth), 371, 3);
    recordings.iter_mut().flat_map(|r| &mut r.time).for_each(|t| *t += 1.7e9);
    let d = diagnosed(&ON_PENDULUM.model(), &recordings).diagnosis;
    let truth = [("amplitude", 0.5), ("angular_frequency", 9.3), ("phase", 1.0)];
    names(&d, "periodic_disturbance", "q", &truth);
    let begin = &d.findings[0].parameters["begin"];
    assert_eq!((begin.value, begin.std), (1.7e9, 0.0), "it was chosen, not determined");
}

/// What the knots of a curve cannot follow is neither an offset of the sensor nor another law.
#[test]
fn what_a_curve_cannot_follow_is_no_further_law() {
    let truth = ON_CARRIAGE.text.replace("u - b*v", "u - b*v + 0.5*exp(-((x + 0.05)/0.1)^2)");
    assert_ne!(truth, ON_CARRIAGE.text);
    let truth = Model::from_text(&truth, "truth.toml").expect("the truth is right");
    for seed in 350..354 {
        let recordings = ON_CARRIAGE.record(&truth, seed, 3);
        let d = diagnosed(&ON_CARRIAGE.model(), &recordings).diagnosis;
        let found: Vec<_> = d.findings.iter().map(|f| (&*f.class, &f.depends_on[..])).collect();
        assert_eq!(found, [("unknown_function", &["x".to_owned()][..])], "seed {seed}");
        let fit = &d.fit.held_out["x"];
        assert!(fit.rmse_after < 1.2 * fit.noise, "seed {seed}: {fit:?}");
    }
}

#[test]
fn bristles_that_bend_before_they_slip() {
    let truth = effect(
        "lugre_friction",
        "q",
        "coulomb = 0.06\nstatic_ratio = 1.6\nstribeck_velocity = 0.3\ntravel = 0.06",
    );
    let d = conceal(ON_PENDULUM, 306, &truth);
    names(&d, "lugre_friction", "q", &[("coulomb", 0.06), ("travel", 0.06)]);
}

/// What four springs remember at the beginning of a short held-out window is fitted less well than
/// their law is known.
#[test]
fn springs_that_slip_one_after_the_other() {
    let truth = effect("maxwell_slip", "q", "coulomb = 0.08\ntravel = 0.12");
    let d = conceal(ON_PENDULUM, 310, &truth);
    assert_eq!(classes(&d), ["maxwell_slip"]);
    for (name, truth) in [("coulomb", 0.08), ("travel", 0.12)] {
        let found = &d.findings[0].parameters[name];
        assert!((found.value / truth - 1.0).abs() < 0.02, "{name}: {found:?}");
    }
    assert!(d.findings[0].probability > 0.5, "{}", d.findings[0].probability);
    let fit = &d.fit.held_out["q"];
    assert!(fit.rmse_after < 0.25 * fit.rmse_before, "{fit:?}");
}

#[test]
fn friction_that_grows_with_the_torque() {
    let truth = effect(
        "load_friction",
        "q",
        "other = \"tau\"\nmagnitude = 0.03\nshare = 0.3\nsmoothing_velocity = 0.05",
    );
    let d = conceal(ON_PENDULUM, 311, &truth);
    names(&d, "coulomb_friction", "q", &[("magnitude", 0.03), ("share", 0.3)]);
    assert_eq!(d.findings[0].law.as_deref(), Some("load_friction"));
    assert_eq!(d.findings[0].other.as_deref(), Some("tau"));
    assert_eq!(d.findings[0].depends_on, ["dq", "tau"]);
    assert_eq!(d.findings[0].parameters["share"].unit, "1");
    assert!(d.findings[0].says.contains("on q by tau"), "{}", d.findings[0].says);
}

#[test]
fn a_stop_that_dissipates() {
    let truth =
        effect("damped_stop", "q", "stiffness = 20\ndissipation = 0.8\nposition = 0.3\nside = 1");
    let d = conceal(ON_PENDULUM, 313, &truth);
    let numbers = [("stiffness", 20.0), ("dissipation", 0.8), ("position", 0.3)];
    names(&d, "end_stop", "q", &numbers);
    assert_eq!(d.findings[0].law.as_deref(), Some("damped_stop"));
    assert_eq!(d.findings[0].parameters["dissipation"].unit, "s/rad");
}

#[test]
fn a_damper_that_its_current_sets() {
    let truth = effect("input_damping", "q", "other = \"tau\"\ncoefficient = 0.1");
    let d = conceal(ON_PENDULUM, 312, &truth);
    names(&d, "input_damping", "q", &[("coefficient", 0.1)]);
    assert_eq!(d.findings[0].parameters["coefficient"].unit, "s/rad");
}

#[test]
fn an_upper_tank_that_spills_into_the_lower_one() {
    let truth = effect("spill", "h1", "other = \"h2\"\nrate = 0.3\nposition = 0.8\nshare = 0.6");
    let d = conceal(ON_TANKS, 308, &truth);
    names(&d, "spill", "h1", &[("position", 0.8), ("share", 0.6)]);
    assert_eq!(d.findings[0].other.as_deref(), Some("h2"));
}

#[test]
fn a_sensor_that_shows_nothing_near_zero() {
    let truth = effect("sensor_dead_zone", "q", "half_width = 0.05");
    let bench = ON_PENDULUM;
    let truth = bench.truth(&truth);
    let mut recordings = bench.record(&bench.model(), 309, 3);
    for r in &mut recordings {
        let seen = truth.observed(0, &r.time, r.columns[1].values.clone());
        r.columns[1].values = seen;
    }
    let d = diagnosed(&bench.model(), &recordings).diagnosis;
    assert_eq!(d.verdict, Verdict::SensorFault, "{:?}", d.findings);
    assert_eq!(d.findings[0].class, "sensor_dead_zone");
    let width = &d.findings[0].parameters["half_width"];
    assert!((width.value - 0.05).abs() < 4.0 * width.std + 1e-3, "{width:?}");
}

/// Their travel is less than what the carriage covers from sample to sample, but where it turns. Nothing brings it back
/// to where it began: how well that is known decides nothing.
#[test]
fn bristles_that_slip_within_a_sample() {
    let truth = effect(
        "lugre_friction",
        "x",
        "coulomb = 0.3\nstatic_ratio = 1.2\nstribeck_velocity = 0.1\ntravel = 0.0028",
    );
    for seed in 330..333 {
        let d = conceal(ON_CARRIAGE, seed, &truth);
        names(&d, "lugre_friction", "x", &[("coulomb", 0.3), ("travel", 0.0028)]);
    }
}
