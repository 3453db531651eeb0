//! Parameters and signals at the edge of what makes sense: nothing may stop being a number.

mod support;

use lacuna_effects::{CATALOGUE, Kind, Law, Range};
use support::{Force, Local, series_law};

/// Values of a parameter from tiny to huge, within its range.
fn extremes(range: Range, kind: Kind) -> Vec<f64> {
    if kind == Kind::Variable {
        return vec![0.0, 1.0, 2.0];
    }
    let all = [-1e6, -1e-12, 0.0, 1e-300, 1e-12, 1.0, 1e6];
    all.into_iter().filter(|v| range.contains(*v)).collect()
}

/// Physical parameters with one at a time at an extreme.
fn parameters(effect: &'static lacuna_effects::Effect) -> Vec<Vec<f64>> {
    let plain: Vec<f64> =
        effect.values().map(|p| if p.kind == Kind::Variable { 0.0 } else { 1.0 }).collect();
    let mut out = vec![];
    for (k, p) in effect.values().enumerate() {
        for value in extremes(p.range, p.kind) {
            let mut physical = plain.clone();
            physical[k] = value;
            out.push(physical);
        }
    }
    out
}

#[test]
fn forces_and_memories_stay_finite() {
    let values = [0.0, 1e-300, -1e-12, 1.0, -1e6, 1e6];
    for effect in CATALOGUE {
        let Some(law) = Force::of(effect) else { continue };
        for physical in parameters(effect) {
            let internal = law.internal(&physical);
            let (amplitudes, shape) = internal.split_at(law.amplitudes());
            for q in values {
                for v in values {
                    let at = Local { t: q, q, v, other_q: v, other_v: q, acceleration: q, u: v };
                    let mut memory = vec![0.0; law.memory()];
                    law.memory_at_rest(&at, &mut memory);
                    let mut basis = vec![f64::NAN; law.amplitudes()];
                    let mut rate = vec![f64::NAN; law.memory()];
                    law.basis(shape, &at, &memory, &mut basis);
                    law.memory_rate(shape, &at, &memory, &mut rate);
                    let all = amplitudes.iter().chain(&basis).chain(&rate);
                    // A time constant of 1e-300 s is faster than a number can say.
                    let too_fast = physical.contains(&1e-300) && law.memory() > 0;
                    let finite = all.clone().all(|x| x.is_finite());
                    let number = all.clone().all(|x| !x.is_nan());
                    assert!(number && (finite || too_fast), "{} {physical:?} {at:?}", effect.class);
                }
            }
        }
    }
}

/// Sample times that are early and late, close together and far apart.
const TIMES: [f64; 6] = [-3.0, -2.999_999, 0.0, 0.5, 0.500_001, 1e4];
const SERIES: [f64; 6] = [2.0, -1.0, 0.0, 1e6, -1e6, 3.0];

#[test]
fn actuators_and_sensors_stay_finite_on_uneven_samples() {
    for effect in CATALOGUE {
        for physical in parameters(effect) {
            let found = match effect.law {
                Law::Force(_) | Law::Structure(_) => continue,
                Law::Input(law) | Law::Sensor(law) => {
                    law.plain().applied(&physical, &TIMES, &SERIES)
                }
            };
            assert_eq!(found.len(), SERIES.len());
            let finite = found.iter().all(|v| v.is_finite());
            assert!(finite, "{} {physical:?}: {found:?}", effect.class);
        }
    }
}

#[test]
fn an_empty_series_stays_empty() {
    for effect in CATALOGUE {
        for physical in parameters(effect) {
            let found = match effect.law {
                Law::Force(_) | Law::Structure(_) => continue,
                Law::Input(law) | Law::Sensor(law) => law.plain().applied(&physical, &[], &[]),
            };
            assert!(found.is_empty(), "{}", effect.class);
        }
    }
}

/// What arrives after the recording ends leaves it with what was there before: the first command.
#[test]
fn delays_and_lags_longer_than_any_recording_show_the_first_command() {
    for delay in [3e4, 1e9, 1e18, 1e300] {
        let found = series_law("input_delay").plain().applied(&[delay], &TIMES, &SERIES);
        assert_eq!(found, [SERIES[0]; 6], "delay of {delay}");
    }
    for time_constant in [1e18, 1e300] {
        let found =
            series_law("actuator_lag").plain().applied(&[time_constant, 1.0], &TIMES, &SERIES);
        let far = found.iter().map(|u| (u - SERIES[0]).abs()).fold(0.0, f64::max);
        assert!(far < 1e-6, "lag of {time_constant}: {found:?}");
    }
}
