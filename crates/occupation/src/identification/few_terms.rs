//! Fields whose polynomials have few terms: those monomials alone that the data ask for.

use super::Identification;
use super::choice::RowChoice;
use super::data::Data;
use super::field::Term;
use super::flow::Shot;
use super::monomials;
use super::refine::{Refined, Refinement};
use super::select::{Choices, Selection, Subspace};

/// Most choices of monomials, each where the one before led.
const MOST_SELECTIONS: usize = 4;

impl Identification {
    /// Where drifts are polynomials, the field with those monomials alone that the data ask for, and with a constant
    /// effectiveness where that does as well; none where that is less probable than `full`, and where a regularisation is
    /// given, which leaves no evidence to go by.
    pub(super) fn of_few_terms(
        &self,
        data: &Data,
        [chosen, polynomials]: [&[RowChoice]; 2],
        full: &Refined,
        start: &[Shot],
    ) -> Option<(Vec<RowChoice>, Refined)> {
        if self.lambda.is_some() {
            return None;
        }
        let few = self.selected(data, chosen, full);
        let mut best = few.filter(|few| few.beats(full)).map(|few| (chosen.to_vec(), few));
        self.try_polynomials(data, [chosen, polynomials], full, start, &mut best);
        let rows = best.as_ref().map_or(chosen, |(rows, _)| rows).to_vec();
        for (i, b) in general_beside_polynomials(&rows) {
            let rows = best.as_ref().map_or(chosen, |(rows, _)| rows);
            let mut simpler = rows.to_vec();
            let block = &mut simpler[i].blocks[b];
            *block = block.clone().constant(&data.spread);
            self.try_rows(data, &simpler, full, start, &mut best);
        }
        best
    }

    /// Takes polynomials for drifts that were chosen to be none where they are more probable and end: one with a monomial of the
    /// highest degree that there is may be the first terms of a series, which leaves the data where they end.
    fn try_polynomials(
        &self,
        data: &Data,
        [chosen, polynomials]: [&[RowChoice]; 2],
        full: &Refined,
        start: &[Shot],
        best: &mut Option<(Vec<RowChoice>, Refined)>,
    ) {
        let mut rows = polynomials.to_vec();
        while rows != chosen {
            let Some(found) = self.field_of(data, &rows, start) else { return };
            let endless = self.endless(&rows, &found);
            let other = endless.into_iter().filter(|&i| rows[i] != chosen[i]).collect::<Vec<_>>();
            if other.is_empty() {
                keep_more_probable(best, full, (rows, found));
                return;
            }
            other.into_iter().for_each(|i| rows[i] = chosen[i].clone());
        }
    }

    /// Rows whose drift has a monomial of the highest degree that it may have.
    fn endless(&self, rows: &[RowChoice], found: &Refined) -> Vec<usize> {
        let most = self.families.iter().filter_map(|family| family.degree()).max();
        let mut endless = Vec::new();
        let mut first = 0;
        for term in &found.field.terms {
            let block = &rows[term.row].blocks[term.block];
            let Some(monomials) = monomials::of(term, block) else {
                if term.block == 0 && block.kernel.family.degree() == most {
                    endless.push(term.row);
                }
                continue;
            };
            let there = |k: usize| found.within.as_ref().is_none_or(|s| s.present[first + k]);
            let mut degrees = monomials.degrees.iter().enumerate();
            if term.block == 0 && degrees.any(|(k, &degree)| Some(degree) == most && there(k)) {
                endless.push(term.row);
            }
            first += monomials.degrees.len();
        }
        endless
    }

    /// The field of other priors with its most probable monomials.
    fn field_of(&self, data: &Data, rows: &[RowChoice], start: &[Shot]) -> Option<Refined> {
        let found = self.refined(data, rows, start).ok()?;
        Some(self.selected(data, rows, &found).unwrap_or(found))
    }

    /// Takes the field of other priors with its most probable monomials if that is more probable.
    fn try_rows(
        &self,
        data: &Data,
        rows: &[RowChoice],
        full: &Refined,
        start: &[Shot],
        best: &mut Option<(Vec<RowChoice>, Refined)>,
    ) {
        if let Some(found) = self.field_of(data, rows, start) {
            keep_more_probable(best, full, (rows.to_vec(), found));
        }
    }

    /// A field with its most probable monomials, chosen again where it has them; none where all of them stay.
    fn selected(&self, data: &Data, rows: &[RowChoice], from: &Refined) -> Option<Refined> {
        let choices = |term: &Term| Choices {
            size: term.basis.rank(),
            monomials: monomials::of(term, &rows[term.row].blocks[term.block]).map(|m| m.columns),
        };
        let terms: Vec<Choices> = from.field.terms.iter().map(choices).collect();
        if terms.iter().all(|term| term.monomials.is_none()) {
            return None;
        }
        let prior = Term::priors(&from.field.terms);
        let mut selection = Selection::of(&from.normal, &prior, &terms).ok()?;
        selection.improve();
        let mut subspace = selection.subspace().ok()?;
        if !subspace.present.contains(&false) {
            return None;
        }
        let mut few = self.within(data, from, &prior, &subspace)?;
        for round in 1.. {
            selection = Selection::of(&few.normal, &prior, &terms).ok()?.with(&subspace.present);
            let doubt = selection.doubt();
            selection.improve();
            let next = selection.subspace().ok()?;
            let other = next.present != subspace.present && round < MOST_SELECTIONS;
            match other.then(|| self.within(data, &few, &prior, &next)).flatten() {
                Some(found) => (few, subspace) = (found, next),
                None => {
                    few.posterior.covariance += doubt;
                    break;
                }
            }
        }
        Some(few)
    }

    /// The field on a subspace of its coefficients, from another's trajectories.
    fn within(
        &self,
        data: &Data,
        from: &Refined,
        prior: &[f64],
        subspace: &Subspace,
    ) -> Option<Refined> {
        let mut field = from.field.clone();
        field.set(&subspace.posterior(&from.normal, prior).ok()?.0.coefficients);
        let few = Refinement {
            field,
            setting: data.setting(self),
            shots: from.windows.clone(),
            noise: from.noise.clone(),
            lambda: None,
            within: Some(subspace.clone()),
        };
        few.run().ok()
    }
}

fn keep_more_probable(
    best: &mut Option<(Vec<RowChoice>, Refined)>,
    full: &Refined,
    found: (Vec<RowChoice>, Refined),
) {
    if found.1.beats(best.as_ref().map_or(full, |(_, few)| few)) {
        *best = Some(found);
    }
}

/// Effectivenesses that depend on something, as no polynomial does, beside a drift that is one: rows and blocks.
fn general_beside_polynomials(rows: &[RowChoice]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        if row.blocks[0].kernel.family.is_polynomial() {
            let blocks = row.blocks.iter().enumerate().skip(1);
            found.extend(blocks.filter(|(_, block)| block.is_general()).map(|(b, _)| (i, b)));
        }
    }
    found
}
