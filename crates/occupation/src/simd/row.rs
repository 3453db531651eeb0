//! Kernel values of one point with many.

use pulp::{Simd, WithSimd};

use super::profile::{Profile, Shape, SlopeOf, dispatch};
use super::{WithProfile, widest};

/// values\[k\] = profile(factor s_k) with s_k = sum_i ((x_i - p_ik) / w_i)^2 or sum_i x_i p_ik, for points stored
/// coordinate by coordinate. Widths are for squared distances alone; none are ones.
pub(crate) fn kernel_row(
    profile: Profile,
    (factor, widths): (f64, Option<&[f64]>),
    x: &[f64],
    points: &[f64],
    values: &mut [f64],
) {
    let row = Row { factor, x, points, values };
    match widths {
        Some(widths) => dispatch(profile, Scaled { row, widths }),
        None => dispatch(profile, row),
    }
}

/// slopes\[k\] = h(s_k) with dK/dx = h (x - p_k) for squared distances and h p_k for inner products, without widths.
pub(crate) fn slope_row(profile: Profile, x: &[f64], points: &[f64], slopes: &mut [f64]) {
    dispatch(profile, Slopes(Row { factor: 1.0, x, points, values: slopes }));
}

struct Row<'a> {
    factor: f64,
    x: &'a [f64],
    points: &'a [f64],
    values: &'a mut [f64],
}

struct Slopes<'a>(Row<'a>);

struct Scaled<'a> {
    row: Row<'a>,
    widths: &'a [f64],
}

impl WithProfile for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn with_profile<P: Shape, const RADIAL: bool>(self, shape: P) {
        widest().dispatch(RowOf::<P, RADIAL, false> { row: self, widths: &[], shape });
    }
}

impl WithProfile for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_profile<P: Shape, const RADIAL: bool>(self, shape: P) {
        self.0.with_profile::<_, RADIAL>(SlopeOf(shape));
    }
}

impl WithProfile for Scaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_profile<P: Shape, const RADIAL: bool>(self, shape: P) {
        let Self { row, widths } = self;
        widest().dispatch(RowOf::<P, RADIAL, true> { row, widths, shape });
    }
}

struct RowOf<'a, P, const RADIAL: bool, const SCALED: bool> {
    row: Row<'a>,
    widths: &'a [f64],
    shape: P,
}

/// Vectors in flight at once: enough to hide the latency of the exponential.
const UNROLLED: usize = 4;

impl<P: Shape, const RADIAL: bool, const SCALED: bool> WithSimd for RowOf<'_, P, RADIAL, SCALED> {
    type Output = ();

    // No closures: what is not inlined is not compiled for the processor.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { row: Row { factor, x, points, values }, widths, shape } = self;
        let count = values.len();
        let block = UNROLLED * S::F64_LANES;
        let whole = count - count % block;
        for first in (0..whole).step_by(block) {
            let mut sums = [simd.splat_f64s(0.0); UNROLLED];
            for (i, &own) in x.iter().enumerate() {
                let width = if SCALED { widths[i] } else { 1.0 };
                let others = &points[i * count + first..i * count + first + block];
                for (sum, &other) in sums.iter_mut().zip(S::as_simd_f64s(others).0) {
                    *sum = add::<S, RADIAL, SCALED>(simd, [own, width], other, *sum);
                }
            }
            let (to, _) = S::as_mut_simd_f64s(&mut values[first..first + block]);
            for (to, sum) in to.iter_mut().zip(sums) {
                *to = shape.of(simd, simd.mul_f64s(sum, simd.splat_f64s(factor)));
            }
        }
        for first in (whole..count).step_by(S::F64_LANES) {
            let end = count.min(first + S::F64_LANES);
            let mut sum = simd.splat_f64s(0.0);
            for (i, &own) in x.iter().enumerate() {
                let width = if SCALED { widths[i] } else { 1.0 };
                let other = simd.partial_load_f64s(&points[i * count + first..i * count + end]);
                sum = add::<S, RADIAL, SCALED>(simd, [own, width], other, sum);
            }
            let value = shape.of(simd, simd.mul_f64s(sum, simd.splat_f64s(factor)));
            simd.partial_store_f64s(&mut values[first..end], value);
        }
    }
}

/// As [`accumulate`], with differences over the width.
#[inline(always)]
fn add<S: Simd, const RADIAL: bool, const SCALED: bool>(
    simd: S,
    [own, width]: [f64; 2],
    other: S::f64s,
    sum: S::f64s,
) -> S::f64s {
    let own = simd.splat_f64s(own);
    if RADIAL && SCALED {
        let inverse = simd.splat_f64s(1.0 / width);
        let difference = simd.mul_f64s(simd.sub_f64s(own, other), inverse);
        simd.mul_add_e_f64s(difference, difference, sum)
    } else {
        accumulate::<S, RADIAL>(simd, own, other, sum)
    }
}

/// Adds (own - other)^2, or own times other.
#[inline(always)]
pub(super) fn accumulate<S: Simd, const RADIAL: bool>(
    simd: S,
    own: S::f64s,
    other: S::f64s,
    sum: S::f64s,
) -> S::f64s {
    if RADIAL {
        let difference = simd.sub_f64s(own, other);
        simd.mul_add_e_f64s(difference, difference, sum)
    } else {
        simd.mul_add_e_f64s(own, other, sum)
    }
}
