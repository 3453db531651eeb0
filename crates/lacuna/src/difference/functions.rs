//! Drift and control effectiveness of both sides at the states where both are known.

use super::Side;
use crate::identification::Columns;
use crate::occupation::IdentifiedModel;
use nalgebra::DMatrix;
use std::error::Error;

/// States of each side at which functions are compared, about.
const STATES: usize = 400;
/// A function is known where its standard deviation is below this share of its size, or of what moves the channel.
const KNOWN: f64 = 0.3;
/// Fewest states to compare at.
const FEWEST: usize = 40;
/// An inverse of g is a mass matrix where its two halves differ by less than this share.
const ASYMMETRY: f64 = 0.2;

/// Which function an entry is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    /// Drift of a channel: F, or f.
    Drift(usize),
    /// Effectiveness: an entry of M, or of g.
    Effectiveness(usize, usize),
}

/// One function of both sides.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Which.
    pub of: Of,
    /// What was simulated, state by state.
    pub simulated: Vec<f64>,
    /// What was recorded.
    pub recorded: Vec<f64>,
    /// Standard deviation of the difference.
    pub std: Vec<f64>,
    /// Size of what it is a part of: root mean square.
    pub scale: f64,
}

impl Entry {
    /// What was recorded less what was simulated.
    #[must_use]
    pub fn difference(&self) -> Vec<f64> {
        self.recorded.iter().zip(&self.simulated).map(|(r, s)| r - s).collect()
    }
}

/// All functions at common states.
#[derive(Clone, Debug)]
pub struct Functions {
    pub states: Vec<Vec<f64>>,
    /// Share of the visited states that were left out, as one of the sides does not know its functions there.
    pub left_out: f64,
    /// Whether drift is a force in the units of the inputs, and effectiveness the mass matrix.
    pub as_forces: bool,
    pub entries: Vec<Entry>,
}

/// f and g with their standard deviations, at one state.
#[derive(Clone)]
struct Values {
    f: Vec<f64>,
    g: Vec<f64>,
    f_std: Vec<f64>,
    g_std: Vec<f64>,
}

impl Values {
    fn of(model: &IdentifiedModel, x: &[f64]) -> Result<Self, Box<dyn Error>> {
        let (n, m) = (model.dimension(), model.inputs());
        let (mut f, mut g) = (vec![0.0; n], vec![0.0; n * m]);
        model.evaluate(x, &mut f, &mut g)?;
        let sd = model.standard_deviations(x)?.ok_or("the model has no standard deviations")?;
        Ok(Self { f, g, f_std: sd.f, g_std: sd.g })
    }

    /// M and F in the place of g and f; none where g has no inverse that is a mass matrix.
    fn as_forces(&self) -> Option<Self> {
        let n = self.f.len();
        let mass = DMatrix::from_row_slice(n, n, &self.g).try_inverse()?;
        let odd: f64 = (&mass - mass.transpose()).norm();
        if odd > ASYMMETRY * mass.norm() || (0..n).any(|i| mass[(i, i)] <= 0.0) {
            return None;
        }
        let force = &mass * DMatrix::from_column_slice(n, 1, &self.f);
        // dM = -M dg M and dF = M (df - dg F), whose parts are taken as independent.
        let square = mass.map(|m| m * m);
        let variance = DMatrix::from_row_slice(n, n, &self.g_std).map(|s| s * s);
        let of_mass = &square * &variance * &square;
        let of_force = DMatrix::from_fn(n, 1, |i, _| {
            self.f_std[i].powi(2) + (0..n).map(|j| variance[(i, j)] * force[j].powi(2)).sum::<f64>()
        });
        let of_force = &square * of_force;
        Some(Self {
            f: force.iter().copied().collect(),
            g: mass.transpose().iter().copied().collect(),
            f_std: of_force.iter().map(|v| v.sqrt()).collect(),
            g_std: of_mass.transpose().iter().map(|v| v.sqrt()).collect(),
        })
    }
}

/// How large the functions of a side are over the states: medians, since where they are not known they may be anything.
struct Sizes {
    f: Vec<f64>,
    /// Of what an input does, on any channel.
    g: Vec<f64>,
}

impl Sizes {
    fn of(values: &[Values], moves_by: &[f64]) -> Self {
        let (n, m) = (values[0].f.len(), moves_by.len());
        let usual = |of: &dyn Fn(&Values) -> f64| {
            let mut all: Vec<f64> = values.iter().map(|v| of(v).abs()).collect();
            all.sort_by(f64::total_cmp);
            all[all.len() / 2]
        };
        let g = |i: usize, j: usize| usual(&|v| v.g[i * m + j]);
        let driven = |i: usize| (0..m).map(|j| g(i, j) * moves_by[j]).sum::<f64>();
        Self {
            f: (0..n).map(|i| usual(&|v| v.f[i]).max(driven(i))).collect(),
            g: (0..m).map(|j| (0..n).map(|i| g(i, j)).fold(0.0, f64::max)).collect(),
        }
    }

    fn tell(&self, values: &Values) -> bool {
        let m = self.g.len();
        let f = values.f_std.iter().zip(&self.f).all(|(std, size)| *std <= KNOWN * size);
        f && values.g_std.iter().enumerate().all(|(k, std)| *std <= KNOWN * self.g[k % m])
    }
}

impl Functions {
    /// Of both sides, at the states that either visits.
    pub fn of(sides: [&Side; 2], columns: &Columns) -> Result<Self, Box<dyn Error>> {
        let visited = sides.map(|side| side.states(STATES)).concat();
        let inputs = columns.inputs.len();
        let moves_by = [0, 1].map(|k| sides[k].input_sizes(inputs));
        let everywhere = |side: &Side| {
            visited.iter().map(|x| Values::of(&side.model, x)).collect::<Result<Vec<_>, _>>()
        };
        let [simulated, recorded] = [everywhere(sides[0])?, everywhere(sides[1])?];
        let sizes = [Sizes::of(&simulated, &moves_by[0]), Sizes::of(&recorded, &moves_by[1])];
        let (mut states, mut values) = (vec![], vec![]);
        for (x, (a, b)) in visited.iter().zip(simulated.into_iter().zip(recorded)) {
            if sizes[0].tell(&a) && sizes[1].tell(&b) {
                states.push(x.clone());
                values.push([a, b]);
            }
        }
        if states.len() < FEWEST {
            return Err(format!(
                "of the {} states that the recordings visit, both sides are known at {}; at least {FEWEST} are \
                 needed: let both move through the same range, driven richly enough",
                visited.len(),
                states.len()
            )
            .into());
        }
        let left_out = 1.0 - states.len() as f64 / visited.len() as f64;
        let forces = (columns.channels.len() == inputs)
            .then(|| values.iter().map(|v| Some([v[0].as_forces()?, v[1].as_forces()?])))
            .and_then(Iterator::collect::<Option<Vec<_>>>);
        let (as_forces, values) = match forces {
            Some(forces) => (true, forces),
            None => (false, values),
        };
        let entries = entries(&values, as_forces, &moves_by);
        Ok(Self { states, left_out, as_forces, entries })
    }
}

fn entries(values: &[[Values; 2]], as_forces: bool, moves_by: &[Vec<f64>; 2]) -> Vec<Entry> {
    let (n, m) = (values[0][0].f.len(), moves_by[0].len());
    let series = |of: &dyn Fn(&Values) -> f64, side: usize| -> Vec<f64> {
        values.iter().map(|v| of(&v[side])).collect()
    };
    let entry = |what: Of, value: &dyn Fn(&Values) -> f64, std: &dyn Fn(&Values) -> f64| {
        let std = series(std, 0).iter().zip(series(std, 1)).map(|(a, b)| a.hypot(b)).collect();
        Entry { of: what, simulated: series(value, 0), recorded: series(value, 1), std, scale: 0.0 }
    };
    let mut all = vec![];
    for i in 0..n {
        let mut drift = entry(Of::Drift(i), &|v| v.f[i], &|v| v.f_std[i]);
        // What moves the channel: its drift, and what the inputs do.
        let driven = |side: usize| match as_forces {
            true => moves_by[side][i],
            false => {
                (0..m).map(|j| rms(&series(&|v| v.g[i * m + j], side)) * moves_by[side][j]).sum()
            }
        };
        drift.scale = rms(&drift.simulated).max(rms(&drift.recorded)).max(driven(0)).max(driven(1));
        all.push(drift);
    }
    for i in 0..n {
        // A mass matrix is symmetric.
        for j in (if as_forces { i } else { 0 })..m {
            let k = i * m + j;
            let mut one = entry(Of::Effectiveness(i, j), &|v| v.g[k], &|v| v.g_std[k]);
            let size = |k: usize| rms(&series(&|v| v.g[k], 0));
            one.scale = match as_forces {
                true => (size(i * m + i) * size(j * m + j)).sqrt(),
                false => (0..n).map(|i| size(i * m + j)).fold(0.0, f64::max),
            };
            all.push(one);
        }
    }
    all
}

/// Root mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}
