//! The missing force that the measured motion needs.
//!
//! Every channel c of the machine obeys `M(q) q'' - F(q, q', u; p) = r`, a first-order state
//! `h' - D = r`. The recordings tell r along the path that was measured: no trajectory of the
//! model is needed, which may have run away. Under a test function phi of compact support
//!
//! ```text
//! y_w = int phi_w R(x^; p_0)_c dt + sum_k l_w(k) (y(t_k) - x^(t_k)),        R = M q'' - F
//! l_w = [(phi M)'' + phi R_q - (phi R_v)'] dt      on coordinates   (sensors of rates: -(phi M)' + phi R_v)
//!       [-phi' + phi R_h] dt                       on the channel's own first-order state
//! ```
//!
//! with x^ the smoothed motion. The second term moves all derivatives from the motion's errors
//! onto phi: to first order x^ drops out, what is left is a weak form of the samples y
//! themselves, linear in their noise, whose covariance is exact:
//! `S_ab = sum sigma^2 sum_k l_a(k) l_b(k)`. The rows of a channel are
//!
//! ```text
//! y_w = int phi_w f(x(t)) dt + int phi_w n dt - P_w (p - p_0) + e_w,    P_w = int phi_w dR/dp dt
//! f ~ GP(0, a^2 k + b^2 (1 + x x')),   p ~ N(p_0, tolerance^2),   n white of density rho^2,   e ~ N(0, S)
//! ```
//!
//! so that two rows of f have the covariance `<Gamma_a, Gamma_b> = int int phi_a phi_b k(x(t), x(s))`,
//! the Gram matrix of their occupation kernels. f is one function, or a sum of functions, of the
//! channel's coordinate, its velocity and time; it is held by its values at even knots, between
//! them along straight lines. Its size a, length, smoothness (Matern) and rho have the greatest
//! marginal likelihood, b is wide; the evidence of a variable is the mean over the grid of each. What the
//! model's parameters could do is not told from f by more than their tolerances allow: the
//! standard deviation of f holds that doubt, lessened by what the other channels say of them.
//! A second pass is linearised about the parameters and the force that the first one found, so
//! that errors of the path are errors in the variable of f, too.
//!
//! | on paper | in code |
//! | --- | --- |
//! | p_0, tolerance, effects that are known | [`Belief`] |
//! | R, its derivatives along x^ | `along`, of a measured force `measured` |
//! | phi, phi', phi'' over windows | `windows` ([`lacuna_occupation::TestFunction::Compact`]) |
//! | y_w, P_w, S | `rows` ([`lacuna_occupation::SymmetricBanded`]) |
//! | int phi f(x) dt by values at knots | `knots` |
//! | marginal likelihood, posterior | `evidence` ([`lacuna_occupation::identification::evidence`]) |
//! | which variables | `choice` |
//! | laws of all channels together: columns c_k, sets of them, where an edge stands | [`laws()`], `columns`, `laws::subset`, `laws::edges` |
//! | f with its standard deviation where the recordings went | [`Learned`] |
//!
//! On an imposed coordinate the force f is measured that moves it, `y = h(x, f)`: there
//!
//! ```text
//! R = (y - h(x^)) / (dh/dr),     l_w = phi / (dh/dr) dt     on the force's own samples
//! ```
//!
//! A channel whose equation holds a state that nothing measures, or a sensor that is not believed,
//! has no missing force that could be told.

mod along;
mod choice;
mod columns;
mod curve;
mod evidence;
mod knots;
mod laws;
mod measured;
mod rows;
mod windows;

use crate::likelihood::Problem;
use crate::screen::Over;
use along::Along;
use choice::{Chosen, choose};
pub use curve::Learned;
use evidence::Evidence;
use faer::Mat;
use knots::Knots;
use lacuna_effects::Law;
use lacuna_plants::Model;
use lacuna_plants::model::ModelEffect;
pub use laws::{Instead, Obeyed, laws};
use rayon::prelude::*;
use rows::{Rows, window_intervals};

/// What is believed of the machine.
#[derive(Clone, Debug)]
pub struct Belief<'a> {
    /// Values of the model's parameters.
    pub parameters: Vec<f64>,
    /// Those that are known within their tolerance alone.
    pub uncertain: Vec<usize>,
    /// Effects that act, the model's own among them.
    pub effects: &'a [ModelEffect],
    /// Nats that a force over a further variable must gain.
    pub prior_odds: f64,
}

impl<'a> Belief<'a> {
    /// A model as it is: its parameters within their tolerances, its own effects.
    #[must_use]
    pub fn of(model: &'a Model, prior_odds: f64) -> Self {
        let uncertain = (0..model.parameters.len()).filter(|&k| model.parameters[k].std() > 0.0);
        let uncertain = uncertain.collect();
        Self { parameters: model.values(), uncertain, effects: &model.effects, prior_odds }
    }
}

/// The missing force of one channel.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Nats by which a force over the variable that shows it best beats none.
    pub significance: f64,
    /// Root mean square of the force along the recordings.
    pub rms: f64,
    /// The force over the variable that shows it best, then what it depends on beside.
    pub curves: Vec<Learned>,
}

/// The missing force of every channel.
#[derive(Clone, Debug)]
pub struct MissingForce {
    channels: Vec<Option<Channel>>,
}

impl MissingForce {
    /// The missing force of every channel of a problem's recordings.
    #[must_use]
    pub fn of(problem: &Problem, belief: &Belief) -> Self {
        let channels = 0..problem.model.channels();
        let wanted: Vec<(usize, Option<Over>)> = channels.map(|c| (c, None)).collect();
        Self { channels: learn(problem, belief, &wanted) }
    }

    /// That of one channel; none where nothing tells it.
    #[must_use]
    pub fn channel(&self, channel: usize) -> Option<&Channel> {
        self.channels[channel].as_ref()
    }

    /// The missing force of one channel over this variable.
    #[must_use]
    pub fn over(problem: &Problem, belief: &Belief, channel: usize, over: Over) -> Option<Learned> {
        let found = learn(problem, belief, &[(channel, Some(over))]).pop()??;
        found.curves.into_iter().next()
    }
}

/// What is learned of a channel before it is drawn.
struct Study<'a> {
    evidence: Evidence<'a>,
    chosen: Chosen,
}

fn learn(
    problem: &Problem,
    belief: &Belief,
    wanted: &[(usize, Option<Over>)],
) -> Vec<Option<Channel>> {
    let tolerances: Vec<f64> =
        belief.uncertain.iter().map(|&k| problem.model.parameters[k].std()).collect();
    let variables: Vec<Vec<Knots>> =
        wanted.iter().map(|&(c, over)| variables(problem, c, over)).collect();
    let mut values = belief.parameters.clone();
    let mut slopes: Vec<Option<Slopes>> = wanted.iter().map(|_| None).collect();
    const PASSES: usize = 2;
    for pass in 0..PASSES {
        let here = Belief { parameters: values.clone(), ..belief.clone() };
        let mut all: Vec<Along> = (0..problem.smoothed.len())
            .into_par_iter()
            .map(|r| Along::new(problem, &here, r))
            .collect();
        for (&(c, _), slopes) in wanted.iter().zip(&slopes) {
            for along in all.iter_mut() {
                slopes.iter().for_each(|s| s.take(c, along));
            }
        }
        let off: Vec<f64> =
            belief.uncertain.iter().map(|&k| belief.parameters[k] - values[k]).collect();
        let rows: Vec<Vec<(usize, Rows)>> =
            wanted.par_iter().map(|&(c, _)| rows_of(problem, belief, &all, c, &off)).collect();
        let mut studies: Vec<Option<Study>> = wanted
            .par_iter()
            .zip(&rows)
            .zip(&variables)
            .map(|((&(c, _), rows), variables)| {
                if rows.is_empty() || variables.is_empty() {
                    return None;
                }
                let scale = scale(&all, c);
                let evidence = Evidence::new(rows, variables, &tolerances, scale);
                // The curves at the end are means over all that may be.
                if pass + 1 == PASSES {
                    evidence.prepare();
                }
                let chosen = choose(&evidence, belief.prior_odds)?;
                Some(Study { evidence, chosen })
            })
            .collect();
        share_parameters(&mut studies, tolerances.len());
        if pass + 1 == PASSES {
            return studies.par_iter().map(|s| curve::channel(s.as_ref()?)).collect();
        }
        if let Some(mean) = parameters(&studies, tolerances.len()) {
            for (&k, mean) in belief.uncertain.iter().zip(mean) {
                values[k] = belief.parameters[k] + mean;
            }
        }
        slopes = wanted
            .iter()
            .zip(&studies)
            .map(|(&(c, _), s)| Slopes::of(problem, c, s.as_ref()?))
            .collect();
    }
    vec![]
}

/// Rows of a channel in all recordings; none where its equation holds what nothing measures.
fn rows_of(
    problem: &Problem,
    belief: &Belief,
    all: &[Along],
    channel: usize,
    off: &[f64],
) -> Vec<(usize, Rows)> {
    if !is_told(problem, belief, all, channel) {
        return vec![];
    }
    let intervals = window_intervals(problem, all, channel);
    let samples = all.iter().map(|a| a.motion.len()).sum();
    let mut rows: Vec<(usize, Rows)> = all
        .iter()
        .enumerate()
        .filter_map(|(r, a)| {
            Some((r, Rows::new(problem, a, channel, (intervals, samples), off.len())?))
        })
        .collect();
    for (_, rows) in &mut rows {
        for (right, by) in rows.right.iter_mut().zip(rows.by_parameter.chunks(off.len().max(1))) {
            *right += by.iter().zip(off).map(|(a, b)| a * b).sum::<f64>();
        }
    }
    rows
}

/// Whether all that a channel's equation holds is measured by sensors that are believed.
fn is_told(problem: &Problem, belief: &Belief, all: &[Along], channel: usize) -> bool {
    let n = problem.model.coordinates.len();
    let mut unknown = problem.hidden().to_vec();
    for effect in belief.effects.iter().filter(|e| matches!(e.effect.law, Law::Sensor(_))) {
        unknown.push(effect.channel);
        unknown.extend((effect.channel < n).then_some(effect.channel + n));
    }
    if problem.model.is_imposed(channel) && all.iter().any(|a| a.measured(channel).is_none()) {
        return false;
    }
    let own = problem.model.coordinate_index(channel);
    let holds = |&i: &usize| {
        let at = |a: &Along| (0..a.motion.len()).any(|k| a.by_state(k, channel, i) != 0.0);
        i == own || all.iter().any(at)
    };
    !unknown.iter().any(holds)
}

fn variables(problem: &Problem, channel: usize, over: Option<Over>) -> Vec<Knots> {
    let mut overs = match problem.model.is_coordinate(channel) {
        true => vec![Over::Coordinate, Over::Velocity, Over::Time],
        false => vec![Over::Coordinate, Over::Time],
    };
    if let Some(over) = over {
        overs.retain(|o| *o == over);
    }
    overs.into_iter().filter_map(|o| Knots::new(&problem.smoothed, channel, o)).collect()
}

/// Root mean square of the force that moves a channel.
fn scale(all: &[Along], channel: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for a in all {
        for k in 0..a.motion.len() {
            let force = a.inertia(k, channel);
            if force.is_finite() {
                sum += force * force;
                count += 1.0;
            }
        }
    }
    f64::max((sum / f64::max(count, 1.0)).sqrt(), f64::MIN_POSITIVE)
}

/// Tell every channel what the others say of the parameters.
fn share_parameters(studies: &mut [Option<Study>], parameters: usize) {
    if parameters == 0 {
        return;
    }
    let says: Vec<Option<(Mat<f64>, Vec<f64>)>> =
        studies.par_iter().map(|s| s.as_ref()?.says(parameters)).collect();
    for (c, study) in studies.iter_mut().enumerate() {
        let Some(study) = study else { continue };
        let mut precision = Mat::zeros(parameters, parameters);
        let mut moment = vec![0.0; parameters];
        for (own, other) in says.iter().enumerate() {
            if let Some((p, m)) = other.as_ref().filter(|_| own != c) {
                precision += p;
                moment.iter_mut().zip(m).for_each(|(sum, m)| *sum += m);
            }
        }
        study.evidence.told(Some((precision, moment)));
    }
}

/// Mean of the parameters, as off from what is believed; all channels agree.
fn parameters(studies: &[Option<Study>], parameters: usize) -> Option<Vec<f64>> {
    let study = studies.iter().flatten().next()?;
    let (posterior, _) = study.evidence.posterior(&study.chosen.supposed)?;
    Some(posterior.coefficients[..parameters].to_vec())
}

impl Study<'_> {
    /// What this channel says of the parameters: precision and its product with the mean.
    fn says(&self, parameters: usize) -> Option<(Mat<f64>, Vec<f64>)> {
        let (posterior, _) = self.evidence.posterior(&self.chosen.supposed)?;
        let tolerances = self.evidence.tolerances;
        let inverse = posterior.factor.inverse();
        let block = nalgebra::DMatrix::from_fn(parameters, parameters, |i, j| inverse[(i, j)]);
        // In units of the tolerances: what was believed before has precision 1.
        let all = block.try_inverse()?;
        let mean = nalgebra::DVector::from_fn(parameters, |i, _| {
            posterior.coefficients[i] / tolerances[i]
        });
        let moment = &all * mean;
        let own = |i: usize, j: usize| all[(i, j)] - if i == j { 1.0 } else { 0.0 };
        let precision =
            Mat::from_fn(parameters, parameters, |i, j| own(i, j) / tolerances[i] / tolerances[j]);
        Some((precision, (0..parameters).map(|i| moment[i] / tolerances[i]).collect()))
    }
}

/// Slopes of a learned force, by what it depends on.
struct Slopes {
    parts: Vec<(usize, Vec<Vec<f64>>)>,
}

impl Slopes {
    fn of(problem: &Problem, channel: usize, study: &Study) -> Option<Self> {
        let curves = curve::parts(study)?;
        let mut parts = Vec::new();
        for (knots, values) in curves {
            let state = match knots.over {
                Over::Coordinate => problem.model.coordinate_index(channel),
                Over::Velocity => problem.model.velocity_index(channel),
                Over::Time => continue,
            };
            let d = knots.spacing();
            let slope = |x: &f64| (knots.at(&values, x + d) - knots.at(&values, x - d)) / (2.0 * d);
            parts.push((
                state,
                knots.series.iter().map(|s| s.iter().map(slope).collect()).collect(),
            ));
        }
        Some(Self { parts })
    }

    fn take(&self, channel: usize, along: &mut Along) {
        for (state, series) in &self.parts {
            let slopes = &series[along.recording];
            along.add_slope(channel, *state, |k| slopes[k]);
        }
    }
}
