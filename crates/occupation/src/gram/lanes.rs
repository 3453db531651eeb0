//! Gram matrices of functionals that do not overlap.
//!
//! G_ab = sum_k c_a(k) (Gamma_b(x_k) . (1, u_k)): eight occupation kernels Gamma_b side by side, along the samples of
//! every functional a up to the last of the eight. Each eight are one task, computed in a fixed order.

use faer::{Mat, MatMut};
use rayon::prelude::*;

use crate::occupation_kernels::OccupationKernels;
use crate::simd::{Form, LANES, OccupationSums};

pub(super) fn gram(form: Form, occupation: &OccupationKernels) -> Mat<f64> {
    let sums = occupation.sums(form);
    let scaled = occupation.scaled(&sums);
    // The last are the longest: they begin first.
    let columns: Vec<Vec<f64>> = (0..sums.blocks())
        .into_par_iter()
        .rev()
        .with_max_len(1)
        .map(|block| columns(&sums, occupation, &scaled, block))
        .collect();
    let mut gram = Mat::zeros(sums.count(), sums.count());
    for (block, values) in (0..sums.blocks()).rev().zip(&columns) {
        place(gram.as_mut(), block, values);
    }
    gram
}

/// G_ab for the eight b of a block and all a up to the last of them: a times eight.
fn columns(
    sums: &OccupationSums,
    occupation: &OccupationKernels,
    scaled: &[f64],
    block: usize,
) -> Vec<f64> {
    let (d, width) = (occupation.argument_count(), sums.columns() * LANES);
    let last = sums.count().min(LANES * (block + 1));
    let mut gammas = Vec::new();
    let mut found = vec![0.0; last * LANES];
    let functionals = &occupation.functionals()[..last];
    for (functional, entries) in functionals.iter().zip(found.as_chunks_mut::<LANES>().0) {
        let samples = functional.first..functional.end();
        gammas.resize(samples.len() * width, 0.0);
        sums.block(block, &scaled[samples.start * d..samples.end * d], &mut gammas);
        for ((k, weight), gamma) in samples
            .zip(&functional.weights)
            .zip(gammas.as_chunks::<LANES>().0.chunks_exact(sums.columns()))
        {
            let inputs = std::iter::once(1.0).chain(occupation.input(k).iter().copied());
            for (u, values) in inputs.zip(gamma) {
                let factor = weight * u;
                entries.iter_mut().zip(values).for_each(|(entry, value)| *entry += factor * value);
            }
        }
    }
    found
}

/// Writes the columns of a block and their mirror image.
fn place(mut gram: MatMut<'_, f64>, block: usize, values: &[f64]) {
    for (a, entries) in values.as_chunks::<LANES>().0.iter().enumerate() {
        let own = (LANES * block..gram.ncols()).zip(entries);
        // Of the square on the diagonal, the upper triangle counts.
        for (b, &entry) in own.filter(|(b, _)| *b >= a) {
            gram[(a, b)] = entry;
            gram[(b, a)] = entry;
        }
    }
}
