//! From a model to its evaluator.

use lacuna_realtime::{Evaluator, LANES, MOST_ARGUMENTS, Series, Shape};

use super::domain::Purpose;
use super::fit::Fit;
use super::layout::Layout;
use super::prune::{Pruned, prune};
use super::samples::Samples;
use super::{
    BOUNDARY_POINTS, CompileError, Compiled, Domain, Function, PROOF_POINTS, Representation,
    TOLERANCES, cost, function_of, groups, sums,
};
use crate::IdentifiedModel;

/// Points, inside and on the boundary, by which terms are chosen.
const CHOICE_POINTS: usize = 2048;
/// Part of the tolerance that a function may take where its terms are chosen: on more points the error is larger.
const CHOICE_SHARES: [f64; 3] = [0.85, 0.6, 0.3];

/// Compiles a model on a box to a relative error of at most `tolerance` for each function (as the
/// [module](super) defines it). The same model, box and tolerance give the same result.
///
/// # Errors
/// A box of another dimension, a tolerance outside [`TOLERANCES`], a model that is not finite on the box.
pub fn compile(
    model: &IdentifiedModel,
    domain: &Domain,
    tolerance: f64,
) -> Result<Compiled, CompileError> {
    check(model, domain, tolerance)?;
    let points = |purpose, inside, boundary| {
        [domain.interior(purpose, inside), domain.boundary(purpose, boundary)].concat()
    };
    let choice = points(Purpose::Choice, CHOICE_POINTS, CHOICE_POINTS);
    let choice = Samples::of(model, domain, choice)?;
    let proof = points(Purpose::Proof, PROOF_POINTS, BOUNDARY_POINTS);
    let proof = Samples::of(model, domain, proof)?;
    let work = Work { model, domain, tolerance, magnitudes: choice.magnitudes(), choice, proof };
    let fits = work.fits()?;
    let layout = Layout::new(&fits, domain.arguments());
    let mut shares = vec![Some(CHOICE_SHARES[0]); work.magnitudes.len()];
    // Each round either is right or makes a function stricter, at last its own sum.
    loop {
        let compiled = work.assemble(&fits, &layout, &shares)?;
        let missed =
            |f: &Function| f.representation == Representation::Series && f.relative > tolerance;
        let missed: Vec<bool> = compiled.functions.iter().map(missed).collect();
        if !missed.contains(&true) {
            return Ok(compiled);
        }
        for (share, _) in shares.iter_mut().zip(missed).filter(|(_, missed)| *missed) {
            *share = CHOICE_SHARES.into_iter().find(|next| share.is_some_and(|s| *next < s));
        }
    }
}

fn check(model: &IdentifiedModel, domain: &Domain, tolerance: f64) -> Result<(), CompileError> {
    let (expected, found) = (model.arguments(), domain.arguments());
    if expected != found {
        return Err(CompileError::Sides { expected, found });
    }
    if found > MOST_ARGUMENTS {
        return Err(CompileError::Arguments { most: MOST_ARGUMENTS, found });
    }
    let [least, most] = TOLERANCES;
    if !(least..=most).contains(&tolerance) {
        return Err(CompileError::Tolerance { least, most, found: tolerance });
    }
    Ok(())
}

/// A model on a box, and its values there.
pub(super) struct Work<'m> {
    pub model: &'m IdentifiedModel,
    pub domain: &'m Domain,
    pub tolerance: f64,
    /// Of the functions, where terms are chosen.
    pub magnitudes: Vec<f64>,
    pub choice: Samples,
    pub proof: Samples,
}

impl Work<'_> {
    /// The evaluator, each function by what is cheaper, with its errors. A function without a share is its own sum.
    fn assemble(
        &self,
        fits: &[Fit],
        layout: &Layout,
        shares: &[Option<f64>],
    ) -> Result<Compiled, CompileError> {
        let mut estimates = vec![0.0; shares.len()];
        let mut pruned: Vec<Pruned> = Vec::new();
        for fit in fits {
            for (column, &k) in fit.functions.iter().enumerate() {
                let Some(share) = shares[k] else { continue };
                let blocks = layout.blocks(fit, column);
                let enough = share * self.tolerance * self.magnitudes[k];
                if let Some(found) = prune(k, &blocks, layout, &self.choice, enough) {
                    estimates[k] = found.left_out + fit.outermost_of(column);
                    pruned.push(found);
                }
            }
        }
        let direct = self.direct(&mut pruned);
        let enough: Vec<f64> = self.magnitudes.iter().map(|m| 0.5 * self.tolerance * m).collect();
        let (landmarks, left_out) = sums::sums(self.model, self.domain, &direct, &enough);
        direct.iter().for_each(|&k| estimates[k] = left_out[k]);
        let mut coefficients: Vec<usize> = vec![0; shares.len()];
        for p in &pruned {
            coefficients[p.function] = p.blocks.values().flatten().filter(|c| **c != 0.0).count();
        }
        for sum in &landmarks {
            let entries = sum.entries.len();
            let points = LANES * sum.tiles.len() / (self.domain.arguments() + entries);
            sum.entries.iter().for_each(|&e| coefficients[usize::from(e)] += points);
        }
        let series = (!pruned.is_empty()).then(|| self.series(layout, &pruned));
        let shape = Shape {
            arguments: self.model.arguments(),
            dimension: self.model.dimension(),
            inputs: self.model.inputs(),
        };
        let Domain { lower, upper } = self.domain.clone();
        let evaluator =
            Evaluator::new(shape, lower.into(), upper.into(), series, landmarks.into())?;
        let representation = |k: usize| {
            if direct.contains(&k) {
                Representation::Landmarks
            } else if self.magnitudes[k] > 0.0 {
                Representation::Series
            } else {
                Representation::Zero
            }
        };
        let errors = self.errors(&evaluator);
        let magnitudes = self.proof.magnitudes();
        let function = |k: usize| {
            let (row, input) = function_of(self.model, k);
            Function {
                row,
                input,
                representation: representation(k),
                coefficients: coefficients[k],
                magnitude: magnitudes[k],
                absolute: errors[k],
                relative: if errors[k] > 0.0 { errors[k] / magnitudes[k] } else { 0.0 },
                estimate: estimates[k],
            }
        };
        Ok(Compiled {
            order: self.model.order(),
            names: self.model.names().cloned(),
            tolerance: self.tolerance,
            functions: (0..shares.len()).map(function).collect(),
            evaluator,
        })
    }

    /// Functions that remain sums: those without a series, and those whose series would cost more; the latter are taken
    /// out of the series.
    fn direct(&self, series: &mut Vec<Pruned>) -> Vec<usize> {
        let mut direct = Vec::new();
        for (members, cost) in sums::components(self.model) {
            let of = |p: &&Pruned| members.contains(&p.function);
            let blocks: usize = series.iter().filter(of).map(|p| p.blocks.len()).sum();
            let without: Vec<usize> = members
                .iter()
                .copied()
                .filter(|k| self.magnitudes[*k] > 0.0)
                .filter(|k| !series.iter().any(|p| p.function == *k))
                .collect();
            // Where some remain, their sum is paid anyway, and the others cost a multiplication and addition more.
            if !without.is_empty() && without.len() < members.len() && cost < 2 * blocks
                || without.is_empty() && cost < cost::group(blocks, 1) / 2
            {
                series.retain(|p| !members.contains(&p.function));
                direct.extend(members.iter().copied().filter(|k| self.magnitudes[*k] > 0.0));
            } else {
                direct.extend(without);
            }
        }
        direct
    }

    fn series(&self, layout: &Layout, pruned: &[Pruned]) -> Series<'static> {
        let [outer, inner] = layout.products();
        let degrees = layout.degrees.clone().into();
        Series { degrees, outer, inner, groups: groups::groups(pruned).into() }
    }

    /// Largest errors of an evaluator on the points of the proof.
    fn errors(&self, evaluator: &Evaluator<'_>) -> Vec<f64> {
        let n = self.model.dimension();
        let mut errors = vec![0.0_f64; self.magnitudes.len()];
        let mut found = vec![0.0; errors.len()];
        for (z, values) in self.proof.points.iter().zip(&self.proof.values) {
            let (f, g) = found.split_at_mut(n);
            // Lengths are those of the model, and points those of the box.
            let region = evaluator.evaluate(&self.domain.point(z), f, g);
            debug_assert!(region == Ok(lacuna_realtime::Region::Inside));
            let pairs = found.iter().zip(values);
            errors.iter_mut().zip(pairs).for_each(|(e, (a, b))| *e = e.max((a - b).abs()));
        }
        errors
    }
}
