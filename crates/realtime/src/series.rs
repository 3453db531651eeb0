//! Truncated Chebyshev series in several arguments.

use crate::error::{TableError, check_count, check_finite, check_indices, check_length};
use crate::lanes::{Dispatch, Lanes, OnLanes};
use crate::{Eight, LANES, MOST_ENTRIES, Table};

/// Most values T_k(z_i), k >= 1, of all arguments together.
pub const MOST_FACTORS: usize = 256;

/// Most products in a table.
pub const MOST_PRODUCTS: usize = 2048;

/// Products of Chebyshev polynomials, each from an earlier one and one more polynomial:
///
/// ```text
/// P_0 = 1,   P_k = P_(parents[k]) t_(factors[k]),   parents[k] < k
/// ```
///
/// where t holds T_1(z_i), ..., T_Di(z_i) of the first argument, then of the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Products<'a> {
    /// Earlier products; entry 0 counts for nothing.
    pub parents: Table<'a, u16>,
    /// Polynomials, counted through all arguments.
    pub factors: Table<'a, u16>,
}

impl Products<'_> {
    fn check(&self, what: &'static str, factors: usize) -> Result<(), TableError> {
        check_count(what, MOST_PRODUCTS, self.parents.len())?;
        check_length(what, self.parents.len(), self.factors.len())?;
        let earlier = self.parents.iter().enumerate().skip(1);
        for (k, &parent) in earlier {
            check_indices(what, k, [parent])?;
        }
        check_indices(what, factors.max(1), self.factors.iter().copied())
    }

    /// Indices are within the tables; masked, they need no check, and the compiler knows that there is no panic.
    #[inline(always)]
    fn fill<const SIZE: usize>(&self, factors: &[f64; MOST_FACTORS], products: &mut [f64; SIZE]) {
        let entries = self.parents.iter().zip(self.factors.iter()).enumerate().skip(1);
        for (k, (&parent, &factor)) in entries {
            let parent = products[usize::from(parent) & (SIZE - 1)];
            let factor = factors[usize::from(factor) & (MOST_FACTORS - 1)];
            products[k & (SIZE - 1)] = parent * factor;
        }
    }
}

/// Coefficients of functions that share their products.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<'a> {
    /// The functions, at most [`MOST_ENTRIES`]: i for f_i, n + i m + j for g_ij (i and j from 0).
    pub entries: Table<'a, u16>,
    /// An outer product, and the first of eight inner ones divided by eight, for each block.
    pub blocks: Table<'a, [u16; 2]>,
    /// Blocks x entries.
    pub coefficients: Table<'a, Eight>,
}

/// Chebyshev series of several functions.
#[derive(Debug, Clone, PartialEq)]
pub struct Series<'a> {
    /// Highest degree D_i in each argument.
    pub degrees: Table<'a, u16>,
    /// Products of the first arguments.
    pub outer: Products<'a>,
    /// Products of the others, a multiple of eight (what fills them up has coefficients of zero).
    pub inner: Products<'a>,
    /// The coefficients.
    pub groups: Table<'a, Group<'a>>,
}

impl Series<'_> {
    pub(crate) fn check(&self, arguments: usize, functions: usize) -> Result<(), TableError> {
        check_length("degrees", arguments, self.degrees.len())?;
        let factors: usize = self.degrees.iter().map(|&d| usize::from(d)).sum();
        check_count("degrees of all arguments", MOST_FACTORS, factors.max(1))?;
        self.outer.check("outer products", factors)?;
        self.inner.check("inner products", factors)?;
        let inner = self.inner.parents.len();
        check_length("inner products", inner.next_multiple_of(LANES), inner)?;
        for group in self.groups.iter() {
            check_count("functions of a group", MOST_ENTRIES, group.entries.len())?;
            check_indices("functions of a group", functions, group.entries.iter().copied())?;
            let (outer, inner) = (self.outer.parents.len(), inner / LANES);
            check_indices("blocks", outer, group.blocks.iter().map(|b| b[0]))?;
            check_indices("blocks", inner, group.blocks.iter().map(|b| b[1]))?;
            let expected = group.blocks.len() * group.entries.len();
            check_length("coefficients", expected, group.coefficients.len())?;
            check_finite("coefficients", group.coefficients.iter().flat_map(|eight| &eight.0))?;
        }
        Ok(())
    }

    /// Adds the series at z to the functions.
    #[inline(always)]
    pub(crate) fn add(
        &self,
        lanes: impl Dispatch,
        z: impl Iterator<Item = f64>,
        add: impl FnMut(u16, f64),
    ) {
        // Room on the stack is filled each time, so that it must not be larger than need be.
        match self.outer.parents.len().max(self.inner.parents.len()) {
            0..=128 => lanes.dispatch(AddSeries::<_, _, 128> { series: self, z, add }),
            129..=512 => lanes.dispatch(AddSeries::<_, _, 512> { series: self, z, add }),
            _ => lanes.dispatch(AddSeries::<_, _, MOST_PRODUCTS> { series: self, z, add }),
        }
    }

    /// T_1(z), ..., T_D(z) for each argument: T_2k = 2 T_k^2 - 1 and T_2k+1 = 2 T_k T_k+1 - z, so that the longest chain
    /// of operations is the logarithm of D.
    #[inline(always)]
    fn fill_factors(&self, z: impl Iterator<Item = f64>, factors: &mut [f64]) {
        let mut rest = factors;
        for (&degree, z) in self.degrees.iter().zip(z) {
            let Some((own, others)) = rest.split_at_mut_checked(usize::from(degree)) else {
                return;
            };
            for k in 1..=own.len() {
                let half = own.get((k / 2).wrapping_sub(1)).copied().unwrap_or(1.0);
                let other = own.get(k.div_ceil(2).wrapping_sub(1)).copied().unwrap_or(1.0);
                let odd = if k % 2 == 0 { 1.0 } else { z };
                if let Some(value) = own.get_mut(k - 1) {
                    *value = if k == 1 { z } else { 2.0 * half * other - odd };
                }
            }
            rest = others;
        }
    }
}

/// A series at z, with room for `SIZE` products (a power of two) in each table.
struct AddSeries<'s, 'a, Z, F, const SIZE: usize> {
    series: &'s Series<'a>,
    z: Z,
    add: F,
}

impl<Z, F, const SIZE: usize> OnLanes for AddSeries<'_, '_, Z, F, SIZE>
where
    Z: Iterator<Item = f64>,
    F: FnMut(u16, f64),
{
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        const { assert!(SIZE.is_power_of_two() && MOST_FACTORS.is_power_of_two()) };
        let Self { series, z, mut add } = self;
        let mut factors = [0.0; MOST_FACTORS];
        series.fill_factors(z, &mut factors);
        let (mut outer, mut inner) = ([1.0; SIZE], Aligned([1.0; SIZE]));
        series.outer.fill(&factors, &mut outer);
        series.inner.fill(&factors, &mut inner.0);
        for group in series.groups.iter() {
            match group.entries.len() {
                1 => add_group::<L, 1, SIZE>(lanes, group, &outer, &inner.0, &mut add),
                2 => add_group::<L, 2, SIZE>(lanes, group, &outer, &inner.0, &mut add),
                3 => add_group::<L, 3, SIZE>(lanes, group, &outer, &inner.0, &mut add),
                4 => add_group::<L, 4, SIZE>(lanes, group, &outer, &inner.0, &mut add),
                5 => add_group::<L, 5, SIZE>(lanes, group, &outer, &inner.0, &mut add),
                _ => add_group::<L, MOST_ENTRIES, SIZE>(lanes, group, &outer, &inner.0, &mut add),
            }
        }
    }
}

/// As [`Eight`], so that no load needs two lines of the cache.
#[repr(C, align(64))]
struct Aligned<const SIZE: usize>([f64; SIZE]);

/// A group of E functions, at most [`MOST_ENTRIES`].
#[inline(always)]
fn add_group<L: Lanes, const E: usize, const SIZE: usize>(
    lanes: L,
    group: &Group<'_>,
    outer: &[f64; SIZE],
    inner: &[f64; SIZE],
    add: &mut impl FnMut(u16, f64),
) {
    let inner = inner.as_chunks::<LANES>().0;
    let coefficients = group.coefficients.as_chunks::<E>().0;
    let mut sums = [lanes.splat(0.0); E];
    for (&[i, j], coefficients) in group.blocks.iter().zip(coefficients) {
        let outer = outer[usize::from(i) & (SIZE - 1)];
        let Some(inner) = inner.get(usize::from(j)) else { return };
        let products = lanes.mul(lanes.splat(outer), lanes.load(inner));
        for (sum, coefficients) in sums.iter_mut().zip(coefficients) {
            *sum = lanes.mul_add(products, lanes.load(&coefficients.0), *sum);
        }
    }
    for (&entry, sum) in group.entries.iter().zip(sums) {
        add(entry, lanes.sum(sum));
    }
}
