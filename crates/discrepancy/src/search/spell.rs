//! Names for a learned curve. Laws are tried one by one, and a law with much freedom can stand for
//! two simple ones that only together are right; a free curve shows them both. Where one or two
//! laws of the catalogue follow the curve as well as the recordings can tell, they are its name.

use super::forward::{curve_covers, says_alike};
use super::prune::worth_a_curve;
use super::{Named, Path, Rival, Search, chain, effect_of};
use crate::candidates::{Candidate, Term};
use crate::likelihood::{FULL, Fit, QUICK};
use crate::trajectories::SmoothedRecording;
use lacuna_effects::{At, Channel, Law, Variable};
use lacuna_plants::model::ModelEffect;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Samples at which laws are compared with the curve.
const POINTS: usize = 2000;
/// Spellings that are fitted with the differential equation.
const FITTED: usize = 4;

/// One or two laws with amplitudes, and how far they are from the curve.
struct Spelling {
    laws: Vec<(Term, Vec<f64>)>,
    squares: f64,
}

/// The basis of each term at some samples of the motion.
struct Columns {
    terms: Vec<(Term, std::ops::Range<usize>)>,
    /// Products of all columns; the first is the variable itself, the last the curve.
    products: DMatrix<f64>,
}

impl<'p> Search<'p> {
    /// The path with its last effect, a curve, spelled in laws of the catalogue; unchanged where
    /// they do not follow it.
    pub(super) fn spelled(&self, path: Path<'p>) -> Path<'p> {
        let Some(curve) = path.fit.hypothesis.supposed().last() else { return path };
        let last = path.fit.hypothesis.supposed().len() - 1;
        let plain = path.fit.hypothesis.clone().without(last);
        let spellings = self.spellings(&path.fit, curve);
        let fits = spellings.into_par_iter().filter_map(|spelling| {
            let effects = spelling.laws.iter().map(|(t, a)| effect_of(&t.candidate, a, &t.shape));
            let h = effects.fold(plain.clone(), |h, e| self.with(&h, e));
            let begun = chain::begin(&path.fit, h).ok()?;
            let grown = chain::grow(&path.fit, &path.fit, begun).ok()?;
            Some(chain::improved(grown, FULL))
        });
        let temperature = path.fit.temperature();
        let evidence = |f: &Fit| f.log_evidence(temperature);
        let fits: Vec<Fit> = fits.collect();
        // What lies far behind the best, or behind a curve that leaves nothing but noise, does not win.
        let curve = Some(&path.fit).filter(|f| f.excess() < self.decision.explained - 1.0);
        let top = fits.iter().chain(curve).map(evidence).fold(f64::NEG_INFINITY, f64::max);
        let least = top - self.settled_room();
        let likely = |f: Fit<'p>| if f.hope(temperature) > least { chain::polish(f) } else { f };
        let mut fits: Vec<Fit> = fits.into_par_iter().map(likely).collect();
        fits.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
        let Some(best) = fits.into_iter().find(|fit| self.needs_all(fit, last)) else {
            return path;
        };
        let lead = evidence(&best) - evidence(&path.fit);
        self.watch.tell(&format!("named laws lead the curve by {lead:.1} nats"));
        // Where neither leaves nothing but noise, what the curve follows better need not be physics.
        let decision = &self.decision;
        let nearly = path.fit.excess() > decision.explained - 1.0
            && !worth_a_curve(decision, &best, &path.fit);
        if lead > 0.0 || nearly {
            self.named_instead(path, best, lead.max(decision.tie))
        } else {
            path
        }
    }

    /// Whether each of the laws from `first` on that spell a curve leads what the other leaves without a
    /// formula. Where they leave more than noise the curve is no better an answer than two names.
    fn needs_all(&self, fit: &Fit<'p>, first: usize) -> bool {
        let supposed = fit.hypothesis.supposed();
        if supposed.len() - first < 2 || fit.reduced() > self.decision.explained {
            return true;
        }
        let without = |k: usize| Some((k, fit.without(k, QUICK).ok()?));
        // That without which the others do best.
        let least = (first..supposed.len()).filter_map(without);
        let least = least.min_by(|a, b| a.1.misfit().total_cmp(&b.1.misfit()));
        // Nothing follows without either.
        let Some((k, base)) = least else { return true };
        let further = Candidate::of(&supposed[k]);
        if !base.hypothesis.supposed().iter().any(|e| says_alike(e, &further)) {
            return true;
        }
        let leads = self.leads_over_remainders(&base, (fit, &supposed[k]), None);
        leads.is_none_or(|all| !all.iter().any(|l| l.is_beaten(false, &self.decision)))
    }

    /// The path with the last laws of a fit in the place of its own last effect, which lies behind by `lead`.
    pub(super) fn named_instead(&self, mut path: Path<'p>, best: Fit<'p>, lead: f64) -> Path<'p> {
        path.named.pop();
        let h = &path.fit.hypothesis;
        let candidate = h.supposed().last().map(Candidate::of);
        let rivals: Vec<Rival> = candidate
            .map(|candidate| Rival { candidate, behind: lead, hypothesis: h.clone() })
            .into_iter()
            .collect();
        for k in path.named.len()..best.hypothesis.supposed().len() {
            let gain = best.gained_by(k).unwrap_or(0.0);
            path.named.push(Named { gain, rivals: rivals.clone() });
        }
        Path { fit: best, ..path }
    }

    /// Single laws and pairs of them that come nearest to a curve along the motion.
    fn spellings(&self, fit: &Fit, curve: &ModelEffect) -> Vec<Spelling> {
        let Some(columns) = self.columns(fit, curve) else { return vec![] };
        let mut best: Vec<(Vec<Candidate>, Spelling)> = vec![];
        let count = columns.terms.len();
        for i in 0..count {
            for j in i..count {
                let (a, b) = (columns.terms[i].0.candidate, columns.terms[j].0.candidate);
                if i != j && a.excludes(&b) {
                    continue;
                }
                let chosen = if i == j { vec![i] } else { vec![i, j] };
                let Some(spelling) = columns.spelling(&chosen) else { continue };
                let key: Vec<Candidate> = spelling.laws.iter().map(|(t, _)| t.candidate).collect();
                match best.iter_mut().find(|(k, _)| *k == key) {
                    Some((_, old)) if old.squares <= spelling.squares => {}
                    Some((_, old)) => *old = spelling,
                    None => best.push((key, spelling)),
                }
            }
        }
        best.sort_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
        best.into_iter().take(FITTED).map(|(_, s)| s).collect()
    }

    /// The curve and all laws that depend on nothing else, along the motion of a fit.
    fn columns(&self, fit: &Fit, curve: &ModelEffect) -> Option<Columns> {
        let places = self.problem.model.places(curve.effect, curve.channel, None);
        let motion = self.motion(fit);
        let motion = samples(&motion, &places);
        let over_velocity = curve.over()? == Variable::Velocity;
        let mut rows: Vec<Vec<f64>> =
            vec![motion.iter().map(|at| if over_velocity { at.v() } else { at.q() }).collect()];
        let mut terms = vec![];
        for c in self.candidates.iter().filter(|c| curve_covers(curve, c)) {
            let scales = self.problem.scales(c.effect, c.channel, c.other);
            for shape in c.shapes(&scales) {
                let first = rows.len();
                rows.extend(series(c, &shape, &motion)?);
                terms.push((Term { candidate: *c, shape }, first..rows.len()));
            }
        }
        let internal = curve.internal();
        let Law::Force(law) = curve.effect.law else { return None };
        let (amplitudes, shape) = internal.split_at(law.amplitudes());
        let knots = series(&Candidate::of(curve), shape, &motion)?;
        let value = |k: usize| amplitudes.iter().zip(&knots).map(|(a, s)| a * s[k]).sum();
        rows.push((0..motion.len()).map(value).collect());
        let matrix = DMatrix::from_fn(motion.len(), rows.len(), |i, j| rows[j][i]);
        Some(Columns { terms, products: matrix.tr_mul(&matrix) })
    }

    /// A fit's motion on the recordings; nothing where it diverges.
    fn motion(&self, fit: &Fit) -> Vec<SmoothedRecording> {
        let Ok(paths) = fit.paths() else { return vec![] };
        let along = |(r, path): (usize, &Vec<f64>)| self.problem.motion(&fit.hypothesis, r, path);
        paths.iter().enumerate().map(along).collect()
    }
}

/// What laws on some channels see at some samples of a motion.
fn samples<'m>(motion: &'m [SmoothedRecording], channels: &'m [Channel]) -> Vec<At<'m>> {
    let total: usize = motion.iter().map(SmoothedRecording::len).sum();
    let every = total.div_ceil(POINTS).max(1);
    let of = |s: &'m SmoothedRecording| (0..s.len()).step_by(every).map(move |k| s.at(channels, k));
    motion.iter().flat_map(of).collect()
}

impl Columns {
    /// Some terms fitted to the curve by least squares, beside a share of the variable itself,
    /// which parameters of the model can usually take.
    fn spelling(&self, chosen: &[usize]) -> Option<Spelling> {
        let mut at = vec![0];
        at.extend(chosen.iter().flat_map(|&k| self.terms[k].1.clone()));
        let curve = self.products.ncols() - 1;
        let normal = self.products.select_rows(&at).select_columns(&at);
        let right = DVector::from_iterator(at.len(), at.iter().map(|&i| self.products[(i, curve)]));
        // Columns of very different units.
        let unit: Vec<f64> = (0..at.len()).map(|i| normal[(i, i)].sqrt()).collect();
        if unit.iter().any(|u| *u <= 0.0 || !u.is_finite()) {
            return None;
        }
        let scaled = DMatrix::from_fn(at.len(), at.len(), |i, j| {
            normal[(i, j)] / (unit[i] * unit[j]) + if i == j { 1e-9 } else { 0.0 }
        });
        let right = DVector::from_fn(at.len(), |i, _| right[i] / unit[i]);
        let solved = scaled.cholesky()?.solve(&right);
        let squares = self.products[(curve, curve)] - solved.dot(&right);
        let mut amplitudes = solved.iter().zip(&unit).map(|(s, u)| s / u).skip(1);
        let laws = chosen
            .iter()
            .map(|&k| {
                let (term, columns) = &self.terms[k];
                (term.clone(), amplitudes.by_ref().take(columns.len()).collect())
            })
            .collect();
        Some(Spelling { laws, squares })
    }
}

/// The basis of a law at some samples: one series an amplitude.
fn series(c: &Candidate, shape: &[f64], at: &[At]) -> Option<Vec<Vec<f64>>> {
    let Law::Force(law) = c.effect.law else { return None };
    let mut out = vec![Vec::with_capacity(at.len()); law.amplitudes()];
    let mut basis = vec![0.0; law.amplitudes()];
    for at in at {
        law.plain().along(shape, at, &mut basis);
        out.iter_mut().zip(&basis).for_each(|(series, b)| series.push(*b));
    }
    Some(out)
}
