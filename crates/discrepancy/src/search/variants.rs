//! Other ways to name what an effect does, begun from its fit: what a screening along a
//! trajectory cannot tell apart, and laws that hold one another as special cases.

use super::Search;
use super::forward::{Tried, rank};
use crate::candidates::Candidate;
use crate::likelihood::evidence::common_temperature;
use crate::likelihood::{Effort, FULL, Fit, Hypothesis, STILL};
use lacuna_effects::Biased;
use lacuna_plants::model::ModelEffect;
use rayon::prelude::*;

impl<'p> Search<'p> {
    /// Add to the fitted candidates the other laws of a family where one of them is among the best.
    pub(super) fn add_variants(&self, tried: &mut Vec<Tried<'p>>) {
        rank(tried);
        let best = tried.iter().take(2).find(|t| t.candidate.effect.nature.kin.is_some());
        let mut more = best.map_or(vec![], |best| {
            let last = best.fit.hypothesis.supposed().len() - 1;
            self.variants(&best.fit, last, |_| true)
        });
        more.retain(|t| !self.is_confined(&t.fit));
        let temperature = common_temperature(tried.iter().chain(&more).map(|t| &t.fit));
        let evidence = |t: &Tried| t.log_evidence(temperature);
        for new in more {
            match tried.iter_mut().find(|t| t.candidate == new.candidate) {
                Some(old) if evidence(old) < evidence(&new) => *old = new,
                Some(_) => {}
                None => tried.push(new),
            }
        }
    }

    /// The best of the other laws that are `wanted` in the place of effect `k`.
    pub(super) fn best_variant(
        &self,
        fit: &Fit<'p>,
        k: usize,
        wanted: impl Fn(&Candidate) -> bool,
    ) -> Option<Tried<'p>> {
        let own = Candidate::of(fit.hypothesis.supposed().get(k)?);
        let mut tried = self.variants(fit, k, |c| *c != own && wanted(c));
        rank(&mut tried);
        tried.into_iter().next()
    }

    /// A fit with effect `k` written as the law that it holds as a special case, at its best, or as one beside a constant
    /// force: a stop that the machine never leaves is a spring about a point.
    pub(super) fn special_case<'f>(&self, fit: &Fit<'f>, k: usize) -> Option<Fit<'f>> {
        let fitted = fit.hypothesis.supposed().get(k)?;
        let mut others = siblings(fitted, self).into_iter();
        let simple = others.find(|e| e.effect.parameters.len() < fitted.effect.parameters.len());
        let h = match simple {
            Some(simple) => self.with(&fit.hypothesis.clone().without(k), simple),
            None => self.biased(&fit.hypothesis, k)?,
        };
        fit.refit_alike(h, FULL).ok()
    }

    /// A hypothesis with effect `k` written as the simpler law that it is beside a constant force, its last then. None where
    /// there is no such law, or it may not be named beside the others.
    pub(super) fn biased(&self, h: &Hypothesis, k: usize) -> Option<Hypothesis> {
        let fitted = h.supposed().get(k)?;
        let Biased { effect, numbers } = fitted.effect.nature.biased?;
        let ((parameters, force), channel) = (numbers(&fitted.parameters), fitted.channel);
        let law = Candidate { effect, channel, other: None };
        let own = |c: &&Candidate| c.is_constant() && c.channel == channel;
        let constant = self.candidates.iter().find(own)?;
        let plain = h.clone().without(k);
        if !self.may_join(&plain, &law) {
            return None;
        }
        let beside = match self.may_join(&plain, constant) {
            true => self.with(&plain, constant.with(vec![force])),
            false => plain,
        };
        Some(self.with(&beside, law.with(parameters)))
    }

    /// Effect `k` of a fit written with the other laws of its kind that are `wanted`, each at its best.
    fn variants(
        &self,
        fit: &Fit<'p>,
        k: usize,
        wanted: impl Fn(&Candidate) -> bool,
    ) -> Vec<Tried<'p>> {
        let Some(fitted) = fit.hypothesis.supposed().get(k) else { return vec![] };
        let plain = fit.hypothesis.clone().without(k);
        let glance = Effort { steps: 3, least: 0.3, undamped: false };
        let mut kin = siblings(fitted, self);
        kin.retain(|effect| wanted(&Candidate::of(effect)));
        let glanced: Vec<Option<Tried>> = kin
            .into_par_iter()
            .map(|effect| {
                let candidate = Candidate::of(&effect);
                let fit = fit.glimpse(self.with(&plain, effect), glance).ok()?;
                Some(Tried::new(candidate, fit))
            })
            .collect();
        let mut glanced: Vec<Tried> = glanced.into_iter().flatten().collect();
        let temperature = rank(&mut glanced);
        // What is far behind a law that leaves nothing but noise need not be fitted.
        if let Ok(own) = fit.glimpse(fit.hypothesis.clone(), STILL)
            && own.reduced() < self.decision.noise
        {
            let least = own.log_evidence(temperature) - self.settled_room();
            glanced.retain(|t| t.fit.hope(temperature) > least);
        }
        let mut best: Vec<Tried> = vec![];
        for t in glanced {
            if best.iter().all(|b| b.candidate != t.candidate) {
                best.push(t);
            }
        }
        let all =
            |t: Tried<'p>| Some(Tried::new(t.candidate, fit.refit(t.fit.hypothesis, FULL).ok()?));
        best.into_par_iter().filter_map(all).collect()
    }
}

/// An effect written with the laws of its family, as far as their parameters correspond; with its
/// own where that has several beginnings, or names another input.
fn siblings(fitted: &ModelEffect, search: &Search) -> Vec<ModelEffect> {
    let own = Candidate::of(fitted);
    let here = search.candidates.iter().filter(|c| c.channel == own.channel);
    let kin = here.filter(|c| c.effect.is_kin_of(own.effect));
    let begun = |c: &Candidate| {
        // The input that either of them names is what is known of the load.
        let named = if c.other.is_some() { c } else { &own };
        let scales = search.problem.scales(named.effect, named.channel, named.other);
        let begun = own.effect.written_as(c.effect, &fitted.parameters, &scales);
        let again = *c == own && begun.len() == 1;
        let c = *c;
        begun.into_iter().filter(move |_| !again).map(move |parameters| c.with(parameters))
    };
    kin.flat_map(begun).collect()
}
