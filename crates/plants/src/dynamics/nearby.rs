//! Derivatives of what computes in plain numbers: differences whose error is measured.
//!
//! A derivative by a parameter or variable x is a central difference, extrapolated,
//!
//! ```text
//! D(h) = (F(x + h) - F(x - h)) / 2h,    dF/dx = (4 D(h/2) - D(h)) / 3
//! ```
//!
//! and its error is taken to be that of the better of the two differences, plus rounding:
//!
//! ```text
//! e = |D(h/2) - D(h)| / 3 + 8 eps max|F| / h
//! ```
//!
//! which bounds it where F is smooth over h, as the extrapolated value is better by another two
//! orders. h is a thousandth of the largest |x| met so far (of 1 while x has only been 0) and is
//! reduced where e is large beside `|dF/dx| + |F|/|x|` (C. Ridders, Adv. Eng. Softw. 4 (1982)
//! 75-76). That costs four evaluations where the first h will do, and two more: the difference ahead
//!
//! ```text
//! A = (F(x + d) - F(x)) / d
//! ```
//!
//! of a step d that hardly a law feels, to both sides, which is measured against it. Where it is as good as is asked for, it stands for the
//! derivative at the next points of a simulation, one evaluation each, until it is measured again. What all derivatives
//! at a point take is asked for together.

use std::ops::Range;

/// The first step as a share of the size of what is moved.
const STEP: f64 = 1e-3;
/// Each further step beside the one before it, and how many there are at most.
const SHRINK: f64 = 0.2;
const TRIES: usize = 5;
/// Share of error with which no smaller step is tried, and with which a difference ahead will do.
const GOOD: f64 = 1e-6;
/// The step of a difference ahead, as the first. Rounding costs 8 eps over it; what a law that turns within an x costs,
/// half of it, has the other sign at the next point.
const AHEAD: f64 = 1.0 / (1 << 24) as f64;
/// The step to the other side where a difference ahead is measured: the golden section of it, as what a solver leaves may
/// be alike at points that are as far away.
const SHORTER: f64 = 0.618;
/// Points for which a difference ahead is good once it was measured: a prime, so that it is not measured at the same
/// stage of every Runge-Kutta step.
const TRUSTED: f64 = 31.0;

/// What is differentiated.
pub(super) trait Evaluate {
    /// Values at points, a row each, and derivatives at the first of them that are known.
    fn evaluate(&self, points: &[f64], values: &mut [f64], along: Slopes<'_>);

    /// Whether derivatives by an entry of a point are known.
    fn is_known(&self, entry: usize) -> bool;
}

/// Entries and, a row each, derivatives by them.
pub(super) type Slopes<'a> = (&'a [usize], &'a mut [f64]);

/// Points around a point for one entry: a step above and below it, half a step, and one just ahead to both sides.
const AROUND: usize = 6;
/// Those ahead.
const SIDES: usize = 2;

/// How an entry is moved.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Moved {
    /// Ahead, which is good enough.
    Ahead,
    /// Around the point.
    Around,
    /// Around the point and ahead to both sides, to be compared.
    Both,
}

impl Moved {
    /// Which of its points it is moved to, in the order that [`AROUND`] tells of.
    fn points(self) -> Range<usize> {
        match self {
            Self::Ahead => AROUND - SIDES..AROUND - SIDES + 1,
            Self::Around => 0..AROUND - SIDES,
            Self::Both => 0..AROUND,
        }
    }
}

/// A point, points around it, and values and derivatives there. An entry is a number that a point is made of.
pub(super) struct Nearby<'a> {
    entries: usize,
    width: usize,
    /// Largest size of each entry met so far. This and the next three are kept from one point to the next.
    sizes: &'a mut [f64],
    /// Not 0 for an entry that derivatives were ever asked by.
    usual: &'a mut [f64],
    /// Points for which the difference ahead of each entry is still good, and its share of error as it was measured.
    trusted: &'a mut [f64],
    measured: &'a mut [f64],
    /// Step of each entry; 0 until derivatives by it are looked for at this point.
    steps: &'a mut [f64],
    /// Share of error of each entry's best derivative: infinite, with derivatives of 0, where
    /// values are not finite on both sides at any step.
    errors: &'a mut [f64],
    /// Those derivatives, a row an entry.
    slopes: &'a mut [f64],
    /// Differences ahead, one or to both sides.
    ahead: &'a mut [f64],
    /// The point, then at most [`AROUND`] points for each entry that is moved.
    points: &'a mut [f64],
    /// Values there.
    values: &'a mut [f64],
}

impl<'a> Nearby<'a> {
    /// Length of the room that it takes, of 0 at first, for points of so many entries and values.
    pub fn length(entries: usize, width: usize) -> usize {
        (6 + (1 + SIDES) * width) * entries + (1 + AROUND * entries) * (entries + width)
    }

    /// In such a room.
    pub fn of(mut room: &'a mut [f64], entries: usize, width: usize) -> Self {
        let mut take = |length: usize| {
            let (taken, rest) = std::mem::take(&mut room).split_at_mut(length);
            room = rest;
            taken
        };
        let rows = 1 + AROUND * entries;
        Self {
            entries,
            width,
            sizes: take(entries),
            usual: take(entries),
            trusted: take(entries),
            measured: take(entries),
            steps: take(entries),
            errors: take(entries),
            slopes: take(width * entries),
            ahead: take(SIDES * width * entries),
            points: take(rows * entries),
            values: take(rows * width),
        }
    }

    /// The values at the point.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.width]
    }

    /// The derivatives by an entry.
    pub fn slopes_by(&self, entry: usize) -> &[f64] {
        &self.slopes[entry * self.width..(entry + 1) * self.width]
    }

    /// Their share of error.
    pub fn error_by(&self, entry: usize) -> f64 {
        self.errors[entry]
    }

    /// Values at a point and derivatives by some entries.
    pub fn begin(
        &mut self,
        point: impl Iterator<Item = f64>,
        entries: impl Iterator<Item = usize>,
        of: &dyn Evaluate,
    ) {
        self.go(point);
        self.differentiate(entries.collect(), 0, of);
    }

    /// Values at a point and derivatives by all entries that these were asked by at any point before.
    pub fn begin_as_usual(&mut self, point: impl Iterator<Item = f64>, of: &dyn Evaluate) {
        self.go(point);
        let usual = (0..self.entries).filter(|&entry| self.usual[entry] != 0.0).collect();
        self.differentiate(usual, 0, of);
    }

    /// Derivatives by some entries at the point where it is, as far as it has not got them.
    pub fn also(&mut self, entries: impl Iterator<Item = usize>, of: &dyn Evaluate) {
        let new: Vec<usize> = entries.filter(|&entry| self.steps[entry] == 0.0).collect();
        if !new.is_empty() {
            self.differentiate(new, 1, of);
        }
    }

    /// Go to a point.
    fn go(&mut self, point: impl Iterator<Item = f64>) {
        self.slopes.fill(0.0);
        self.errors.fill(f64::INFINITY);
        self.steps.fill(0.0);
        self.points.iter_mut().zip(point).for_each(|(to, x)| *to = x);
    }

    /// Look for derivatives by entries; the rows of points before `begin` are evaluated already.
    fn differentiate(&mut self, asked: Vec<usize>, begin: usize, of: &dyn Evaluate) {
        for &entry in &asked {
            self.sizes[entry] = self.sizes[entry].max(self.points[entry].abs());
            self.steps[entry] = STEP * self.size(entry);
            self.usual[entry] = 1.0;
        }
        let (known, mut asked): (Vec<_>, Vec<_>) = asked.into_iter().partition(|&e| of.is_known(e));
        let first: Vec<_> = asked.iter().map(|&entry| (entry, self.first(entry))).collect();
        let rows = self.lay_out(&first);
        match known.is_empty() {
            true => self.evaluate(begin..rows, of),
            false => self.evaluate_along(rows, &known, of),
        }
        self.take(&first);
        for _ in 1..TRIES {
            asked.retain(|&entry| self.errors[entry] > GOOD);
            if asked.is_empty() {
                break;
            }
            let next: Vec<_> = asked.iter().map(|&entry| (entry, Moved::Around)).collect();
            let rows = self.lay_out(&next);
            self.evaluate(1..rows, of);
            self.take(&next);
        }
        first.iter().filter(|(_, moved)| *moved == Moved::Both).for_each(|m| self.judge(m.0));
    }

    /// The size that an entry's steps are shares of.
    fn size(&self, entry: usize) -> f64 {
        if self.sizes[entry] > 0.0 { self.sizes[entry] } else { 1.0 }
    }

    /// How an entry is moved first.
    fn first(&self, entry: usize) -> Moved {
        if self.trusted[entry] > 0.0 { Moved::Ahead } else { Moved::Both }
    }

    /// The side to which the difference ahead looks: the other one at each point, so that over the stages of a
    /// Runge-Kutta step, whose weights are 1, 2, 2, 1, most of what its step costs cancels.
    fn side(&self, entry: usize) -> f64 {
        if self.trusted[entry] % 2.0 == 0.0 { 1.0 } else { -1.0 }
    }

    /// Write the points around for the entries that are moved; how many rows there are then.
    fn lay_out(&mut self, moved: &[(usize, Moved)]) -> usize {
        let mut row = 1;
        for &(entry, how) in moved {
            let (h, ahead) = (self.steps[entry], self.side(entry) * AHEAD * self.size(entry));
            let steps = [h, -h, 0.5 * h, -0.5 * h, ahead, -SHORTER * ahead];
            for step in &steps[how.points()] {
                let to = row * self.entries;
                self.points.copy_within(..self.entries, to);
                self.points[to + entry] += step;
                row += 1;
            }
        }
        row
    }

    fn evaluate(&mut self, rows: Range<usize>, of: &dyn Evaluate) {
        let points = &self.points[rows.start * self.entries..rows.end * self.entries];
        let values = &mut self.values[rows.start * self.width..rows.end * self.width];
        of.evaluate(points, values, (&[], &mut []));
    }

    /// The first rows, the point itself among them, with the derivatives there that are known.
    fn evaluate_along(&mut self, rows: usize, known: &[usize], of: &dyn Evaluate) {
        let mut slopes = vec![0.0; known.len() * self.width];
        let points = &self.points[..rows * self.entries];
        of.evaluate(points, &mut self.values[..rows * self.width], (known, &mut slopes));
        for (&entry, slopes) in known.iter().zip(slopes.chunks_exact(self.width)) {
            if slopes.iter().all(|slope| slope.is_finite()) {
                self.errors[entry] = 0.0;
                self.slopes[entry * self.width..(entry + 1) * self.width].copy_from_slice(slopes);
            }
        }
    }

    /// Derivatives by the entries that were moved.
    fn take(&mut self, moved: &[(usize, Moved)]) {
        let mut row = 1;
        for &(entry, how) in moved {
            match how {
                Moved::Ahead => {
                    self.look_ahead(entry, 0, row);
                    self.take_ahead(entry);
                }
                Moved::Around => self.take_around(entry, row),
                Moved::Both => {
                    let sides = row + AROUND - SIDES;
                    (0..SIDES).for_each(|side| self.look_ahead(entry, side, sides + side));
                    self.take_around(entry, row);
                }
            }
            row += how.points().len();
        }
    }

    /// Where a difference ahead by an entry stands.
    fn ahead_of(&self, entry: usize, side: usize) -> Range<usize> {
        let at = (SIDES * entry + side) * self.width;
        at..at + self.width
    }

    /// A difference ahead by an entry, whose point is in a row.
    fn look_ahead(&mut self, entry: usize, side: usize, row: usize) {
        let own = self.ahead_of(entry, side);
        let step = self.points[row * self.entries + entry] - self.points[entry];
        for j in 0..self.width {
            let change = self.values[row * self.width + j] - self.values[j];
            self.ahead[own.start + j] = change / step;
        }
    }

    /// Take the difference ahead for the derivative. Where there is none it is no longer trusted, and
    /// differences around the point are what is tried next.
    fn take_ahead(&mut self, entry: usize) {
        let ahead = &self.ahead[self.ahead_of(entry, 0)];
        if ahead.iter().all(|slope| slope.is_finite()) {
            self.slopes[entry * self.width..(entry + 1) * self.width].copy_from_slice(ahead);
            self.errors[entry] = self.measured[entry];
            self.trusted[entry] -= 1.0;
        } else {
            self.trusted[entry] = 0.0;
        }
    }

    /// Take differences around the point, which begin at a row, if they are better than what there is, and a
    /// smaller step for the next time.
    fn take_around(&mut self, entry: usize, row: usize) {
        let error = self.error(entry, row);
        if error < self.errors[entry] {
            self.errors[entry] = error;
            for j in 0..self.width {
                self.slopes[entry * self.width + j] = self.extrapolated(entry, row, j).slope;
            }
        }
        self.steps[entry] *= SHRINK;
    }

    /// Whether differences ahead by an entry, which were measured here, are good enough to be trusted from here on:
    /// to both sides, as one may be right by chance.
    fn judge(&mut self, entry: usize) {
        self.measured[entry] = self.share_ahead(entry);
        self.trusted[entry] = if self.measured[entry] <= GOOD { TRUSTED } else { 0.0 };
    }

    /// Largest share of error of the differences ahead by an entry: how far they are from the best, and that one's own.
    fn share_ahead(&self, entry: usize) -> f64 {
        let size = self.size(entry);
        let mut worst = 0.0f64;
        for side in 0..SIDES {
            let ahead = &self.ahead[self.ahead_of(entry, side)];
            for ((slope, ahead), value) in
                self.slopes_by(entry).iter().zip(ahead).zip(self.values())
            {
                let off = (ahead - slope).abs();
                if !off.is_finite() {
                    return f64::INFINITY;
                }
                if off > 0.0 {
                    worst = worst.max(off / (slope.abs() + value.abs() / size));
                }
            }
        }
        worst + self.errors[entry]
    }

    /// Largest share of error of the derivatives by an entry, whose points begin at a row.
    fn error(&self, entry: usize, row: usize) -> f64 {
        let (h, size) = (self.steps[entry], self.size(entry));
        let mut worst = 0.0f64;
        for j in 0..self.width {
            // The points of half a step tell how large values are: those that the better difference is of.
            let near = [0, row + 2, row + 3].map(|r| self.values[r * self.width + j].abs());
            let largest = near.into_iter().fold(0.0, f64::max);
            let Extrapolated { slope, change } = self.extrapolated(entry, row, j);
            let error = change / 3.0 + 8.0 * f64::EPSILON * largest / h;
            if !error.is_finite() {
                return f64::INFINITY;
            }
            if error > 0.0 {
                worst = worst.max(error / (slope.abs() + largest / size));
            }
        }
        worst
    }

    /// The derivative of a value by an entry, whose points begin at a row.
    fn extrapolated(&self, entry: usize, row: usize, value: usize) -> Extrapolated {
        let difference = |above: usize| {
            let of = |values: &[f64], width: usize, k: usize| {
                values[above * width + k] - values[(above + 1) * width + k]
            };
            // The distance that is really between the two.
            of(self.values, self.width, value) / of(self.points, self.entries, entry)
        };
        let (coarse, fine) = (difference(row), difference(row + 2));
        Extrapolated { slope: (4.0 * fine - coarse) / 3.0, change: (fine - coarse).abs() }
    }
}

/// A derivative from differences of steps h and h/2, and how these differ.
struct Extrapolated {
    slope: f64,
    change: f64,
}
