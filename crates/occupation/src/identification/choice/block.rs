//! Blocks of a search in features, and what the equations make of them.

use std::sync::OnceLock;

use faer::Mat;

use super::super::basis::Basis;
use super::super::evidence::{Normal, Posterior};
use super::super::weak::Remainders;
use super::search::Search;
use super::{BlockChoice, side_by_side};
use crate::linear::NonPositivePivot;

/// Variance left by the landmarks while kernels are chosen.
const TOLERANCE: f64 = 1e-10;

/// Block b with its features.
pub(super) struct Block {
    pub choice: BlockChoice,
    /// At the points of the span, where the kernel is of it.
    pub spanned: Option<Mat<f64>>,
    pub dense: OnceLock<Dense>,
}

/// What a kernel makes of every equation.
pub(super) struct Dense {
    pub design: Mat<f64>,
    pub remainders: Remainders,
}

/// Inner products of all blocks, one of them first.
pub(super) struct Products {
    /// Features of each block.
    pub sizes: Vec<usize>,
    /// For errors of variance sigma^2, and the log determinant of their covariance for sigma 1; none where what landmarks
    /// leave makes the errors depend on the amplitudes.
    pub whole: Option<(Normal, f64)>,
}

impl Search<'_> {
    pub(super) fn basis(&self, choice: &BlockChoice) -> Basis {
        let candidates = self.start.candidates;
        Basis::choose(choice.kernel.clone(), candidates, TOLERANCE, self.start.effort.landmarks)
    }

    pub(super) fn block(&self, choice: BlockChoice) -> Block {
        let most = self.start.effort.landmarks;
        let spanned = self.span.as_ref().and_then(|s| s.features(&choice.kernel, TOLERANCE, most));
        Block { choice, spanned, dense: OnceLock::new() }
    }

    pub(super) fn dense<'b>(&self, b: usize, block: &'b Block) -> &'b Dense {
        block.dense.get_or_init(|| {
            let basis = self.basis(&block.choice);
            let (design, remainders) = (self.row.design(&basis, b), self.row.remainders(&basis, b));
            Dense { design, remainders }
        })
    }

    pub(super) fn features(&self, b: usize, block: &Block) -> usize {
        block.spanned.as_ref().map_or_else(|| self.dense(b, block).design.ncols(), Mat::ncols)
    }

    /// All blocks, with another block b, which comes first.
    fn with<'b>(&'b self, b: usize, block: &'b Block) -> Vec<(usize, &'b Block)> {
        let others = self.blocks.iter().enumerate().filter(|(k, _)| *k != b);
        std::iter::once((b, block)).chain(others).collect()
    }

    pub(super) fn products(&self, b: usize, block: &Block) -> Result<Products, NonPositivePivot> {
        let blocks = self.with(b, block);
        if let Some(span) = &self.span {
            let spanned: Option<Vec<(usize, &Mat<f64>)>> =
                blocks.iter().map(|(k, block)| Some((*k, block.spanned.as_ref()?))).collect();
            if let Some(spanned) = spanned {
                let sizes = spanned.iter().map(|(_, features)| features.ncols()).collect();
                let whole = Some((span.normal(&spanned), span.log_determinant));
                return Ok(Products { sizes, whole });
            }
        }
        let dense: Vec<&Dense> = blocks.iter().map(|(k, block)| self.dense(*k, block)).collect();
        let sizes = dense.iter().map(|dense| dense.design.ncols()).collect();
        if dense.iter().any(|dense| !dense.remainders.is_empty()) {
            return Ok(Products { sizes, whole: None });
        }
        let parts: Vec<&Mat<f64>> = dense.iter().map(|dense| &dense.design).collect();
        let whole = Some(self.row.normal(side_by_side(&parts), &[], 1.0)?);
        Ok(Products { sizes, whole })
    }

    pub(super) fn posterior(
        &self,
        b: usize,
        choice: &BlockChoice,
        block: &Block,
        products: &Products,
        noise_sd: f64,
    ) -> Result<Posterior, NonPositivePivot> {
        let blocks = self.with(b, block);
        let amplitude = |&(k, _): &(usize, &Block)| {
            self.amplitude(if k == b { choice } else { &self.blocks[k].choice }, noise_sd)
        };
        let amplitudes: Vec<f64> = blocks.iter().map(amplitude).collect();
        let each = amplitudes.iter().zip(&products.sizes);
        let prior: Vec<f64> =
            each.flat_map(|(&amplitude, &size)| std::iter::repeat_n(amplitude, size)).collect();
        let (mut posterior, log_determinant) = match &products.whole {
            Some((normal, log_determinant)) => {
                (normal.posterior(&prior, noise_sd)?, *log_determinant)
            }
            None => {
                let dense: Vec<&Dense> = blocks.iter().map(|(k, b)| self.dense(*k, b)).collect();
                let parts: Vec<&Mat<f64>> = dense.iter().map(|dense| &dense.design).collect();
                let left = dense.iter().map(|dense| &dense.remainders);
                let left: Vec<(f64, &Remainders)> = amplitudes.into_iter().zip(left).collect();
                let (normal, log_determinant) =
                    self.row.normal(side_by_side(&parts), &left, noise_sd)?;
                (normal.posterior(&prior, 1.0)?, log_determinant)
            }
        };
        posterior.log_evidence -= 0.5 * log_determinant;
        Ok(posterior)
    }
}
