//! What each amplitude of a term changes in the outputs, and its normal equations.

use super::local::{Along, Local};
use super::servo;
use super::{Amplitudes, Screen};
use crate::candidates::{Candidate, Term};
use crate::likelihood::lanes::Lanes;
use crate::likelihood::maps::{Drive, Driven};
use lacuna_effects::{AnySeriesLaw, Law};
use lacuna_numbers::{Dual, LANES, Linear, Number};
use lacuna_plants::model::Measured;
use nalgebra::{DMatrix, DVector};

impl Candidate {
    /// Columns of a term's amplitudes: of a force law its own, of other laws one.
    pub(crate) fn amplitudes(&self) -> usize {
        match self.effect.law {
            Law::Force(law) => law.amplitudes(),
            Law::Structure(law) => law.amplitudes(),
            Law::Input(_) | Law::Sensor(_) => 1,
        }
    }

    /// Of so many terms as many as are propagated at once.
    pub(super) fn at_once(&self, terms: usize) -> usize {
        match self.effect.law {
            // All shapes are told by the same few series.
            Law::Structure(_) => terms.max(1),
            _ => (LANES / self.amplitudes()).max(1),
        }
    }
}

impl Screen<'_> {
    /// Normal equations of the amplitudes of several terms of one candidate along one recording, as
    /// many as fit in the lanes; of one term, where it has more amplitudes.
    pub(super) fn amplitudes_along(&self, terms: &[Term], along: &Along) -> Vec<Amplitudes> {
        let each = terms[0].candidate.amplitudes();
        let sums = self.sums(each * terms.len(), each > 1, &self.driven(terms, along), along);
        (0..terms.len()).map(|t| sums.of(t * each, each)).collect()
    }

    /// Normal equations of forces on a channel along one recording, each given at every sample.
    pub(super) fn of_forces(
        &self,
        channel: usize,
        series: &[Vec<f64>],
        along: &Along,
    ) -> Amplitudes {
        let places = vec![(Drive::Force(channel), Lanes([1.0; LANES]))];
        let sees = self.problem.observation.sees_forces();
        let mut driven = Driven::beside(series.len(), along.motion.len(), sees, (places, vec![]));
        for (lane, now) in series.iter().enumerate() {
            driven[lane / LANES].set(lane % LANES, &centred(now), now, 1.0);
        }
        self.sums(series.len(), true, &driven, along).of(0, series.len())
    }

    /// Normal equations of so many columns along one recording.
    pub(super) fn sums(
        &self,
        count: usize,
        crossed: bool,
        driven: &[Driven],
        along: &Along,
    ) -> Sums {
        let mut sums = Sums::new(count, self.theta.nrows());
        for local in &along.windows {
            let normal = Normal { along, local, driven, crossed };
            sums.add(&pulp::Arch::new().dispatch(normal), local);
        }
        sums
    }

    /// The amplitudes of all terms, one a lane.
    fn driven(&self, terms: &[Term], along: &Along) -> Vec<Driven> {
        let Candidate { effect, channel, other } = terms[0].candidate;
        let each = terms[0].candidate.amplitudes();
        let place = |drive| (drive, Lanes([1.0; LANES]));
        let (places, seen) = match effect.law {
            Law::Force(law) => {
                let reaction = other.filter(|_| law.reacts()).map(Drive::Force);
                let drives = std::iter::once(Drive::Force(channel)).chain(reaction);
                (drives.map(place).collect(), vec![])
            }
            Law::Input(_) => {
                let model = self.problem.model;
                let inner = model.in_servo(effect, channel).and(model.servo_of(channel));
                let drive = match inner {
                    Some((_, servo)) => Drive::Force(servo.coordinate),
                    None => Drive::Input(channel),
                };
                (vec![place(drive)], vec![])
            }
            Law::Sensor(_) => {
                let outputs = self.problem.dataset.outputs.iter();
                let is = |o: &crate::Output| matches!(o.of, Measured::State(i) if i == channel);
                (vec![], outputs.enumerate().filter(|(_, o)| is(o)).map(|(k, _)| k).collect())
            }
            // What drives every coordinate by itself is another matter: `of_structure`.
            Law::Structure(_) => (vec![], vec![]),
        };
        let at_once = matches!(effect.law, Law::Force(_)) && self.problem.observation.sees_forces();
        let (count, samples) = (each * terms.len(), along.motion.len());
        let mut driven = Driven::beside(count, samples, at_once, (places, seen));
        let mut lane = 0;
        self.each_series(terms, along, |series, now, passed_on| {
            driven[lane / LANES].set(lane % LANES, series, now, passed_on);
            lane += 1;
        });
        driven
    }

    /// Each amplitude's series from sample to sample and, of a force, at the samples, and the share
    /// of it that is passed on to another channel.
    fn each_series(
        &self,
        terms: &[Term],
        along: &Along,
        mut each: impl FnMut(&[f64], &[f64], f64),
    ) {
        let Candidate { effect, channel, other } = terms[0].candidate;
        match effect.law {
            Law::Force(law) => {
                let places = self.problem.model.places(effect, channel, other);
                let shapes = terms.iter().map(|t| &t.shape[..]);
                along.motion.bases(law, shapes, &places, |shape, series| {
                    for series in &series {
                        each(&centred(series), series, law.plain().passed_on(shape));
                    }
                });
            }
            Law::Input(_) if self.problem.model.in_servo(effect, channel).is_some() => {
                let h = &self.fit.hypothesis;
                let known = (&h.parameters[..], &h.effects[..]);
                for term in terms {
                    let change = servo::change(self.problem.model, known, term, &along.motion);
                    change.iter().for_each(|change| each(&change.between, &change.at, 1.0));
                }
            }
            Law::Input(law) => {
                let m = self.problem.model.input_width();
                let u: Vec<f64> =
                    along.maps.inputs.iter().skip(channel).step_by(m).copied().collect();
                for term in terms {
                    let mut made = law.plain().applied(&term.shape, &along.motion.times, &u);
                    made.iter_mut().zip(&u).for_each(|(made, u)| *made -= u);
                    each(&made, &[], 1.0);
                }
            }
            Law::Sensor(law) => {
                let mut series = vec![0.0; along.motion.len()];
                let ideal = effect.nature.ideal[0];
                for local in &along.windows {
                    let range = local.window.range.clone();
                    let truth: Vec<f64> =
                        range.clone().map(|k| along.motion.state(k)[channel]).collect();
                    let times = &along.motion.times[range.clone()];
                    series[range].copy_from_slice(&sensed(law, ideal, times, &truth));
                }
                terms.iter().for_each(|_| each(&series, &[], 1.0));
            }
            Law::Structure(_) => {}
        }
    }
}

/// Where changes act, each one's share there, and the outputs that show them as they are.
type Places = (Vec<(Drive, Lanes)>, Vec<usize>);

impl Driven {
    /// So many changes in as few groups as hold them, nothing yet.
    fn beside(count: usize, samples: usize, at_once: bool, (places, seen): Places) -> Vec<Self> {
        let empty = || Self {
            series: vec![Lanes::ZERO; samples],
            apart: vec![],
            at_once: vec![Lanes::ZERO; if at_once { samples } else { 0 }],
            places: places.clone(),
            seen: seen.clone(),
        };
        (0..count.div_ceil(LANES)).map(|_| empty()).collect()
    }

    /// One of them: its values from sample to sample and at the samples, and the share of it that is
    /// passed on to another channel.
    fn set(&mut self, lane: usize, series: &[f64], now: &[f64], passed_on: f64) {
        self.series.iter_mut().zip(series).for_each(|(lanes, value)| lanes.0[lane] = *value);
        self.at_once.iter_mut().zip(now).for_each(|(lanes, value)| lanes.0[lane] = *value);
        if let Some((_, reaction)) = self.places.get_mut(1) {
            reaction.0[lane] = -passed_on;
        }
    }
}

/// Change of the measured samples of a true series per unit of a sensor's parameter, which is ideal.
pub(crate) fn sensed(law: &dyn AnySeriesLaw, ideal: f64, times: &[f64], truth: &[f64]) -> Vec<f64> {
    let truth: Vec<Dual> = truth.iter().map(|x| Dual::constant(*x)).collect();
    let moved = law.dual().applied(&[Dual::direction(ideal, 0)], times, &truth);
    moved.iter().map(|y| y.tangent[0]).collect()
}

/// Over each step the mean of both ends; over what follows the last sample nothing is known.
pub(super) fn centred(series: &[f64]) -> Vec<f64> {
    let means = series.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]));
    means.chain(series.last().copied()).collect()
}

/// The normal equations of a window in the making.
struct Normal<'a> {
    along: &'a Along,
    local: &'a Local,
    driven: &'a [Driven],
    /// Whether columns belong together, so that their products are needed.
    crossed: bool,
}

/// Products of the columns in the lanes of each group: with the rows' own columns, and with one
/// another.
struct Products {
    /// Group by group: states, theta, residual.
    rows: Vec<Lanes>,
    /// Column by column: all groups.
    own: Vec<Lanes>,
}

impl pulp::WithSimd for Normal<'_> {
    type Output = Products;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Products {
        let Self { along, local, driven, crossed } = self;
        let (m, width) = (driven.len(), local.rows.width());
        let mut rows = vec![Lanes::ZERO; m * width];
        let mut own = vec![Lanes::ZERO; m * LANES * m];
        let filter = along.maps.filters.get(local.number);
        along.maps.respond(simd, &local.window.range, filter, driven, |at, changes| {
            for (output, row) in local.rows.at(at) {
                let y = &changes[output * m..(output + 1) * m];
                for (y, sums) in y.iter().zip(rows.chunks_exact_mut(width)) {
                    for (sum, value) in sums.iter_mut().zip(row) {
                        sum.add_scaled(simd, y, *value);
                    }
                }
                if crossed {
                    let columns = y.iter().flat_map(|y| &y.0);
                    for (value, sums) in columns.zip(own.chunks_exact_mut(m)) {
                        for (sum, y) in sums.iter_mut().zip(y) {
                            sum.add_scaled(simd, y, *value);
                        }
                    }
                } else {
                    // Each column's square, on the diagonal.
                    for (g, y) in y.iter().enumerate() {
                        own[g].add_product(simd, y, y);
                    }
                }
            }
        });
        if !crossed {
            own = on_the_diagonal(&own[..m], m);
        }
        Products { rows, own }
    }
}

/// Squares of each column where products of all would be.
fn on_the_diagonal(squares: &[Lanes], m: usize) -> Vec<Lanes> {
    let mut own = vec![Lanes::ZERO; m * LANES * m];
    for (g, squares) in squares.iter().enumerate() {
        for (l, square) in squares.0.iter().enumerate() {
            own[(g * LANES + l) * m + g].0[l] = *square;
        }
    }
    own
}

/// Normal equations of all columns, the states of all windows eliminated.
pub(super) struct Sums {
    own: DMatrix<f64>,
    theta: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Sums {
    fn new(count: usize, p: usize) -> Self {
        let (own, theta) = (DMatrix::zeros(count, count), DMatrix::zeros(count, p));
        Self { own, theta, gradient: DVector::zeros(count) }
    }

    /// Add a window.
    fn add(&mut self, products: &Products, local: &Local) {
        let (count, p, width) = (self.own.nrows(), self.theta.ncols(), local.rows.width());
        let n = width - p - 1;
        let m = products.rows.len() / width;
        let row = |i: usize, c: usize| products.rows[c / LANES * width + i].0[c % LANES];
        let states = DMatrix::from_fn(n, count, row);
        let solved = local.eliminated.solve(&states);
        let own = |i: usize, j: usize| products.own[i * m + j / LANES].0[j % LANES];
        self.own += DMatrix::from_fn(count, count, own) - states.tr_mul(&solved);
        let theta = DMatrix::from_fn(count, p, |c, j| row(n + j, c));
        self.theta += theta - states.tr_mul(&local.cross);
        let gradient = DVector::from_fn(count, |c, _| row(n + p, c));
        self.gradient += gradient - states.tr_mul(&local.rest);
    }

    /// What all columns are expected to move in squares, each by an amplitude `N(0, 1)` of its own, and the
    /// variance of that.
    pub(super) fn squares(&self) -> (f64, f64) {
        (self.own.trace(), 2.0 * self.own.norm_squared())
    }

    /// Those of one term.
    pub(super) fn of(&self, first: usize, each: usize) -> Amplitudes {
        Amplitudes {
            own: self.own.view((first, first), (each, each)).into_owned(),
            theta: self.theta.rows(first, each).into_owned(),
            gradient: self.gradient.rows(first, each).into_owned(),
        }
    }
}
