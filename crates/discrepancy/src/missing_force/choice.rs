//! Which variables the missing force depends on.

use super::evidence::{Evidence, Part, Supposed};
use rayon::prelude::*;

/// What is chosen.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub supposed: Supposed,
    /// Nats that each part gained when it was added.
    pub gains: Vec<f64>,
}

/// Most of a white force, and smoothness, length and size, to begin with: a stiff function that
/// is to explain all, and a lively one beside what nothing has explained.
const START: [(usize, [usize; 3]); 2] = [(1, [1, 4, 5]), (usize::MAX, [0, 2, 6])];

/// The variable of most evidence, then others as long as they are significant.
/// A further variable must gain `least` nats.
pub(super) fn choose(evidence: &Evidence, least: f64) -> Option<Chosen> {
    let (null, mut top) = evidence.best(&Supposed { white: 1, parts: vec![] })?;
    let mut chosen = Chosen { supposed: null, gains: vec![] };
    for round in 0..evidence.variables.len() {
        let used = |v: &usize| chosen.supposed.parts.iter().any(|p| p.variable == *v);
        let tried = (0..evidence.variables.len()).filter(|v| !used(v)).flat_map(|variable| {
            START.map(|(white, grid)| {
                let mut supposed = chosen.supposed.clone();
                supposed.white = white.min(supposed.white);
                supposed.parts.push(Part { variable, grid });
                supposed
            })
        });
        let tried: Vec<Supposed> = tried.collect();
        let found: Vec<_> = tried.par_iter().map(|s| evidence.best(s)).collect();
        let best = found.into_iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((supposed, evidence)) = best else { break };
        if round > 0 && evidence - top < least {
            break;
        }
        chosen.gains.push(evidence - top);
        (chosen.supposed, top) = (supposed, evidence);
    }
    (!chosen.gains.is_empty()).then_some(chosen)
}
