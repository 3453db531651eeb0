//! Made-up diagnoses of the kinds that occur.

use lacuna_discrepancy::diagnosis::*;
use lacuna_report::Proof;
use std::collections::BTreeMap;

/// A channel whose name a page must not obey.
pub const HOSTILE: &str = "<img src=x onerror=\"alert(1)\">";

fn map<T>(items: impl IntoIterator<Item = (&'static str, T)>) -> BTreeMap<String, T> {
    items.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()
}

fn estimate(value: f64, std: f64, unit: &str) -> Estimate {
    Estimate { value, std, unit: unit.into(), at_bound: false }
}

fn errors(unit: &str, noise: f64, windows: [f64; 2], free: [f64; 2]) -> ChannelFit {
    ChannelFit {
        unit: unit.into(),
        rmse_before: windows[0],
        rmse_after: windows[1],
        noise,
        horizon_s: 1.0,
        free_run_before: free[0],
        free_run_after: free[1],
    }
}

/// Dry friction learned over velocity, with little data at the ends.
fn friction_curve() -> Curve {
    let at: Vec<f64> = (-30..=30).map(|k| f64::from(k) / 200.0).collect();
    let law: Vec<f64> = at.iter().map(|v| -20.41 * (v / 0.004).tanh()).collect();
    let wiggle = |v: &f64| 0.5 * (90.0 * v).sin() - 20.41 * (v / 0.009).tanh();
    Curve {
        variable: "dq".into(),
        variable_unit: "m/s".into(),
        force_unit: "N".into(),
        learned: at.iter().map(wiggle).collect(),
        std: at.iter().map(|v| 0.3 + 400.0 * v.powi(4) / 0.05 + 300.0 * v.abs().powi(3)).collect(),
        law,
        at,
    }
}

/// The same force, learned over some variable before anything is added.
fn lawless(variable: &str, unit: &str) -> Curve {
    Curve { variable: variable.into(), variable_unit: unit.into(), law: vec![], ..friction_curve() }
}

/// A drive that lacks its dry friction; one parameter is off too.
pub fn missing() -> Diagnosis {
    let finding = Finding {
        class: "coulomb_friction".into(),
        law: None,
        channel: "q".into(),
        other: None,
        depends_on: vec!["dq".into()],
        region: map([("dq", [-0.1512, 0.1498])]),
        time: None,
        parameters: map([
            ("magnitude", estimate(20.4137, 0.1234, "N")),
            ("smoothing_velocity", estimate(0.004_12, 0.000_31, "m/s")),
        ]),
        probability: 0.972,
        alternatives: vec![
            Alternative {
                class: "stribeck_friction".into(),
                channel: "q".into(),
                probability: 0.026,
                behind: 3.6,
            },
            Alternative {
                class: "cogging".into(),
                channel: "q".into(),
                probability: 0.0007,
                behind: 7.2,
            },
        ],
        experiment: None,
        evidence: 8423.0,
        support: Support { log_odds: 3.6, part: 1.0 },
        says: "Dry (Coulomb) friction on q is missing from emps: magnitude 20.41 +- 0.12 N.".into(),
        curve: Some(friction_curve()),
    };
    let channel = ChannelMismatch {
        depends_on: None,
        region: std::collections::BTreeMap::new(),
        time: None,
        explained_by: vec!["coulomb_friction".into()],
        significance: 9120.4,
        missing_force: 19.62,
        unit: "N".into(),
        curves: vec![lawless("dq", "m/s"), lawless("t", "s")],
    };
    let calibration = |nominal, value, std, unit: &str| Calibration {
        nominal,
        value,
        std,
        unit: unit.into(),
        at_bound: false,
    };
    let rung = |what: &str, share| Rung { what: what.into(), share };
    Diagnosis {
        schema: SCHEMA,
        model: "emps".into(),
        robot: None,
        verdict: Verdict::MissingPhysics,
        otherwise: None,
        findings: vec![finding],
        formula: Some(FormulaFit { left: 0.031, residual_over_noise: 1.43 }),
        calibration: map([
            ("mass", calibration(95.1, 95.45, 0.31, "kg")),
            ("viscous", calibration(203.5, 214.2, 1.9, "N s/m")),
        ]),
        location: Location { channels: map([("q", channel)]) },
        proof: ProofOutcome::Better,
        fit: Fit {
            held_out: map([("q", errors("m", 2.1e-5, [0.004_31, 2.34e-5], [0.0873, 0.000_412]))]),
            training: map([("q", errors("m", 2.1e-5, [0.004_4, 2.3e-5], [0.09, 0.000_4]))]),
            by_recording: BTreeMap::new(),
        },
        ladder: vec![
            rung("calibration", 0.031),
            rung("dry (Coulomb) friction on q", 0.947),
            rung("unexplained", 0.022),
        ],
        driving: Driving::default(),
        integration: Integration {
            steps_a_sample: 1,
            cut_where_slopes_jump: false,
            error_over_noise: 0.002,
        },
        data: DataUsed {
            training: vec!["pulses.csv".into()],
            held_out: vec!["trajectory.csv".into()],
            samples: 24_841,
            dropped: 12,
            outliers: [("q".to_owned(), 3)].into(),
            unmeasured: vec!["current".into()],
            version: "0.1.0".into(),
        },
        notes: vec![
            "Stribeck friction cannot be excluded: the drive is seldom slower than 2 mm/s.".into(),
        ],
    }
}

/// A two-link arm with two findings, the second undecided, on four measured channels.
pub fn two_findings() -> Diagnosis {
    let mut d = missing();
    d.model = "two_link".into();
    let mut second = d.findings[0].clone();
    second.class = "coupling_stiffness".into();
    (second.channel, second.other) = ("q1".into(), Some("q2".into()));
    second.depends_on = vec!["q1".into(), "q2".into()];
    second.region = map([("q1", [-1.2, 1.31]), ("q2", [-2.04, 1.9])]);
    second.parameters = map([("stiffness", estimate(3.161, 0.87, "N m/rad"))]);
    second.probability = 0.58;
    second.alternatives[0].class = "linear_stiffness".into();
    second.alternatives[0].probability = 0.41;
    second.says = "Coupling stiffness on q1 and q2 is missing from two_link: 3.2 +- 0.9.".into();
    second.curve = None;
    d.findings.push(second);
    let channel = |by: &[&str], nats, force| ChannelMismatch {
        depends_on: None,
        region: std::collections::BTreeMap::new(),
        time: None,
        explained_by: by.iter().map(|&c| c.into()).collect(),
        significance: nats,
        missing_force: force,
        unit: "N m".into(),
        curves: vec![],
    };
    d.location.channels = map([
        ("q1", channel(&["coupling_stiffness"], 31.4, 0.73)),
        ("q2", channel(&["coulomb_friction", "coupling_stiffness"], 2210.0, 2.31)),
    ]);
    d.fit.held_out = map([
        ("q1", errors("rad", 0.002, [0.0131, 0.002_2], [0.41, 0.0067])),
        ("q2", errors("rad", 0.002, [0.0873, 0.002_1], [f64::INFINITY, 0.0099])),
        ("dq1", errors("rad/s", 0.01, [0.0312, 0.0330], [0.82, 0.013])),
        ("dq2", errors("rad/s", 0.01, [0.41, 0.0107], [2.4, 0.021])),
    ]);
    d
}

/// A robot whose file has no friction, on either joint, and no payload.
pub fn robot() -> Diagnosis {
    let mut d = missing();
    d.model = "arm".into();
    let joint = |name: &str, link: &str| Joint {
        name: name.into(),
        velocity: format!("{name}_vel"),
        input: format!("{name}_torque"),
        link: link.into(),
        damping: 0.3,
        friction: 0.0,
        armature: 0.0,
        stiffness: 0.0,
    };
    let joints = vec![joint("shoulder", "upper"), joint("elbow", "lower")];
    d.robot = Some(Robot { format: "URDF".into(), joints });
    let dry = d.findings.remove(0);
    let friction = |joint: &str, class: &str, probability| {
        let mut finding = Finding { channel: joint.into(), probability, ..dry.clone() };
        finding.class = class.into();
        finding.curve.as_mut().expect("a curve").variable = format!("{joint}_vel");
        finding
    };
    let mut peaked = friction("elbow", "stribeck_friction", 0.88);
    peaked.parameters = map([
        ("coulomb", estimate(0.35, 0.01, "N m")),
        ("static", estimate(0.5, 0.02, "N m")),
        ("stribeck_velocity", estimate(0.1, 0.01, "rad/s")),
    ]);
    let mut payload = Finding { curve: None, ..friction("lower", "payload", 0.99) };
    payload.parameters = map([("mass", estimate(0.3, 0.01, "kg"))]);
    d.findings = vec![friction("shoulder", "coulomb_friction", 0.972), peaked, payload];
    d.location.channels = map([]);
    d
}

/// A model that is right.
pub fn null() -> Diagnosis {
    let mut d = missing();
    d.verdict = Verdict::NoMismatch;
    d.findings.clear();
    d.formula = None;
    d.calibration.clear();
    d.notes.clear();
    d.ladder.clear();
    d.location.channels = map([(
        "q",
        ChannelMismatch {
            depends_on: None,
            region: std::collections::BTreeMap::new(),
            time: None,
            explained_by: vec![],
            significance: 1.2,
            missing_force: 0.08,
            unit: "N".into(),
            curves: vec![],
        },
    )]);
    d.fit.held_out = map([("q", errors("m", 2.1e-5, [2.13e-5, 2.13e-5], [4e-5, 4e-5]))]);
    d
}

/// A wrong model that the catalogue does not explain, with names that must be escaped.
pub fn unexplained() -> Diagnosis {
    let mut d = two_findings();
    d.verdict = Verdict::Unexplained;
    d.model = "arm <script>alert(1)</script> & \"sons\"".into();
    d.findings.clear();
    d.formula = None;
    d.location.channels.values_mut().for_each(|m| {
        m.explained_by.clear();
        m.curves = vec![lawless("dq", "m/s"), lawless("t", "s")];
    });
    let hostile = d.location.channels["q2"].clone();
    d.location.channels.insert(HOSTILE.into(), hostile);
    d.ladder.remove(1);
    d.ladder[1].share = 0.969;
    d.data.held_out = vec!["run <b>7</b>.csv".into(), "x".repeat(300)];
    d.fit.held_out.insert(HOSTILE.into(), errors("rad", 0.002, [0.3, 0.31], [0.4, 0.4]));
    d.fit.held_out.insert("q<2>".into(), errors("rad", 0.0, [0.3, 0.31], [0.4, f64::INFINITY]));
    d
}

/// Free runs of `samples` samples, the model before falling behind.
pub fn proof(recording: &str, channel: &str, samples: usize) -> Proof {
    let time: Vec<f64> = (0..samples).map(|k| 24.0 * k as f64 / samples as f64).collect();
    let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Vec<f64>>();
    let truth = |t: f64| 0.11 * (0.9 * t).sin() + 0.05 * (2.3 * t).sin();
    Proof {
        recording: recording.into(),
        channel: channel.into(),
        unit: "m".into(),
        measured: of(&|t| truth(t) + 2e-4 * (977.0 * t).sin()),
        before: of(&|t| 1.35 * truth(t - 0.09) + 0.004 * t),
        after: of(&|t| truth(t) + 3e-4 * t.sin()),
        time,
        ..Proof::default()
    }
}
