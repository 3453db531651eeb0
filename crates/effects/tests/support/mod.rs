//! Force laws at a place and time, in plain numbers.
#![allow(dead_code)]

use lacuna_effects::{AnyForceLaw, AnySeriesLaw, At, Channel, Effect, Law, find};
use std::ops::Deref;

/// A channel, one other and an input, with the laws' memory apart.
#[derive(Clone, Copy, Debug, Default)]
pub struct Local {
    pub t: f64,
    pub q: f64,
    pub v: f64,
    pub other_q: f64,
    pub other_v: f64,
    pub acceleration: f64,
    pub u: f64,
}

/// Where the state of a [`Local`] has its channels.
pub const CHANNELS: [Channel; 2] = [Channel::ALONE[0], Channel { q: 2, v: 3, si: 1.0 }];
/// The same for a law that names the input.
const WITH_INPUT: [Channel; 2] = [CHANNELS[0], Channel::input(0)];

/// What the law of an effect sees beside its channel.
pub fn channels(effect: &Effect) -> &'static [Channel] {
    if effect.names_input() { &WITH_INPUT } else { &CHANNELS }
}

impl Local {
    pub fn state(&self) -> [f64; 4] {
        [self.q, self.v, self.other_q, self.other_v]
    }

    fn at<'a>(&'a self, state: &'a [f64], memory: &'a [f64], channels: &'a [Channel]) -> At<'a> {
        let inputs = std::slice::from_ref(&self.u);
        At { memory, inputs, acceleration: self.acceleration, ..At::new(self.t, state, channels) }
    }
}

/// A force law of the catalogue, and the channels that it sees.
#[derive(Clone, Copy)]
pub struct Force {
    law: &'static dyn AnyForceLaw,
    channels: &'static [Channel],
}

impl Force {
    pub fn named(class: &str) -> Self {
        let effect = find(class).unwrap_or_else(|| panic!("{class} is in no catalogue"));
        Self::of(effect).unwrap_or_else(|| panic!("{class} is no force"))
    }

    pub fn of(effect: &Effect) -> Option<Self> {
        let Law::Force(law) = effect.law else { return None };
        Some(Self { law, channels: channels(effect) })
    }

    pub fn basis(&self, shape: &[f64], at: &Local, memory: &[f64], basis: &mut [f64]) {
        self.law.plain().along(shape, &at.at(&at.state(), memory, self.channels), basis);
    }

    pub fn memory_rate(&self, shape: &[f64], at: &Local, memory: &[f64], rate: &mut [f64]) {
        self.law.plain().memory_rate(shape, &at.at(&at.state(), memory, self.channels), rate);
    }

    pub fn memory_at_rest(&self, at: &Local, memory: &mut [f64]) {
        self.law.memory_at_rest(&at.at(&at.state(), &[], self.channels), memory);
    }

    /// The force per unit of amplitude at the end of each RK4 step of `h` along a motion that is given
    /// at every time, from rest: what is checked, integrated apart.
    pub fn along(
        &self,
        shape: &[f64],
        motion: impl Fn(f64) -> Local,
        h: f64,
        steps: usize,
    ) -> Vec<f64> {
        let rate = |t: f64, z: &[f64], slope: &[f64], by: f64| {
            let moved: Vec<f64> = z.iter().zip(slope).map(|(z, s)| z + by * s).collect();
            let mut rate = vec![f64::NAN; z.len()];
            self.memory_rate(shape, &motion(t), &moved, &mut rate);
            rate
        };
        let mut z = vec![f64::NAN; self.memory()];
        self.memory_at_rest(&motion(0.0), &mut z);
        let still = vec![0.0; z.len()];
        let step = |k: usize| {
            let t = h * k as f64;
            let k1 = rate(t, &z, &still, 0.0);
            let k2 = rate(t + 0.5 * h, &z, &k1, 0.5 * h);
            let k3 = rate(t + 0.5 * h, &z, &k2, 0.5 * h);
            let k4 = rate(t + h, &z, &k3, h);
            for (i, z) in z.iter_mut().enumerate() {
                *z += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
            let mut basis = [f64::NAN];
            self.basis(shape, &motion(t + h), &z, &mut basis);
            basis[0]
        };
        (0..steps).map(step).collect()
    }
}

impl Deref for Force {
    type Target = dyn AnyForceLaw;

    fn deref(&self) -> &Self::Target {
        self.law
    }
}

/// The law of an input or sensor effect.
pub fn series_law(class: &str) -> &'static dyn AnySeriesLaw {
    match find(class).unwrap_or_else(|| panic!("{class} is in no catalogue")).law {
        Law::Input(law) | Law::Sensor(law) => law,
        Law::Force(_) | Law::Structure(_) => panic!("{class} is no law of a series"),
    }
}
