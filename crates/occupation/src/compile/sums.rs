//! The model's own sums over landmarks, for the functions that no series stands for.

use lacuna_realtime::{Eight, LANES, LandmarkSum, MOST_SUMS, Profile};

use super::{Domain, cost};
use crate::IdentifiedModel;
use crate::identified::SavedExpansion;
use crate::kernel::Form;

/// Functions that share sums: lists of functions, and what their sums cost.
pub(crate) fn components(model: &IdentifiedModel) -> Vec<(Vec<usize>, usize)> {
    let functions = model.dimension() * (1 + model.inputs());
    let mut component: Vec<usize> = (0..functions).collect();
    let expansions = model.expansions();
    for expansion in expansions.iter() {
        let members = functions_of(model, &expansion.saved);
        let Some(&least) = members.iter().min_by_key(|&&k| component[k]) else { continue };
        let joined: Vec<usize> = members.iter().map(|&k| component[k]).collect();
        let to = component[least];
        component.iter_mut().filter(|c| joined.contains(c)).for_each(|c| *c = to);
    }
    let members = |c: usize| (0..functions).filter(|&k| component[k] == c).collect::<Vec<_>>();
    let all = (0..functions).map(members).filter(|members| !members.is_empty());
    all.map(|members| {
        let cost = expansions.iter().map(|e| cost_of(model, &e.saved, &members)).sum();
        (members, cost)
    })
    .collect()
}

fn cost_of(model: &IdentifiedModel, saved: &SavedExpansion, functions: &[usize]) -> usize {
    let own = functions_of(model, saved).iter().filter(|k| functions.contains(k)).count();
    let d = model.arguments();
    let points = saved.points.len() / d;
    let profile = saved.kernel.parts(d).profile;
    if own == 0 { 0 } else { own.div_ceil(MOST_SUMS) * cost::landmarks(profile, points, d, own) }
}

/// Sums of some functions, without landmarks whose weights together are below `enough` of each, and what that leaves
/// out of each at most.
pub(crate) fn sums(
    model: &IdentifiedModel,
    domain: &Domain,
    functions: &[usize],
    enough: &[f64],
) -> (Vec<LandmarkSum<'static>>, Vec<f64>) {
    let mut left_out = vec![0.0; enough.len()];
    let mut sums = Vec::new();
    let expansions = model.expansions();
    for expansion in expansions.iter() {
        let saved = &expansion.saved;
        let all = functions_of(model, saved);
        let own: Vec<usize> = (0..all.len()).filter(|&e| functions.contains(&all[e])).collect();
        for some in own.chunks(MOST_SUMS) {
            // Each sum may leave out its share.
            let share = 1.0 / expansions.len() as f64;
            let enough: Vec<f64> = some.iter().map(|&e| share * enough[all[e]]).collect();
            let (kept, left) = kept(model.arguments(), saved, domain, some, &enough);
            some.iter().zip(left).for_each(|(&e, left)| left_out[all[e]] += left);
            let entries = some.iter().map(|&e| all[e] as u16).collect();
            sums.push(sum(model.arguments(), saved, some, entries, &kept));
        }
    }
    (sums, left_out)
}

/// f_i at i and g_ij at n + i m + j.
fn functions_of(model: &IdentifiedModel, saved: &SavedExpansion) -> Vec<usize> {
    let (n, m) = (model.dimension(), model.inputs());
    let at = |&(row, block): &(usize, usize)| match block {
        0 => row,
        j => n + row * m + j - 1,
    };
    saved.entries.iter().map(at).collect()
}

/// Landmarks that count, and the sum of what the others can contribute to each function.
fn kept(
    d: usize,
    saved: &SavedExpansion,
    domain: &Domain,
    entries: &[usize],
    enough: &[f64],
) -> (Vec<usize>, Vec<f64>) {
    let points = saved.points.len() / d;
    let form = saved.kernel.parts(d);
    let largest: Vec<f64> = (0..points).map(|k| largest(&form, saved, domain, k)).collect();
    let part = |e: usize, k: usize| saved.weights[entries[e] * points + k].abs() * largest[k];
    let share = |k: usize| {
        let parts = (0..entries.len()).map(|e| part(e, k) / enough[e].max(f64::MIN_POSITIVE));
        parts.fold(0.0, f64::max)
    };
    let mut order: Vec<usize> = (0..points).collect();
    let shares: Vec<f64> = (0..points).map(share).collect();
    order.sort_by(|&a, &b| shares[a].total_cmp(&shares[b]).then(a.cmp(&b)));
    let mut left = vec![0.0; entries.len()];
    let mut count = 0;
    for &k in &order {
        let with: Vec<f64> = left.iter().enumerate().map(|(e, l)| l + part(e, k)).collect();
        if with.iter().zip(enough).any(|(with, enough)| with > enough) {
            break;
        }
        (left, count) = (with, count + 1);
    }
    let mut kept = order.split_off(count);
    kept.sort_unstable();
    (kept, left)
}

/// The largest value of the kernel of landmark k on the box.
fn largest(form: &Form, saved: &SavedExpansion, domain: &Domain, k: usize) -> f64 {
    let d = form.scales.len();
    let point = &saved.points[k * d..(k + 1) * d];
    let at = |i: usize, x: f64| (x - centre(saved, i)) / width(saved, i) * form.scales[i];
    let ends = |i: usize| {
        let p = point[i] * form.scales[i];
        [at(i, domain.lower[i]) * p, at(i, domain.upper[i]) * p]
    };
    match form.profile {
        Profile::Exponential => (0..d).map(|i| ends(i)[0].max(ends(i)[1])).sum::<f64>().exp(),
        Profile::Power { offset, degree } => {
            let sum: f64 = (0..d).map(|i| ends(i)[0].abs().max(ends(i)[1].abs())).sum();
            (sum + offset).powf(f64::from(degree))
        }
        _ => 1.0,
    }
}

fn centre(saved: &SavedExpansion, i: usize) -> f64 {
    saved.centre.get(i).copied().unwrap_or(0.0)
}

fn width(saved: &SavedExpansion, i: usize) -> f64 {
    saved.widths.get(i).copied().unwrap_or(1.0)
}

fn sum(
    d: usize,
    saved: &SavedExpansion,
    entries: &[usize],
    functions: Vec<u16>,
    kept: &[usize],
) -> LandmarkSum<'static> {
    let points = saved.points.len() / d;
    let form = saved.kernel.parts(d);
    let mut tiles = Vec::new();
    for tile in kept.chunks(LANES) {
        let lanes = |value: &dyn Fn(usize) -> f64| {
            Eight(std::array::from_fn(|lane| tile.get(lane).map_or(0.0, |&k| value(k))))
        };
        for i in 0..d {
            tiles.push(lanes(&|k| saved.points[k * d + i] * form.scales[i]));
        }
        for &e in entries {
            tiles.push(lanes(&|k| saved.weights[e * points + k]));
        }
    }
    LandmarkSum {
        profile: form.profile,
        centre: (0..d).map(|i| centre(saved, i)).collect::<Vec<_>>().into(),
        factors: (0..d).map(|i| form.scales[i] / width(saved, i)).collect::<Vec<_>>().into(),
        entries: functions.into(),
        tiles: tiles.into(),
    }
}
