//! Sums of kernels over landmarks.

use crate::error::{TableError, check_count, check_finite, check_indices, check_length};
use crate::lanes::{Dispatch, Lanes, OnLanes};
use crate::{Eight, Table};

/// Most arguments of a model.
pub const MOST_ARGUMENTS: usize = 64;

/// Most functions in a sum over landmarks.
pub const MOST_SUMS: usize = 32;

/// The kernel as a function psi of one number s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Profile {
    /// exp(s), s = y . p
    Exponential,
    /// (s + offset)^degree, s = y . p
    Power {
        /// The offset.
        offset: f64,
        /// The degree.
        degree: u32,
    },
    /// exp(-s / 2), s = |y - p|^2
    Gaussian,
    /// exp(-r), r^2 = |y - p|^2
    MaternHalf,
    /// (1 + r) exp(-r), r^2 = 3 |y - p|^2
    MaternThreeHalves,
    /// (1 + r + r^2 / 3) exp(-r), r^2 = 5 |y - p|^2
    MaternFiveHalves,
}

impl Profile {
    /// Whether s is the squared distance, and not the product.
    pub fn is_radial(self) -> bool {
        !matches!(self, Self::Exponential | Self::Power { .. })
    }
}

/// sum_p w_ep psi(s_p(x)) for the functions e.
#[derive(Debug, Clone, PartialEq)]
pub struct LandmarkSum<'a> {
    /// psi.
    pub profile: Profile,
    /// Centre a of the arguments, d numbers.
    pub centre: Table<'a, f64>,
    /// Factors b of the arguments, d numbers.
    pub factors: Table<'a, f64>,
    /// The functions, at most [`MOST_SUMS`], as in [`crate::Group::entries`].
    pub entries: Table<'a, u16>,
    /// Tiles of eight landmarks: their coordinates, d eights, then their weights, an eight a function (zero for
    /// what fills up).
    pub tiles: Table<'a, Eight>,
}

impl LandmarkSum<'_> {
    pub(crate) fn check(&self, arguments: usize, functions: usize) -> Result<(), TableError> {
        check_length("centre", arguments, self.centre.len())?;
        check_length("factors of arguments", arguments, self.factors.len())?;
        check_count("functions of a sum", MOST_SUMS, self.entries.len())?;
        check_indices("functions of a sum", functions, self.entries.iter().copied())?;
        let tile = arguments + self.entries.len();
        check_length("tiles", self.tiles.len().next_multiple_of(tile), self.tiles.len())?;
        check_finite("centre", self.centre.iter())?;
        check_finite("factors of arguments", self.factors.iter())?;
        check_finite("tiles", self.tiles.iter().flat_map(|eight| &eight.0))
    }

    /// Adds the sum at x to the functions.
    #[inline(always)]
    pub(crate) fn add(
        &self,
        lanes: impl Dispatch,
        x: impl Iterator<Item = f64>,
        add: impl FnMut(u16, f64),
    ) {
        let mut room = [0.0; MOST_ARGUMENTS];
        let entries = x.zip(self.centre.iter()).zip(self.factors.iter()).zip(&mut room);
        entries.for_each(|(((x, centre), factor), y)| *y = (x - centre) * factor);
        let y = room.get(..self.centre.len()).unwrap_or(&[]);
        lanes.dispatch(AddSum { sum: self, y, add });
    }
}

struct AddSum<'s, 'a, F> {
    sum: &'s LandmarkSum<'a>,
    y: &'s [f64],
    add: F,
}

impl<F: FnMut(u16, f64)> OnLanes for AddSum<'_, '_, F> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let one = lanes.splat(1.0);
        match self.sum.profile {
            Profile::Exponential => self.add(lanes, |s| lanes.exp(s)),
            Profile::Power { offset, degree } => {
                self.add(lanes, |s| power(lanes, lanes.add(s, lanes.splat(offset)), degree));
            }
            Profile::Gaussian => self.add(lanes, |s| lanes.exp(lanes.mul(s, lanes.splat(-0.5)))),
            Profile::MaternHalf => self.add(lanes, |s| matern(lanes, s, 1.0, |_| one)),
            Profile::MaternThreeHalves => {
                self.add(lanes, |s| matern(lanes, s, 3.0, |r| lanes.add(r, one)));
            }
            Profile::MaternFiveHalves => self.add(lanes, |s| {
                let third = lanes.splat(1.0 / 3.0);
                matern(lanes, s, 5.0, |r| lanes.mul_add(lanes.mul_add(r, third, one), r, one))
            }),
        }
    }
}

impl<F: FnMut(u16, f64)> AddSum<'_, '_, F> {
    #[inline(always)]
    fn add<L: Lanes>(mut self, lanes: L, profile: impl Fn(L::V) -> L::V) {
        let radial = self.sum.profile.is_radial();
        let mut sums = [lanes.splat(0.0); MOST_SUMS];
        for tile in self.sum.tiles.chunks_exact(self.y.len() + self.sum.entries.len()) {
            let mut s = lanes.splat(0.0);
            for (&y, coordinate) in self.y.iter().zip(tile) {
                let (y, p) = (lanes.splat(y), lanes.load(&coordinate.0));
                let difference = lanes.sub(y, p);
                let (a, b) = if radial { (difference, difference) } else { (y, p) };
                s = lanes.mul_add(a, b, s);
            }
            let value = profile(s);
            for (sum, weights) in sums.iter_mut().zip(tile.iter().skip(self.y.len())) {
                *sum = lanes.mul_add(value, lanes.load(&weights.0), *sum);
            }
        }
        for (&entry, sum) in self.sum.entries.iter().zip(sums) {
            (self.add)(entry, lanes.sum(sum));
        }
    }
}

/// polynomial(r) exp(-r) with r^2 = scale squared
#[inline(always)]
fn matern<L: Lanes>(
    lanes: L,
    squared: L::V,
    scale: f64,
    polynomial: impl Fn(L::V) -> L::V,
) -> L::V {
    let r = lanes.sqrt(lanes.mul(squared, lanes.splat(scale)));
    lanes.mul(polynomial(r), lanes.exp(lanes.mul(r, lanes.splat(-1.0))))
}

/// Repeated squaring.
#[inline(always)]
fn power<L: Lanes>(lanes: L, base: L::V, mut degree: u32) -> L::V {
    let (mut power, mut square) = (lanes.splat(1.0), base);
    while degree > 0 {
        if degree & 1 == 1 {
            power = lanes.mul(power, square);
        }
        square = lanes.mul(square, square);
        degree >>= 1;
    }
    power
}
