//! Other ways to name what an effect does, begun from its fit: what a screening along a
//! trajectory cannot tell apart, and laws that hold one another as special cases.

use super::forward::{Tried, rank};
use super::{Search, chain};
use crate::candidates::Candidate;
use crate::likelihood::evidence::common_temperature;
use crate::likelihood::{Effort, FULL, Fit};
use lacuna_effects::find;
use lacuna_plants::model::ModelEffect;
use rayon::prelude::*;

impl<'p> Search<'p> {
    /// Add to the fitted candidates the other laws of dry friction where one is among the best.
    pub(super) fn add_variants(&self, tried: &mut Vec<Tried<'p>>) {
        rank(tried);
        let best = tried.iter().take(2).find(|t| t.candidate.is_dry_friction());
        let more = best.map_or(vec![], |best| {
            let last = best.fit.hypothesis.supposed().len() - 1;
            self.variants(&best.fit, last)
        });
        let temperature = common_temperature(tried.iter().chain(&more).map(|t| &t.fit));
        let evidence = |t: &Tried| t.fit.log_evidence(temperature);
        for new in more {
            match tried.iter_mut().find(|t| t.candidate == new.candidate) {
                Some(old) if evidence(old) < evidence(&new) => *old = new,
                Some(_) => {}
                None => tried.push(new),
            }
        }
    }

    /// The best of the other laws in the place of effect `k`.
    pub(super) fn best_variant(&self, fit: &Fit<'p>, k: usize) -> Option<Tried<'p>> {
        let own = super::candidate_of(fit.hypothesis.supposed().get(k)?);
        let mut tried = self.variants(fit, k);
        tried.retain(|t| t.candidate != own);
        rank(&mut tried);
        tried.into_iter().next()
    }

    /// A fit with effect `k` written as the law that it holds as a special case, at its best.
    pub(super) fn special_case<'f>(&self, fit: &Fit<'f>, k: usize) -> Option<Fit<'f>> {
        let fitted = fit.hypothesis.supposed().get(k)?;
        let mut others = other_friction(fitted, self).into_iter();
        let simple = others.find(|e| e.effect.parameters.len() < fitted.effect.parameters.len())?;
        let plain = fit.hypothesis.clone().without(k);
        fit.refit(self.with(&plain, simple), FULL).ok()
    }

    /// Effect `k` of a fit written with the other laws of its kind, each at its best.
    fn variants(&self, fit: &Fit<'p>, k: usize) -> Vec<Tried<'p>> {
        let Some(fitted) = fit.hypothesis.supposed().get(k) else { return vec![] };
        let plain = fit.hypothesis.clone().without(k);
        let glance = Effort { steps: 3, least: 0.3 };
        let glanced: Vec<Option<Tried>> = other_friction(fitted, self)
            .into_par_iter()
            .map(|effect| {
                let candidate = super::candidate_of(&effect);
                let fit = fit.refit(self.with(&plain, effect), glance).ok()?;
                Some(Tried { candidate, fit })
            })
            .collect();
        let mut glanced: Vec<Tried> = glanced.into_iter().flatten().collect();
        rank(&mut glanced);
        let mut best: Vec<Tried> = vec![];
        for t in glanced {
            if best.iter().all(|b| b.candidate != t.candidate) {
                best.push(t);
            }
        }
        let polish = |t: Tried<'p>| Tried { fit: chain::polish(t.fit), ..t };
        best.into_par_iter().map(polish).collect()
    }
}

/// A dry friction written with the other laws of dry friction, as far as their parameters
/// correspond. The Stribeck peak may be anywhere between creeping and full speed.
fn other_friction(fitted: &ModelEffect, search: &Search) -> Vec<ModelEffect> {
    let p = &fitted.parameters;
    let (magnitude, offset, smoothing) = match fitted.effect.class {
        "coulomb_friction" => (p[0], 0.0, p[1]),
        "asymmetric_friction" => (0.5 * (p[0] + p[1]), 0.5 * (p[1] - p[0]), p[2]),
        "stribeck_friction" => (p[0], 0.0, p[3]),
        _ => return vec![],
    };
    let here = |class: &str| -> Option<Candidate> {
        let own = super::candidate_of(fitted);
        let c = Candidate { effect: find(class)?, ..own };
        search.candidates.contains(&c).then_some(c)
    };
    let on = |class: &str, parameters: Vec<f64>| {
        let c = here(class)?;
        let std = vec![None; parameters.len()];
        Some(ModelEffect { effect: c.effect, parameters, std, ..fitted.clone() })
    };
    let speed = search.problem.scales_of(fitted).v;
    let mut out = vec![
        on("coulomb_friction", vec![magnitude, smoothing]),
        on("asymmetric_friction", vec![magnitude - offset, magnitude + offset, smoothing]),
    ];
    out.retain(|e| e.as_ref().is_some_and(|e| e.effect.class != fitted.effect.class));
    for share in [0.15, 0.4, 1.2] {
        let parameters = vec![0.8 * magnitude, 1.3 * magnitude, share * speed, smoothing];
        out.push(on("stribeck_friction", parameters));
    }
    out.into_iter().flatten().collect()
}
