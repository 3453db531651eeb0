//! Solving for accelerations.

use lacuna_numbers::Number;

/// Make the rows of coordinates whose accelerations are given say just that, and move their
/// inertia to the other rows: `force_f <- force_f - M_fc a_c`.
#[inline(always)]
pub(super) fn impose<T: Number>(
    imposed: &[usize],
    acceleration: impl Fn(usize) -> T,
    mass: &mut [T],
    force: &mut [T],
) {
    let n = force.len();
    for (k, &c) in imposed.iter().enumerate() {
        let a = acceleration(k);
        for (f, force) in force.iter_mut().enumerate() {
            *force = *force - mass[f * n + c] * a;
            mass[f * n + c] = T::constant(0.0);
            mass[c * n + f] = T::constant(0.0);
        }
        mass[c * n + c] = T::constant(1.0);
        force[c] = a;
    }
}

/// `force <- mass^-1 force`; not finite where the mass matrix is singular. Both are
/// overwritten. Gaussian elimination with pivoting; one and two coordinates, the usual
/// sizes in a hot loop, by formula.
#[inline(always)]
pub(super) fn solve_mass<T: Number>(mass: &mut [T], force: &mut [T]) {
    match force {
        [] => {}
        [f] => *f = *f / mass[0],
        [f, g] => {
            let (a, b, c, d) = (mass[0], mass[1], mass[2], mass[3]);
            let determinant = a * d - b * c;
            (*f, *g) = ((d * *f - b * *g) / determinant, (a * *g - c * *f) / determinant);
        }
        _ => eliminate(mass, force),
    }
}

fn eliminate<T: Number>(mass: &mut [T], force: &mut [T]) {
    let n = force.len();
    for k in 0..n {
        let size = |i: &usize| mass[i * n + k].value().abs();
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(k);
        if pivot != k {
            for j in 0..n {
                mass.swap(k * n + j, pivot * n + j);
            }
            force.swap(k, pivot);
        }
        for i in k + 1..n {
            let share = mass[i * n + k] / mass[k * n + k];
            for j in k..n {
                mass[i * n + j] = mass[i * n + j] - share * mass[k * n + j];
            }
            force[i] = force[i] - share * force[k];
        }
    }
    for k in (0..n).rev() {
        let mut rest = force[k];
        for j in k + 1..n {
            rest = rest - mass[k * n + j] * force[j];
        }
        force[k] = rest / mass[k * n + k];
    }
}

/// Factors `L D L^T` of a symmetric matrix (row-major, `n x n`) in its place: D on the diagonal, L below it.
/// Of a mass matrix that is not positive definite they exist as well, save where a pivot is 0: what
/// is solved is not finite then.
#[inline(always)]
pub(super) fn factor(mass: &mut [f64], n: usize) {
    for j in 0..n {
        for i in j..n {
            let shares = (0..j).map(|k| mass[i * n + k] * mass[j * n + k] * mass[k * n + k]);
            let rest = mass[i * n + j] - shares.sum::<f64>();
            mass[i * n + j] = if i == j { rest } else { rest / mass[j * n + j] };
        }
    }
}

/// `x <- mass^-1 x`, given the factors.
#[inline(always)]
pub(super) fn solve_factored<T: Number>(factors: &[f64], x: &mut [T]) {
    let n = x.len();
    for i in 0..n {
        for k in 0..i {
            x[i] = x[i] - x[k] * factors[i * n + k];
        }
    }
    for i in (0..n).rev() {
        x[i] = x[i] / factors[i * n + i];
        for k in i + 1..n {
            x[i] = x[i] - x[k] * factors[k * n + i];
        }
    }
}
