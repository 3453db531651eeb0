//! Control occupation kernels as sums over samples.

use crate::functional::Functional;
use crate::simd::{Form, Looks, OccupationSums};

/// The control occupation kernels Gamma_a(x) = sum_k c_a(k) K(x, x_k) (1, u_k)^T of a set of trajectories.
///
/// The samples of all trajectories stand one after the other, and the functionals c_a index them all.
#[derive(Debug, Clone)]
pub struct OccupationKernels {
    argument_count: usize,
    input_count: usize,
    arguments: Vec<f64>,
    inputs: Vec<f64>,
    functionals: Vec<Functional>,
}

impl OccupationKernels {
    /// No trajectory yet, for d arguments and m inputs.
    pub(crate) fn new(argument_count: usize, input_count: usize) -> Self {
        Self {
            argument_count,
            input_count,
            arguments: Vec::new(),
            inputs: Vec::new(),
            functionals: Vec::new(),
        }
    }

    /// Appends a trajectory's samples (arguments N x d, inputs N x m) and its functionals.
    pub(crate) fn append(
        &mut self,
        arguments: &[f64],
        inputs: &[f64],
        functionals: Vec<Functional>,
    ) {
        let before = self.samples();
        self.arguments.extend_from_slice(arguments);
        self.inputs.extend_from_slice(inputs);
        self.functionals
            .extend(functionals.into_iter().map(|functional| functional.shifted(before)));
    }

    /// Number of samples of all trajectories.
    pub fn samples(&self) -> usize {
        self.arguments.len() / self.argument_count
    }

    /// Number d of the kernel's arguments.
    pub fn argument_count(&self) -> usize {
        self.argument_count
    }

    /// Number m of inputs.
    pub fn input_count(&self) -> usize {
        self.input_count
    }

    /// Kernel arguments x_k of all samples, row-major.
    pub fn arguments(&self) -> &[f64] {
        &self.arguments
    }

    /// Inputs u_k of all samples, row-major.
    pub fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    /// The functionals c_a, one for each occupation kernel.
    pub fn functionals(&self) -> &[Functional] {
        &self.functionals
    }

    /// Whether every sample is looked at by one functional, in order: as many kernel values as samples are needed for all.
    pub(crate) fn are_apart(&self) -> bool {
        let mut end = 0;
        let follows = self.functionals.iter().all(|functional| {
            let follows = functional.first == end;
            end = functional.end();
            follows
        });
        follows && end == self.samples()
    }

    pub(crate) fn argument(&self, sample: usize) -> &[f64] {
        &self.arguments[sample * self.argument_count..(sample + 1) * self.argument_count]
    }

    pub(crate) fn input(&self, sample: usize) -> &[f64] {
        &self.inputs[sample * self.input_count..(sample + 1) * self.input_count]
    }

    /// The occupation kernels laid out for evaluation with a kernel.
    pub(crate) fn sums(&self, form: Form) -> OccupationSums {
        let (d, m) = (self.argument_count, self.input_count);
        OccupationSums::new(form, m, self.functionals.len(), |a| {
            let functional = &self.functionals[a];
            Looks {
                weights: &functional.weights,
                arguments: &self.arguments[functional.first * d..functional.end() * d],
                inputs: &self.inputs[functional.first * m..functional.end() * m],
            }
        })
    }

    /// The arguments of all samples in the scale of `sums`.
    pub(crate) fn scaled(&self, sums: &OccupationSums) -> Vec<f64> {
        let d = self.argument_count;
        let mut scaled = vec![0.0; self.arguments.len()];
        let rows = self.arguments.chunks_exact(d).zip(scaled.chunks_exact_mut(d));
        rows.for_each(|(x, to)| sums.scale(x, to));
        scaled
    }
}
