//! Force laws at a place and time, in plain numbers.
#![allow(dead_code)]

use lacuna_effects::{AnyForceLaw, AnySeriesLaw, At, Channel, Law, find};
use std::ops::Deref;

/// A channel and one other, with the laws' memory apart.
#[derive(Clone, Copy, Debug, Default)]
pub struct Local {
    pub t: f64,
    pub q: f64,
    pub v: f64,
    pub other_q: f64,
    pub other_v: f64,
    pub acceleration: f64,
}

/// Where the state of a [`Local`] has its channels.
pub const CHANNELS: [Channel; 2] = [Channel { q: 0, v: 1 }, Channel { q: 2, v: 3 }];

impl Local {
    pub fn state(&self) -> [f64; 4] {
        [self.q, self.v, self.other_q, self.other_v]
    }

    fn at<'a>(&self, state: &'a [f64], memory: &'a [f64]) -> At<'a> {
        At { memory, acceleration: self.acceleration, ..At::new(self.t, state, &CHANNELS) }
    }
}

/// A force law of the catalogue.
#[derive(Clone, Copy)]
pub struct Force(pub &'static dyn AnyForceLaw);

impl Force {
    pub fn named(class: &str) -> Self {
        match find(class).unwrap_or_else(|| panic!("{class} is in no catalogue")).law {
            Law::Force(law) => Self(law),
            _ => panic!("{class} is no force"),
        }
    }

    pub fn basis(&self, shape: &[f64], at: &Local, memory: &[f64], basis: &mut [f64]) {
        self.0.plain().along(shape, &at.at(&at.state(), memory), basis);
    }

    pub fn memory_rate(&self, shape: &[f64], at: &Local, memory: &[f64], rate: &mut [f64]) {
        self.0.plain().memory_rate(shape, &at.at(&at.state(), memory), rate);
    }

    pub fn memory_at_rest(&self, at: &Local, memory: &mut [f64]) {
        self.0.memory_at_rest(&at.at(&at.state(), &[]), memory);
    }
}

impl Deref for Force {
    type Target = dyn AnyForceLaw;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

/// The law of an input or sensor effect.
pub fn series_law(class: &str) -> &'static dyn AnySeriesLaw {
    match find(class).unwrap_or_else(|| panic!("{class} is in no catalogue")).law {
        Law::Input(law) | Law::Sensor(law) => law,
        Law::Force(_) => panic!("{class} is a force"),
    }
}
