//! Sums over parts of the data make one model, whoever makes them.

use lacuna_occupation::{
    Arguments, Family, Identification, IdentificationError, InputPath, Motion, Stream, Sums,
};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

const COUNT: usize = 120;
const SAMPLES: usize = 51;
const STEP: f64 = 0.04;
const NOISE: f64 = 1e-3;

fn drift(q: f64, v: f64) -> f64 {
    -2.0 * q.sin() - 0.3 * v
}

/// q'' = -2 sin q - 0.3 q' + (1 + 0.5 cos q) u with u held from sample to sample.
fn motion(k: usize, rates: bool) -> Motion {
    let mut rng = lacuna_excitation::rng(3, k as u64);
    let mut x = [rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0)];
    let [a, w, p] = [1.5, rng.random_range(1.0..5.0), rng.random_range(0.0..6.0)];
    let (mut y, mut dy, mut inputs) = (Vec::new(), Vec::new(), Vec::new());
    let mut noise = |sd: f64| {
        let z: f64 = StandardNormal.sample(&mut rng);
        sd * z
    };
    for l in 0..SAMPLES {
        let u = a * (w * STEP * l as f64 + p).sin();
        y.push(x[0] + noise(NOISE));
        dy.push(x[1] + noise(NOISE));
        inputs.push(u);
        for _ in 0..40 {
            let h = STEP / 40.0;
            let acceleration = |[q, v]: [f64; 2]| drift(q, v) + (1.0 + 0.5 * q.cos()) * u;
            let middle = [x[0] + 0.5 * h * x[1], x[1] + 0.5 * h * acceleration(x)];
            x = [x[0] + h * middle[1], x[1] + h * acceleration(middle)];
        }
    }
    let times = (0..SAMPLES).map(|l| STEP * l as f64).collect();
    let motion = Motion::new(times, y, inputs).unwrap();
    if rates { motion.with_rates(dy).unwrap() } else { motion }
}

fn identification() -> Identification {
    let mut settings = Identification::new(2, Arguments::State, InputPath::Held);
    settings.families = vec![Family::Gaussian];
    settings.most_landmarks = 120;
    settings
}

/// The sums of ten parts, each by whoever; then pairs of pairs.
fn total(stream: &Stream, motions: &[Motion], threads: usize) -> Sums {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let part = |part: &[Motion]| {
        // As another process would.
        let stream = Stream::from_json(&stream.to_json()).unwrap();
        let mut sums = stream.none();
        pool.install(|| stream.add(&mut sums, part)).unwrap();
        Sums::from_bytes(&sums.to_bytes()).unwrap()
    };
    let mut sums: Vec<Sums> = motions.chunks(motions.len() / 10).map(part).collect();
    while sums.len() > 1 {
        sums = sums
            .chunks(2)
            .map(|pair| {
                let mut sum = pair[0].clone();
                pair[1..].iter().for_each(|other| sum.merge(other).unwrap());
                sum
            })
            .collect();
    }
    sums.remove(0)
}

#[test]
fn parts_by_anybody_make_the_same_model_and_a_right_one() {
    for rates in [false, true] {
        let motions: Vec<Motion> = (0..COUNT).map(|k| motion(k, rates)).collect();
        let stream = identification().stream(&motions[..60], COUNT * SAMPLES).unwrap();
        let (one, three) = (total(&stream, &motions, 1), total(&stream, &motions, 3));
        assert_eq!(one.to_bytes(), three.to_bytes());
        assert_eq!((one.motions, one.samples), (COUNT, COUNT * SAMPLES));
        let found = stream.solve(&one).unwrap();
        assert_eq!(found.model.to_json(), stream.solve(&three).unwrap().model.to_json());

        // Nothing but rounding depends on how the parts are cut.
        let mut whole = stream.none();
        stream.add(&mut whole, &motions).unwrap();
        let whole = stream.solve(&whole).unwrap().model;
        let few = stream.solve(&total(&stream, &motions[..20], 1)).unwrap().model;
        let [mut worst, mut worst_few, mut off] = [0.0f64; 3];
        for k in 0..25 {
            let x = [0.5 * f64::from(k % 5) - 1.0, 0.5 * f64::from(k / 5) - 1.0];
            let at = |model: &lacuna_occupation::IdentifiedModel| {
                let (mut f, mut g) = ([0.0], [0.0]);
                model.evaluate(&x, &mut f, &mut g).unwrap();
                [f[0], g[0]]
            };
            let ([f, g], again) = (at(&found.model), at(&whole));
            off = off.max((f - again[0]).abs()).max((g - again[1]).abs());
            assert!((f - drift(x[0], x[1])).abs() < 0.05, "{rates} {x:?}: f {f}");
            assert!((g - 1.0 - 0.5 * x[0].cos()).abs() < 0.05, "{rates} {x:?}: g {g}");
            let sd = |model: &lacuna_occupation::IdentifiedModel| {
                model.standard_deviations(&x).unwrap().unwrap().f[0]
            };
            worst = worst.max(sd(&found.model));
            worst_few = worst_few.max(sd(&few));
        }
        assert!(off < 1e-6, "{off}");
        assert!(worst > 0.0 && worst < 0.7 * worst_few, "{worst} {worst_few}");
        assert!(found.report.noise_sd.iter().all(|sd| (0.3..3.0).contains(&(sd / NOISE))));
    }
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let motions: Vec<Motion> = (0..40).map(|k| motion(k, true)).collect();
    let mut settings = identification();
    settings.most_landmarks = 30;
    let stream = settings.stream(&motions, 40 * SAMPLES).unwrap();
    let mut sums = stream.none();
    assert!(matches!(stream.solve(&sums), Err(IdentificationError::NoMotion)));
    let error = stream.add(&mut sums, &[motion(0, false)]).unwrap_err();
    assert!(matches!(error, IdentificationError::Shape { motion: 0 }), "{error}");
    settings.most_landmarks = 10;
    let other = settings.stream(&motions, 40 * SAMPLES).unwrap().none();
    let error = sums.merge(&other).unwrap_err().to_string();
    assert!(error.starts_with("these are sums of other data: expected"), "{error}");
    let bytes = sums.to_bytes();
    assert!(Sums::from_bytes(&bytes[..bytes.len() - 1]).is_err());
    let none = Sums::from_bytes(&[0; 3]).unwrap_err().to_string();
    assert!(none.starts_with("3 bytes are no sums"), "{none}");
    let few = [0, 1, 2, 3, 4].map(|k| f64::from(k) * STEP).to_vec();
    let short = Motion::new(few, vec![0.1, 0.2, 0.1, 0.0, 0.1], vec![0.0; 5]).unwrap();
    let short = short.with_rates(vec![0.0; 5]).unwrap();
    let error = stream.add(&mut stream.none(), &[short]).unwrap_err().to_string();
    assert!(error.contains("samples"), "{error}");
}
