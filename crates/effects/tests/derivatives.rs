//! Every law's derivatives, as dual numbers carry them, against central differences at points
//! drawn from a seed.

use lacuna_effects::SeriesLawIn;
use lacuna_effects::{
    AnyForceLaw, At, CATALOGUE, Channel, Effect, ForceLawIn, Kind, Law, Range, find,
};
use lacuna_numbers::{Dual, Number};

mod support;

use support::channels;

const STATES: usize = 4;
const POINTS: u64 = 40;

/// Numbers between 0 and 1 (SplitMix64).
struct Draw(u64);

impl Draw {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    fn physical(&mut self, effect: &'static Effect) -> Vec<f64> {
        let mut value = |p: &lacuna_effects::Parameter| match (p.kind, p.name, p.range) {
            (Kind::Side, ..) => {
                if self.number() < 0.5 {
                    -1.0
                } else {
                    1.0
                }
            }
            (Kind::Variable, ..) => (3.0 * self.number()).floor(),
            (_, "from", _) => -1.3,
            (_, "to", _) => 1.7,
            (_, _, Range::Any) => self.between(-1.5, 1.5),
            _ => self.between(0.2, 1.5),
        };
        effect.values().map(&mut value).collect()
    }
}

/// Compare the derivatives of `dual` by some entries of `x` with central differences of `plain`;
/// entries beside a kink, where the differences to both sides are not one, are passed over. How
/// many were compared.
fn compare(
    what: &str,
    x: &[f64],
    entries: &[usize],
    plain: &dyn Fn(&[f64]) -> Vec<f64>,
    dual: &dyn Fn(&[Dual]) -> Vec<Dual>,
) -> usize {
    const H: f64 = 1e-6;
    let here = plain(x);
    let moved = |k: usize, by: f64| {
        let mut x = x.to_vec();
        x[k] += by;
        plain(&x)
    };
    let mut compared = 0;
    for &k in entries {
        let lane = k % lacuna_numbers::LANES;
        let mut numbers: Vec<Dual> = x.iter().map(|&x| Dual::constant(x)).collect();
        numbers[k].tangent[lane] = 1.0;
        let (found, ahead, behind) = (dual(&numbers), moved(k, H), moved(k, -H));
        assert_eq!(found.len(), here.len(), "{what}");
        for (i, y) in found.iter().enumerate() {
            assert!((y.value - here[i]).abs() <= 1e-14 * here[i].abs(), "{what}: value {i}");
            let size = 1.0 + here[i].abs();
            let (right, left) = ((ahead[i] - here[i]) / H, (here[i] - behind[i]) / H);
            let central = 0.5 * (right + left);
            // What a bent line bends within two steps is little beside a kink.
            if (right - left).abs() > 1e-3 * (size + central.abs()) {
                continue;
            }
            let error = (y.tangent[lane] - central).abs();
            assert!(
                error < 1e-6 * (size + central.abs()),
                "{what}: output {i} by entry {k}: {} is not {central}",
                y.tangent[lane]
            );
            assert!(
                y.tangent.iter().enumerate().all(|(l, t)| l == lane || *t == 0.0),
                "{what}: output {i} has derivatives that nobody asked for"
            );
            compared += 1;
        }
    }
    compared
}

/// Lengths of what a force law takes.
#[derive(Clone, Copy)]
struct Sizes {
    memory: usize,
    amplitudes: usize,
}

/// Force, inertia, force along a motion and memory's rate, of the state, an input, the acceleration,
/// the memory, the amplitudes and the shape.
fn evaluate<T: Number>(
    law: &dyn ForceLawIn<T>,
    (channels, sizes): (&[Channel], Sizes),
    t: f64,
    x: &[T],
) -> Vec<T> {
    let (state, rest) = x.split_at(STATES);
    let (inputs, rest) = rest.split_at(1);
    let (acceleration, rest) = rest.split_at(1);
    let (memory, rest) = rest.split_at(sizes.memory);
    let (amplitudes, shape) = rest.split_at(sizes.amplitudes);
    let acceleration = acceleration[0];
    let at = At { memory, inputs, acceleration, ..At::new(t, state, channels) };
    let none = T::constant(0.0);
    let (mut basis, mut rate) = (vec![none; sizes.amplitudes], vec![none; sizes.memory]);
    law.along(shape, &at, &mut basis);
    law.memory_rate(shape, &at, &mut rate);
    let mut out = vec![law.force(amplitudes, shape, &at), law.inertia(amplitudes, shape, &at)];
    out.extend(basis);
    out.extend(rate);
    out
}

fn compare_force(effect: &'static Effect, law: &'static dyn AnyForceLaw, draw: &mut Draw) -> usize {
    let physical = draw.physical(effect);
    let internal = law.internal(&physical);
    let sizes = Sizes { memory: law.memory(), amplitudes: law.amplitudes() };
    let mut x: Vec<f64> = (0..STATES + 2 + sizes.memory).map(|_| draw.between(-1.4, 1.4)).collect();
    let first = x.len();
    x.extend(&internal);
    // Neither a choice nor the time of an event is a quantity that the law varies smoothly with.
    let event =
        |j: usize| effect.values().nth(j).is_some_and(|p| Some(p.name) == effect.nature.onset);
    let choice = |j: usize| effect.values().nth(j).is_some_and(|p| p.kind == Kind::Variable);
    let entries: Vec<usize> =
        (0..x.len()).filter(|&k| k < first || !(event(k - first) || choice(k - first))).collect();
    let t = draw.between(0.0, 3.0);
    let seen = (channels(effect), sizes);
    let plain = |x: &[f64]| evaluate(law.plain(), seen, t, x);
    let dual = |x: &[Dual]| evaluate(law.dual(), seen, t, x);
    compare(effect.class, &x, &entries, &plain, &dual)
}

#[test]
fn forces_and_memory_rates_carry_their_derivatives() {
    for effect in CATALOGUE {
        let Law::Force(law) = effect.law else { continue };
        let mut draw = Draw(7);
        let compared: usize = (0..POINTS).map(|_| compare_force(effect, law, &mut draw)).sum();
        let all = STATES + 2 + law.memory() + law.amplitudes();
        assert!(compared > 30 * all, "{}: only {compared} were compared", effect.class);
    }
}

#[test]
fn actuators_and_sensors_carry_their_derivatives() {
    for effect in CATALOGUE {
        let (Law::Input(law) | Law::Sensor(law)) = effect.law else { continue };
        let mut draw = Draw(11);
        let mut compared = 0;
        for _ in 0..POINTS {
            let mut times = vec![draw.between(-1.0, 1.0)];
            for k in 0..9 {
                times.push(times[k] + draw.between(0.05, 0.4));
            }
            let mut x = draw.physical(effect);
            let parameters = x.len();
            x.extend(times.iter().map(|_| draw.between(-2.0, 2.0)));
            let entries: Vec<usize> = (0..x.len()).collect();
            fn of<T: Number>(law: &dyn SeriesLawIn<T>, times: &[f64], p: usize, x: &[T]) -> Vec<T> {
                law.applied(&x[..p], times, &x[p..])
            }
            let plain = |x: &[f64]| of(law.plain(), &times, parameters, x);
            let dual = |x: &[Dual]| of(law.dual(), &times, parameters, x);
            compared += compare(effect.class, &x, &entries, &plain, &dual);
        }
        assert!(compared > 3000, "{}: only {compared} were compared", effect.class);
    }
}

/// The derivative by the time of an event is that of a ramp over the sample after it: a step of
/// the time by one sample takes the force from one sample.
#[test]
fn the_time_of_a_step_is_told_to_one_sample() {
    let Law::Force(law) = find("step_change").expect("in the catalogue").law else { panic!() };
    let state = [0.0; 2].map(Dual::constant);
    let force = |t: f64, sample: f64| {
        let at = At { sample, ..At::new(t, &state, &Channel::ALONE) };
        law.dual().force(&[Dual::constant(3.0)], &[Dual::direction(2.0, 5)], &at)
    };
    let (before, during, after) = (force(1.99, 0.1), force(2.05, 0.1), force(2.11, 0.1));
    assert_eq!([before.value, during.value, after.value], [0.0, 3.0, 3.0]);
    assert_eq!([before.tangent[5], during.tangent[5], after.tangent[5]], [0.0, -30.0, 0.0]);
    assert_eq!(force(2.0, 0.0).tangent[5], 0.0);
}

/// A delay that begins at 0 can only grow: what it would show is what came before each sample.
#[test]
fn a_delay_of_nothing_looks_back() {
    let times = [0.0, 0.1, 0.3, 0.4];
    let series = [1.0, 4.0, -2.0, 3.0].map(Dual::constant);
    let by_delay = |class: &str| -> Vec<f64> {
        let (Law::Input(law) | Law::Sensor(law)) = find(class).expect("in the catalogue").law
        else {
            panic!("{class} is a force")
        };
        let seen = law.dual().applied(&[Dual::direction(0.0, 2)], &times, &series);
        assert!(seen.iter().zip(&series).all(|(a, b)| (a.value - b.value).abs() < 1e-15));
        seen.iter().map(|y| y.tangent[2]).collect()
    };
    let close = |found: Vec<f64>, expected: [f64; 4]| {
        let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{found:?} {expected:?}");
    };
    // The held value before each sample less its own, over the step: the last step is taken to
    // be as long as the one before it, and before the first sample its value was held.
    close(by_delay("input_delay"), [0.0, (1.0 - 4.0) / 0.2, (4.0 + 2.0) / 0.1, (-2.0 - 3.0) / 0.1]);
    // Less the slope of the line before each sample.
    close(by_delay("sensor_delay"), [-30.0, -30.0, 30.0, -50.0]);
}
