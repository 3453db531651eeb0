//! Control occupation kernels as sums over samples.

use crate::functional::Functional;

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

    pub(crate) fn argument(&self, sample: usize) -> &[f64] {
        &self.arguments[sample * self.argument_count..(sample + 1) * self.argument_count]
    }

    pub(crate) fn input(&self, sample: usize) -> &[f64] {
        &self.inputs[sample * self.input_count..(sample + 1) * self.input_count]
    }
}
