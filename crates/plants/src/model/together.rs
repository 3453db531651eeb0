//! Systems of the same values, stepped side by side: each carries derivatives in directions of its own.

use super::mass::{factor, solve_factored};
use super::system::{Step, System, Workspace};
use crate::dynamics::{Implicit, ImplicitRoom};
use crate::input::StepInput;
use crate::substeps::{Place, Plan, Stepped, Substeps};
use lacuna_numbers::{Number, copy};

/// One of several systems that are stepped side by side.
pub struct Strand<'a, T: Number> {
    /// The system: of the same model, parameters and effects as all others.
    pub system: &'a System<T>,
    /// Room for it.
    pub workspace: &'a mut Workspace<T>,
    /// Its inputs along the step, of the same values as those of all others.
    pub inputs: StepInput<'a, T>,
    /// Its state, likewise.
    pub state: &'a mut [T],
}

/// Advance the states of systems that differ in nothing but the directions that they carry, from `times.0` to
/// `times.1` by the same RK4 steps. What does not depend on the directions is computed once where the
/// dynamics know how ([`Implicit`]).
pub fn advance_together<T: Number>(
    strands: &mut [Strand<'_, T>],
    times: (f64, f64),
    substeps: Substeps,
) {
    let Some(first) = strands.first() else { return };
    match first.system.implicit() {
        Some(_) => pulp::Arch::new().dispatch(Together { strands, times, substeps }),
        None if substeps.cut && strands.len() > 1 => in_turn(strands, times, substeps),
        None => strands.iter_mut().for_each(|s| s.alone(None, times, substeps)),
    }
}

/// Advance systems each by itself, again and again until all cut the same steps.
fn in_turn<T: Number>(strands: &mut [Strand<'_, T>], times: (f64, f64), substeps: Substeps) {
    let mut plan = std::mem::take(&mut strands[0].workspace.plan);
    plan.begin();
    for Strand { workspace, state, .. } in &mut *strands {
        workspace.begin.clear();
        workspace.begin.extend_from_slice(state);
    }
    let (mut next, mut agree) = (0, 0);
    while agree < strands.len() {
        let strand = &mut strands[next % strands.len()];
        copy(&strand.workspace.begin, strand.state);
        strand.alone(Some(&mut plan), times, substeps);
        // Those before it went along other steps.
        agree = if plan.grew() { 1 } else { agree + 1 };
        next += 1;
    }
    strands[0].workspace.plan = plan;
}

impl<T: Number> Strand<'_, T> {
    /// Advance it by itself.
    fn alone(&mut self, plan: Option<&mut Plan>, times: (f64, f64), substeps: Substeps) {
        let &mut Strand { system, ref mut workspace, inputs, ref mut state } = self;
        let strand = Strand { system, workspace, inputs, state };
        system.bound().advance(Step { strand, plan, times, substeps });
    }
}

/// What strands share at a stage, in plain numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared {
    room: ImplicitRoom,
    variables: Vec<f64>,
    rates: Vec<f64>,
    accelerations: Vec<f64>,
}

impl Shared {
    pub fn new(room: ImplicitRoom, (coordinates, variables, rates): (usize, usize, usize)) -> Self {
        Self {
            room,
            variables: vec![0.0; variables],
            rates: vec![0.0; rates],
            accelerations: vec![0.0; coordinates],
        }
    }

    /// Find the accelerations, given what acts beside the dynamics: mass and force.
    #[inline(always)]
    fn accelerate<T: Number>(&mut self, dynamics: &dyn Implicit<T>, variables: &[T], beside: &[T]) {
        let Self { room, variables: plain, rates, accelerations } = self;
        for (to, from) in plain.iter_mut().zip(variables) {
            *to = from.value();
        }
        dynamics.values(room, plain, rates);
        for (to, from) in rates.iter_mut().zip(beside) {
            *to += from.value();
        }
        let n = accelerations.len();
        let (mass, force) = rates.split_at_mut(n * n);
        factor(mass, n);
        solve_factored(mass, force);
        accelerations.copy_from_slice(force);
        dynamics.accelerate(room, plain, accelerations);
    }

    /// M, factorised.
    fn factors(&self) -> &[f64] {
        let n = self.accelerations.len();
        &self.rates[..n * n]
    }
}

/// Steps of strands, to be dispatched.
struct Together<'s, 'a, T: Number> {
    strands: &'s mut [Strand<'a, T>],
    times: (f64, f64),
    substeps: Substeps,
}

impl<T: Number> pulp::WithSimd for Together<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Self { strands, times, substeps } = self;
        let mut shared = std::mem::take(&mut strands[0].workspace.shared);
        let made = substeps.take(times, &mut SideBySide { strands, shared: &mut shared });
        let first = &mut strands[0].workspace;
        first.steps += made;
        first.shared = shared;
    }
}

/// Strands with what they share.
struct SideBySide<'s, 'a, T: Number> {
    strands: &'s mut [Strand<'a, T>],
    shared: &'s mut Shared,
}

impl<T: Number> Stepped for SideBySide<'_, '_, T> {
    #[inline(always)]
    fn stage(&mut self, k: usize, at: (f64, Place), step: f64) {
        for Strand { system, workspace, inputs, state } in &mut *self.strands {
            system.begin_stage(workspace, k, at, *inputs, (state, step));
        }
        stage(self.strands, self.shared, k, at.0);
        if k == 0 && self.turns() {
            self.find_steep(at.0);
        }
        for Strand { workspace: w, state, .. } in &mut *self.strands {
            w.steep.relative(k, step, state, &w.stage, &mut w.slope[k]);
        }
    }

    #[inline(always)]
    fn jumps(&self) -> bool {
        self.strands.iter().any(|s| s.system.jumps(s.workspace, s.state))
    }

    #[inline(always)]
    fn turns(&self) -> bool {
        self.strands.first().is_some_and(|s| s.system.is_dry())
    }

    #[inline(always)]
    fn complete(&mut self, h: f64) {
        for Strand { workspace, state, .. } in &mut *self.strands {
            workspace.complete(h, state);
        }
    }
}

impl<T: Number> SideBySide<'_, '_, T> {
    /// The rates of the step that begins, the same for all.
    #[inline(always)]
    fn find_steep(&mut self, t: f64) {
        let Some((first, others)) = self.strands.split_first_mut() else { return };
        let Strand { system, workspace: w, .. } = first;
        if system.damp((t, &w.stage, &w.input), &mut w.steep) {
            w.steep.over_factors(self.shared.factors());
        }
        for other in others {
            other.workspace.steep.copy(&w.steep);
        }
    }
}

/// The slopes of one stage.
#[inline(always)]
fn stage<T: Number>(strands: &mut [Strand<'_, T>], shared: &mut Shared, k: usize, t: f64) {
    let n = shared.accelerations.len();
    for Strand { system, workspace: w, .. } in &mut *strands {
        // Where no effect has inertia, its place stays empty.
        let first = if system.is_inertial() { 0 } else { n * n };
        w.outputs[first..].fill(T::constant(0.0));
        system.push((t, &w.stage, &w.input), &mut w.outputs, &mut w.slope[k]);
    }
    let Strand { system, workspace: w, .. } = &strands[0];
    let Some(dynamics) = system.implicit() else { return };
    shared.accelerate(dynamics, &w.variables, &w.outputs);
    for Strand { system, workspace: w, .. } in strands {
        let (mass, force) = w.outputs.split_at_mut(n * n);
        if system.is_inertial() {
            for (row, force) in mass.chunks_exact(n).zip(&mut *force) {
                for (m, a) in row.iter().zip(&shared.accelerations) {
                    *force = *force - *m * *a;
                }
            }
        }
        let Some(dynamics) = system.implicit() else { continue };
        dynamics.derive(&mut shared.room, &w.variables, force);
        solve_factored(shared.factors(), force);
        let slope = &mut w.slope[k];
        copy(&w.stage[n..2 * n], &mut slope[..n]);
        for ((slope, force), a) in slope[n..].iter_mut().zip(force).zip(&shared.accelerations) {
            *slope = force.mapped(*a, 1.0);
        }
    }
}
