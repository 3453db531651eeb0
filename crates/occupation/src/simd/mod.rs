//! Kernel sums over many points at once, vectorised.
//!
//! ```text
//! K(x, y) = profile(|xi - eta|^2)  or  profile(xi . eta),   xi = x / w,  eta = y / w
//! ```
//!
//! Every sum is written once, for any width of vectors; `pulp` compiles it for AVX-512, for AVX2 with fused
//! multiply-add, and plainly, and chooses at run time. All take the same additions in the same order, so that kernel
//! values differ by the rounding of fused multiply-adds alone (2 units in the last place of the exponential).
//!
//! | what | module |
//! | --- | --- |
//! | e^x | `exp` |
//! | profiles of the kernels | `profile` |
//! | K(x, p_k) for many k | `row` |
//! | many occupation kernels at one point | `occupation` |

mod exp;
mod occupation;
mod profile;
mod row;

pub(crate) use occupation::{
    LANES, Looks, MOST_ARGUMENTS, MOST_ENTRIES, MOST_ROWS, OccupationSums,
};
pub use profile::{Form, Profile};
pub(crate) use row::{kernel_row, slope_row};

use std::sync::OnceLock;

use pulp::{Arch, Simd, WithSimd};

/// The widest vectors of this processor, or narrower ones where the environment variable LACUNA_VECTORS says `plain` or
/// `avx2`. It is for kernel sums alone: the library of linear algebra chooses by itself.
pub(crate) fn widest() -> Arch {
    static CHOSEN: OnceLock<Arch> = OnceLock::new();
    *CHOSEN.get_or_init(|| match std::env::var("LACUNA_VECTORS").as_deref() {
        Ok("plain") => Arch::Scalar,
        #[cfg(target_arch = "x86_64")]
        Ok("avx2") => pulp::x86::V3::try_new().map_or(Arch::Scalar, Arch::V3),
        _ => Arch::new(),
    })
}

/// Every set of instructions of this processor, the plainest first.
#[cfg(test)]
pub(crate) fn every() -> Vec<Arch> {
    let mut all = vec![Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    {
        all.extend(pulp::x86::V3::try_new().map(Arch::V3));
        all.extend(pulp::x86::V4::try_new().map(Arch::V4));
    }
    all
}

/// Something that is computed with one profile.
pub(crate) trait WithProfile {
    type Output;

    fn with_profile<P: profile::Shape, const RADIAL: bool>(self, shape: P) -> Self::Output;
}

/// Points are stored coordinate by coordinate: `points[i * count + k]` is coordinate i of point k of `count`.
pub(crate) fn coordinate_by_coordinate(rows: &[f64], dimension: usize, columns: &mut Vec<f64>) {
    columns.clear();
    for i in 0..dimension {
        columns.extend(rows.iter().skip(i).step_by(dimension));
    }
}

/// Adds factor times `values` to `to`, in a loop that is compiled with its caller.
#[inline(always)]
pub(crate) fn add_scaled(to: &mut [f64], factor: f64, values: &[f64]) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to += factor * value);
}

/// sum_k x_k y_k, in a fixed order.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    widest().dispatch(Dot { x, y })
}

struct Dot<'a> {
    x: &'a [f64],
    y: &'a [f64],
}

impl WithSimd for Dot<'_> {
    type Output = f64;

    /// Always eight partial sums, whatever the width of the vectors.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut lanes = [0.0; LANES];
        let (x_blocks, x_rest) = self.x.as_chunks::<LANES>();
        let (y_blocks, y_rest) = self.y.as_chunks::<LANES>();
        for (a, b) in x_blocks.iter().zip(y_blocks) {
            for i in 0..LANES {
                lanes[i] += a[i] * b[i];
            }
        }
        let rest: f64 = x_rest.iter().zip(y_rest).map(|(a, b)| a * b).sum();
        lanes.iter().sum::<f64>() + rest
    }
}
