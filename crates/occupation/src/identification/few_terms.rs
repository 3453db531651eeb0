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
        if polynomials != chosen {
            self.try_rows(data, polynomials, full, start, &mut best);
        }
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

    /// Takes the field of other priors with its most probable monomials if that is more probable.
    fn try_rows(
        &self,
        data: &Data,
        rows: &[RowChoice],
        full: &Refined,
        start: &[Shot],
        best: &mut Option<(Vec<RowChoice>, Refined)>,
    ) {
        let Ok(found) = self.refined(data, rows, start) else { return };
        let found = self.selected(data, rows, &found).unwrap_or(found);
        if found.beats(best.as_ref().map_or(full, |(_, few)| few)) {
            *best = Some((rows.to_vec(), found));
        }
    }

    /// A field with its most probable monomials, chosen again where it has them; none where all of them stay.
    fn selected(&self, data: &Data, rows: &[RowChoice], from: &Refined) -> Option<Refined> {
        let choices = |term: &Term| Choices {
            size: term.basis.rank(),
            monomials: monomials::of(term, &rows[term.row].blocks[term.block]),
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
