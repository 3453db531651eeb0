//! Pictures of force laws: which one suits a law.

use lacuna_effects::{AnyForceLaw, Effect};
use nalgebra::DMatrix;

use super::rig::{Moment, Rig};
use super::{Drawn, curve, resonance, trace, typical};

/// A force law on the rig that suits it, with its parameters.
#[derive(Debug)]
pub struct Force<'a> {
    /// What is said of it.
    pub effect: &'a Effect,
    /// What moves.
    pub rig: &'a Rig,
    law: &'static dyn AnyForceLaw,
    amplitudes: Vec<f64>,
    shape: Vec<f64>,
}

impl<'a> Force<'a> {
    fn new(
        effect: &'a Effect,
        law: &'static dyn AnyForceLaw,
        rig: &'a Rig,
        internal: &[f64],
    ) -> Self {
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        Self { effect, rig, law, amplitudes: amplitudes.to_vec(), shape: shape.to_vec() }
    }

    fn typical(effect: &'a Effect, law: &'static dyn AnyForceLaw, rig: &'a Rig) -> Self {
        Self::new(effect, law, rig, &typical::parameters(effect, &rig.scales))
    }

    /// Another law of its family in its place; none where it is the simplest itself.
    #[must_use]
    pub fn simplest(&self) -> Option<Force<'a>> {
        let other = typical::simplest(self.effect)?;
        let lacuna_effects::Law::Force(law) = other.law else { return None };
        let own = [&self.amplitudes[..], &self.shape].concat();
        let own = typical::physical(self.effect, &own);
        let written = self.effect.written_as(other, &own, &self.rig.scales);
        let internal = typical::internal(other, written.first()?);
        Some(Self::new(other, law, self.rig, &internal))
    }

    /// The force along a motion from rest, that of its inertia included.
    #[must_use]
    pub fn along(&self, motion: &[Moment]) -> Vec<f64> {
        let Some(first) = motion.first() else { return vec![] };
        let mut memory = vec![0.0; self.law.memory()];
        let state = first.state();
        self.law.memory_at_rest(&first.at(self.rig, self.effect, &state, &[]), &mut memory);
        let states: Vec<[f64; 4]> = motion.iter().map(Moment::state).collect();
        let seen = motion.iter().zip(&states);
        let seen: Vec<_> =
            seen.map(|(m, state)| m.at(self.rig, self.effect, state, &memory)).collect();
        let mut series = vec![vec![]; self.amplitudes.len()];
        self.law.plain().series(&self.shape, &seen, &mut series);
        let at = |k: usize| self.amplitudes.iter().zip(&series).map(|(a, s)| a * s[k]).sum();
        (0..motion.len()).map(at).collect()
    }

    /// The force at one moment; its memory is at rest there.
    #[must_use]
    pub fn at(&self, moment: Moment) -> f64 {
        self.along(&[moment]).first().copied().unwrap_or(f64::NAN)
    }

    /// Of the opposite of the force, what acts on the other channel; none where nothing does.
    #[must_use]
    pub fn passed_on(&self) -> Option<f64> {
        self.law.reacts().then(|| self.law.plain().passed_on(&self.shape))
    }

    /// Whether it remembers anything.
    #[must_use]
    pub fn remembers(&self) -> bool {
        self.law.memory() > 0
    }

    /// Whether its memory swings by itself where nothing moves: the rates of small departures from rest
    /// have complex eigenvalues.
    #[must_use]
    pub fn rings(&self) -> bool {
        let n = self.law.memory();
        let moment = self.rig.rest();
        let state = moment.state();
        let mut rest = vec![0.0; n];
        self.law.memory_at_rest(&moment.at(self.rig, self.effect, &state, &[]), &mut rest);
        let rate = |memory: &[f64]| {
            let mut rate = vec![0.0; n];
            let at = moment.at(self.rig, self.effect, &state, memory);
            self.law.plain().memory_rate(&self.shape, &at, &mut rate);
            rate
        };
        let still = rate(&rest);
        let column = |k: usize| {
            let mut departed = rest.clone();
            departed[k] += 1e-3;
            rate(&departed).into_iter().zip(&still).map(|(a, b)| 1e3 * (a - b)).collect()
        };
        let columns: Vec<f64> = (0..n).flat_map(|k| -> Vec<f64> { column(k) }).collect();
        let rates = DMatrix::from_column_slice(n, n, &columns);
        n > 0 && rates.complex_eigenvalues().iter().any(|rate| rate.im != 0.0)
    }
}

/// What a picture shows of a force law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// A curve against a variable.
    Curve,
    /// The way along a motion.
    Trace,
    /// The answer to every frequency.
    Resonance,
}

impl Shows {
    fn of(force: &Force) -> Self {
        match () {
            () if force.rings() => Self::Resonance,
            () if force.remembers() || force.effect.nature.edge => Self::Trace,
            () => Self::Curve,
        }
    }
}

/// What the picture of an effect shows.
#[must_use]
pub fn shows(effect: &Effect, law: &'static dyn AnyForceLaw) -> Shows {
    let rig = Rig::of(effect);
    Shows::of(&Force::typical(effect, law, &rig))
}

/// The picture of a force law.
#[must_use]
pub fn drawn(effect: &Effect, law: &'static dyn AnyForceLaw) -> Drawn {
    let rig = Rig::of(effect);
    let force = Force::typical(effect, law, &rig);
    match Shows::of(&force) {
        Shows::Resonance => resonance::drawn(&force),
        Shows::Trace => trace::drawn(&force),
        Shows::Curve => curve::drawn(&force),
    }
}
