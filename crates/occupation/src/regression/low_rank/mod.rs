//! Regression on many trajectories: memory grows with the rank, not with the data.
//!
//! ```text
//! K(x, y) ~ phi(x) . phi(y),   phi(x) = L^-1 k(x),   k_j(x) = K(x, z_j),   K(z_i, z_j) = (L L^T)_ij
//! min over C:  |F C - Y|^2 + lambda |C|^2,   F_a = int phi_a (1, u) phi(x) dt
//! ```
//!
//! which is (G + lambda I) W = Y with F F^T in place of G (C = F^T W; with whitening, rows of F and Y are whitened first).
//! Landmarks z are taken one by one from samples of the trajectories where the kernel is worst represented (pivoted
//! Cholesky: S. Fine, K. Scheinberg, JMLR 2001). Trajectories are asked for one by one, a few times each, and forgotten.
//!
//! | on paper | in code | shape |
//! | --- | --- | --- |
//! | landmarks z, L^-T | `Landmarks` | r x d, r x r |
//! | F^T F, F^T Y | `Normal` | r (1 + m) squared, r (1 + m) x n |
//!
//! **Error control.** The landmarks leave at most [`LowRank::left`] of the kernel's largest variance on the candidates. What
//! that does to the answer is measured: features come in the order of the landmarks, so the answer with half of them is a
//! part of the same equations, and [`LowRank::change`] is how far f and g with all landmarks are from f and g with half.

mod landmarks;
mod normal;

use std::ops::Range;

use rayon::prelude::*;

use super::{Equations, FitError, Regression, check_lambda, check_shape};
use crate::identified::IdentifiedModel;
use crate::sample::{GOLDEN, sample};
use crate::trajectory::TrajectoryData;
use landmarks::Landmarks;
use normal::{Normal, Rows};

/// Most trajectories from which landmarks are taken, and about how many samples of them all.
const CANDIDATE_TRAJECTORIES: usize = 2000;
const CANDIDATES: usize = 4000;
/// Trajectories that one thread turns into rows, and such groups at a time.
const GROUP: usize = 128;
const GROUPS: usize = 16;

/// When a fit is dense, and how fine it is when it is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most functionals of a dense fit, of which the Gram matrix is stored.
    pub dense: usize,
    /// Most landmarks r.
    pub landmarks: usize,
    /// Landmarks are taken until they leave this share of the largest K(x, x).
    pub left: f64,
}

impl Default for Limits {
    /// Dense up to 4000 functionals (128 MB); 1000 landmarks, or until they leave 1e-10.
    fn default() -> Self {
        Self { dense: 4000, landmarks: 1000, left: 1e-10 }
    }
}

/// A model and how it was made.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// f and g.
    pub model: IdentifiedModel,
    /// Dense or of low rank.
    pub way: Way,
}

/// How a fit was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way {
    /// With the Gram matrix of all functionals.
    Dense {
        /// Number of functionals.
        functionals: usize,
    },
    /// With features of landmarks.
    LowRank(LowRank),
}

/// A fit of low rank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowRank {
    /// Number of functionals.
    pub functionals: usize,
    /// Number r of landmarks.
    pub landmarks: usize,
    /// What the landmarks leave of the largest K(x, x), on candidates.
    pub left: f64,
    /// Change of f and of g (root mean square on candidates, relative) from half of the landmarks to all.
    pub change: [f64; 2],
}

impl std::fmt::Display for Way {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Dense { functionals } => write!(formatter, "dense, {functionals} functionals"),
            Self::LowRank(LowRank { functionals, landmarks, left, change: [f, g] }) => write!(
                formatter,
                "low rank, {landmarks} landmarks for {functionals} functionals, which leave {left:.1e} of the kernel; \
                 from half of them to all f changes by {f:.1e}, g by {g:.1e}"
            ),
        }
    }
}

/// A fit of streamed trajectories that failed.
#[derive(Debug, thiserror::Error)]
pub enum StreamError<E> {
    /// A trajectory could not be had.
    #[error("trajectory {trajectory}: {source}")]
    Trajectory {
        /// Its index.
        trajectory: usize,
        /// Why.
        source: E,
    },
    /// The regression failed.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl Regression {
    /// Fits `count` trajectories that `trajectory` makes or reads when asked: as [`Regression::fit`] while the functionals
    /// are few, else with landmarks and in memory that does not grow with `count`.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// As [`Regression::fit`], and those of `trajectory`.
    pub fn fit_streamed<E: Send>(
        &self,
        count: usize,
        trajectory: impl Fn(usize) -> Result<TrajectoryData, E> + Sync,
        limits: Limits,
    ) -> Result<Fitted, StreamError<E>> {
        let get = |k: usize| {
            trajectory(k).map_err(|source| StreamError::Trajectory { trajectory: k, source })
        };
        if count == 0 {
            return Err(FitError::NoTrajectory.into());
        }
        let first = get(0)?;
        self.validate(&first)?;
        check_lambda(self.lambda)?;
        if let Some((all, functionals)) = self.few(count, &get, limits.dense)? {
            let model = self.fit(&all)?;
            return Ok(Fitted { model, way: Way::Dense { functionals } });
        }
        let candidates = candidates(count, &first, &get)?;
        let d = first.argument_count();
        let landmarks = Landmarks::choose(&self.kernel, d, &candidates, limits);
        if landmarks.rank() == 0 {
            return Err(FitError::NoLandmark.into());
        }
        let normal = self.normal(count, &first, &get, &landmarks)?;
        let shape = [first.dimension(), first.input_count(), d];
        let (model, way) = normal.solve(self, &landmarks, shape, &candidates)?;
        Ok(Fitted { model, way })
    }

    /// All trajectories with their number of functionals, while those are at most `most`.
    fn few<E>(
        &self,
        count: usize,
        get: &impl Fn(usize) -> Result<TrajectoryData, StreamError<E>>,
        most: usize,
    ) -> Result<Option<(Vec<TrajectoryData>, usize)>, StreamError<E>> {
        // Every trajectory has a functional.
        if count > most {
            return Ok(None);
        }
        let form = self.weak_form();
        let (mut all, mut functionals) = (Vec::new(), 0);
        for k in 0..count {
            let data = get(k)?;
            functionals += form.trajectory(k, &data)?.noise.len();
            if functionals > most {
                return Ok(None);
            }
            all.push(data);
        }
        Ok(Some((all, functionals)))
    }

    /// F^T F and F^T Y of all trajectories.
    fn normal<E: Send>(
        &self,
        count: usize,
        first: &TrajectoryData,
        get: &(impl Fn(usize) -> Result<TrajectoryData, StreamError<E>> + Sync),
        landmarks: &Landmarks,
    ) -> Result<Normal, StreamError<E>> {
        let columns = landmarks.rank() * (first.input_count() + 1);
        let mut normal = Normal::new(columns, first.dimension());
        for start in (0..count).step_by(GROUP * GROUPS) {
            let end = count.min(start + GROUP * GROUPS);
            let groups: Vec<Range<usize>> =
                (start..end).step_by(GROUP).map(|k| k..end.min(k + GROUP)).collect();
            let rows: Vec<Result<Rows, StreamError<E>>> = groups
                .into_par_iter()
                .map(|group| self.rows(group, first, get, landmarks))
                .collect();
            let rows: Vec<Rows> = rows.into_iter().collect::<Result<_, _>>()?;
            normal.add(&rows);
        }
        Ok(normal)
    }

    /// Rows of F and Y of a few trajectories.
    fn rows<E>(
        &self,
        group: Range<usize>,
        first: &TrajectoryData,
        get: &impl Fn(usize) -> Result<TrajectoryData, StreamError<E>>,
        landmarks: &Landmarks,
    ) -> Result<Rows, StreamError<E>> {
        let shape = [first.dimension(), first.input_count(), first.argument_count()];
        let (form, mut equations) = (self.weak_form(), Equations::new(shape));
        for k in group {
            let data = get(k)?;
            check_shape(first, &data, k)?;
            equations.append(&form, k, &data)?;
        }
        let mut features = landmarks.features_of(&equations.occupation);
        equations.whiten(&mut features).map_err(FitError::from)?;
        let right = equations.right_hand_sides().map_err(FitError::from)?;
        Ok(Rows { features, right })
    }
}

/// Kernel arguments from which landmarks are taken, rows of d: evenly from all trajectories, without a period.
fn candidates<E>(
    count: usize,
    first: &TrajectoryData,
    get: &impl Fn(usize) -> Result<TrajectoryData, StreamError<E>>,
) -> Result<Vec<f64>, StreamError<E>> {
    let d = first.argument_count();
    let each = CANDIDATES.div_ceil(count.min(CANDIDATE_TRAJECTORIES));
    let mut candidates = Vec::new();
    let mut place = 0.0;
    for k in sample(count, CANDIDATE_TRAJECTORIES) {
        let data = get(k)?;
        check_shape(first, &data, k)?;
        for _ in 0..each {
            place = (place + GOLDEN) % 1.0;
            let sample = (place * data.samples() as f64) as usize;
            candidates.extend_from_slice(&data.arguments()[sample * d..(sample + 1) * d]);
        }
    }
    Ok(candidates)
}
