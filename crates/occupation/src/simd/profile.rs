//! Profiles: what a kernel makes of a squared distance or an inner product.

pub use lacuna_realtime::Profile;
use pulp::Simd;

use super::WithProfile;
use super::exp::{decay, exponential};

/// A kernel of this crate by its parts: K(x, y) = profile(|xi - eta|^2) or profile(xi . eta), xi_i = scale_i x_i.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// Which profile.
    pub profile: Profile,
    /// Factor of each argument.
    pub scales: Vec<f64>,
}

/// Calls `with` with the profile as a type, so that loops are compiled for it.
#[inline(always)]
pub(super) fn dispatch<W: WithProfile>(profile: Profile, with: W) -> W::Output {
    match profile {
        Profile::Gaussian => with.with_profile::<_, true>(Gaussian),
        Profile::MaternHalf => with.with_profile::<_, true>(MaternHalf),
        Profile::MaternThreeHalves => with.with_profile::<_, true>(MaternThreeHalves),
        Profile::MaternFiveHalves => with.with_profile::<_, true>(MaternFiveHalves),
        Profile::Exponential => with.with_profile::<_, false>(Exponential),
        Profile::Power { degree, offset } => {
            with.with_profile::<_, false>(Polynomial { degree, offset })
        }
    }
}

/// A profile as a type.
pub(crate) trait Shape: Copy {
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s;

    /// h with dK/dxi = h (xi - eta) for squared distances, dK/dxi = h eta for inner products.
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s;
}

/// The slope of a profile in its place.
#[derive(Clone, Copy)]
pub(super) struct SlopeOf<P>(pub P);

impl<P: Shape> Shape for SlopeOf<P> {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        self.0.slope(simd, s)
    }

    /// Second derivatives are not asked for.
    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, _: S::f64s) -> S::f64s {
        simd.splat_f64s(f64::NAN)
    }
}

#[derive(Clone, Copy)]
struct Gaussian;
#[derive(Clone, Copy)]
struct MaternHalf;
#[derive(Clone, Copy)]
struct MaternThreeHalves;
#[derive(Clone, Copy)]
struct MaternFiveHalves;
#[derive(Clone, Copy)]
struct Exponential;
#[derive(Clone, Copy)]
struct Polynomial {
    degree: u32,
    offset: f64,
}

impl Shape for Gaussian {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        decay(simd, simd.mul_f64s(s, simd.splat_f64s(-0.5)))
    }

    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        simd.neg_f64s(self.of(simd, s))
    }
}

impl Shape for MaternHalf {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        decay(simd, simd.neg_f64s(simd.sqrt_f64s(s)))
    }

    /// Infinite at the kernel's peak, which is a corner.
    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        simd.div_f64s(simd.neg_f64s(self.of(simd, s)), simd.sqrt_f64s(s))
    }
}

impl Shape for MaternThreeHalves {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let r = simd.sqrt_f64s(simd.mul_f64s(s, simd.splat_f64s(3.0)));
        let polynomial = simd.add_f64s(simd.splat_f64s(1.0), r);
        simd.mul_f64s(polynomial, decay(simd, simd.neg_f64s(r)))
    }

    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let r = simd.sqrt_f64s(simd.mul_f64s(s, simd.splat_f64s(3.0)));
        simd.mul_f64s(simd.splat_f64s(-3.0), decay(simd, simd.neg_f64s(r)))
    }
}

impl Shape for MaternFiveHalves {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let one = simd.splat_f64s(1.0);
        let r = simd.sqrt_f64s(simd.mul_f64s(s, simd.splat_f64s(5.0)));
        let third = simd.mul_add_e_f64s(r, simd.splat_f64s(1.0 / 3.0), one);
        let polynomial = simd.mul_add_e_f64s(r, third, one);
        simd.mul_f64s(polynomial, decay(simd, simd.neg_f64s(r)))
    }

    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let r = simd.sqrt_f64s(simd.mul_f64s(s, simd.splat_f64s(5.0)));
        let third = simd.splat_f64s(-5.0 / 3.0);
        simd.mul_f64s(simd.mul_add_e_f64s(r, third, third), decay(simd, simd.neg_f64s(r)))
    }
}

impl Shape for Exponential {
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        exponential(simd, s)
    }

    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        self.of(simd, s)
    }
}

impl Shape for Polynomial {
    /// Repeated squaring.
    #[inline(always)]
    fn of<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let mut square = simd.add_f64s(s, simd.splat_f64s(self.offset));
        let mut power = simd.splat_f64s(1.0);
        let mut degree = self.degree;
        while degree > 0 {
            if degree & 1 == 1 {
                power = simd.mul_f64s(power, square);
            }
            square = simd.mul_f64s(square, square);
            degree >>= 1;
        }
        power
    }

    #[inline(always)]
    fn slope<S: Simd>(self, simd: S, s: S::f64s) -> S::f64s {
        let factor = simd.splat_f64s(f64::from(self.degree));
        let below = Self { degree: self.degree.saturating_sub(1), ..self };
        simd.mul_f64s(factor, below.of(simd, s))
    }
}
