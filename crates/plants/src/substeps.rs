//! How the way from one sample to the next is integrated: equal steps of Runge-Kutta, which may be cut where a
//! slope jumps.
//!
//! Friction, stops and switches are smooth but for a few samples: where a joint turns, its acceleration changes
//! within a thousandth of a second, and steps short enough for that are too many everywhere else. The four slopes
//! `k_1 .. k_4` of a step of order four tell where: of a smooth motion
//!
//! ```text
//! |k_1 - k_2 - k_3 + k_4| + |k_3 - k_2| = O(h^2)
//! ```
//!
//! (the second difference of the slope over the step, and what half a step along another slope changes), while at a
//! kink it is as large as the slopes, and of a rate `lambda` it is `(h lambda)^2 / 2` of them. Derivatives are looked
//! at as values are: what rests in stiff friction has slopes of 0 in any steps, and its derivatives run away in long
//! ones.

/// Runge-Kutta steps from one sample to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Substeps {
    /// Steps of equal length.
    pub count: usize,
    /// Whether each is cut in four, and these once more and again, where its slopes jump.
    pub cut: bool,
}

impl Substeps {
    /// So many steps of equal length.
    #[must_use]
    pub const fn even(count: usize) -> Self {
        Self { count, cut: false }
    }

    /// So many steps that are cut where their slopes jump.
    #[must_use]
    pub const fn cut(count: usize) -> Self {
        Self { count, cut: true }
    }

    /// Steps that are as short as either, and are cut where either is.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { count: self.count.max(other.count), cut: self.cut || other.cut }
    }

    /// Go from `times.0` to `times.1`; how many steps were made, those that were cut among them.
    #[inline(always)]
    pub(crate) fn take(self, times: (f64, f64), stepped: &mut impl Stepped) -> usize {
        let whole = (times.1 - times.0) / self.count as f64;
        let mut made = 0;
        for s in 0..self.count {
            let mut cuts = Cuts::of(self, stepped.turns());
            while cuts.is_left() {
                let (t, h) = cuts.span(times.0 + s as f64 * whole, whole);
                if cuts.is_long() && stepped.is_planned(cuts.part(s)) {
                    cuts.cut();
                    continue;
                }
                // In a loop: four copies of a stage are more code than is read ahead.
                let stages = [(0, 0.0), (1, 0.5 * h), (1, 0.5 * h), (2, h)];
                for (k, (half, step)) in stages.into_iter().enumerate() {
                    stepped.stage(k, (t + step, cuts.place(s, half, self)), step);
                }
                made += 1;
                if cuts.may_go_on() && stepped.jumps() {
                    stepped.plan(cuts.part(s));
                    cuts.cut();
                    continue;
                }
                stepped.complete(h);
                cuts.next();
            }
        }
        made
    }
}

/// What goes on in steps of Runge-Kutta.
pub(crate) trait Stepped {
    /// Find the `k`-th slope of a step, at a time and place: the state moved by `step` along the slope before it.
    fn stage(&mut self, k: usize, at: (f64, Place), step: f64);

    /// Whether the four slopes jump within the step.
    fn jumps(&self) -> bool;

    /// Whether it turns within much less than a step: dry friction.
    fn turns(&self) -> bool;

    /// Take the step of `h`, from its four slopes.
    fn complete(&mut self, h: f64);

    /// Whether others cut this part: its slopes need not be looked at.
    fn is_planned(&self, _part: Part) -> bool {
        false
    }

    /// Tell others that this part is cut.
    fn plan(&mut self, _part: Part) {}
}

/// A part of a step that can be cut: of which step, and which of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Part {
    step: usize,
    /// Its number in the tree of all parts of a step.
    number: usize,
}

/// Where several that step side by side, each by itself, cut the way from one sample to the next: what one of them
/// cuts, all do. Derivatives along paths that are cut otherwise are those of other sums, and no combination of them
/// is as small as it ought to be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// The parts that are cut, in order.
    cut: Vec<Part>,
    /// Whether a part was added since this was asked.
    grew: bool,
}

impl Plan {
    /// Begin anew.
    pub fn begin(&mut self) {
        self.cut.clear();
    }

    /// Whether a part is cut.
    #[inline(always)]
    pub fn holds(&self, part: Part) -> bool {
        self.cut.binary_search(&part).is_ok()
    }

    /// Cut a part.
    #[inline(always)]
    pub fn add(&mut self, part: Part) {
        if let Err(place) = self.cut.binary_search(&part) {
            self.cut.insert(place, part);
            self.grew = true;
        }
    }

    /// Whether a part was added since this was asked last.
    pub fn grew(&mut self) -> bool {
        std::mem::take(&mut self.grew)
    }
}

/// A place on the way from one sample to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// In how many parts the way is.
    parts: usize,
    /// How much of it is behind, in shares of a part.
    behind: usize,
}

impl Place {
    /// Shares of a part: the parts of the shortest piece of a step are whole ones.
    const SHARES: usize = Cuts::PARTS;

    /// At the end of the `part`-th of so many parts.
    #[inline(always)]
    pub const fn of(part: usize, parts: usize) -> Self {
        Self { parts, behind: part * Self::SHARES }
    }

    /// As a share of the way.
    #[inline(always)]
    pub fn share(self) -> f64 {
        self.behind as f64 / (self.parts * Self::SHARES) as f64
    }

    /// The parts that are behind, and the share of one beyond them.
    #[inline(always)]
    pub fn parts(self) -> (usize, f64) {
        let rest = self.behind % Self::SHARES;
        (self.behind / Self::SHARES, rest as f64 / Self::SHARES as f64)
    }
}

/// Largest jump of the slopes of a step that is not cut, as a share of the slopes: rates up to `0.45 / h` are
/// resolved, of which a step of order four errs by a ten-thousandth.
pub(crate) const JUMP: f64 = 0.1;
/// The same of derivatives, which need but be kept from running away: rates up to `1.6 / h`, and steps of order four
/// are stable up to `2.78 / h`.
pub(crate) const JUMP_OF_DERIVATIVES: f64 = 1.0;
/// Slopes that are this much smaller than the largest are the rounding of others.
const ROUNDING: f64 = 1e-9;

/// Whether slopes jump by more than a share of them within a step: `slope(i, k)` is the `k`-th of entry `i`, of which the
/// last digits of `beside(i)` are the rounding.
#[inline(always)]
pub(crate) fn jumps(
    share: f64,
    mut entries: std::ops::Range<usize>,
    slope: impl Fn(usize, usize) -> f64 + Copy,
    beside: impl Fn(usize) -> f64,
) -> bool {
    let of = |i: usize| [0, 1, 2, 3].map(|k| slope(i, k));
    let size = |k: [f64; 4]| k.into_iter().fold(0.0f64, |most, k| most.max(k.abs()));
    let most = entries.clone().map(|i| size(of(i))).fold(0.0, f64::max);
    let jumps = |i: usize| {
        let (k, size) = (of(i), size(of(i)));
        let jump = (k[0] - k[1] - k[2] + k[3]).abs() + (k[2] - k[1]).abs();
        jump > share * size && size > ROUNDING * most.max(beside(i))
    };
    most.is_finite() && entries.any(jumps)
}

/// Where the integration of a step is that may be cut: in whole parts of the shortest that there are.
#[derive(Clone, Copy, Debug)]
struct Cuts {
    /// The part that comes next.
    at: usize,
    /// How many parts it is long.
    length: usize,
    shortest: usize,
    /// How often it was cut further than is usual.
    deep: usize,
}

impl Cuts {
    /// Into how many a part is cut.
    const PIECES: usize = 4;
    /// The shortest parts of a step: a velocity that changes by a tenth of what is usual from sample to sample changes
    /// by less within one than the steepest dry friction takes to turn.
    const PARTS: usize = Self::PIECES.pow(7);
    /// Shorter parts than these are where a velocity turns in dry friction, of which [`Self::DEEPEST`] are cut in a step:
    /// what is stiff in any other way would be so everywhere.
    const USUAL: usize = Self::PIECES.pow(4);
    /// Two turns, each in one part of every level.
    const DEEPEST: usize = 2 * 4;

    #[inline(always)]
    fn of(substeps: Substeps, turns: bool) -> Self {
        let shortest = match (substeps.cut, turns) {
            (false, _) => Self::PARTS,
            (true, false) => Self::USUAL,
            (true, true) => 1,
        };
        Self { at: 0, length: Self::PARTS, shortest, deep: 0 }
    }

    /// Whether some of the step is left.
    #[inline(always)]
    fn is_left(&self) -> bool {
        self.at < Self::PARTS
    }

    /// Whether this part may be cut.
    #[inline(always)]
    fn is_long(&self) -> bool {
        self.length > self.shortest
    }

    /// Whether this part may be cut where its slopes jump.
    #[inline(always)]
    fn may_go_on(&self) -> bool {
        self.is_long() && (self.length > Self::USUAL || self.deep < Self::DEEPEST)
    }

    /// Go on with the first piece of this part.
    #[inline(always)]
    fn cut(&mut self) {
        self.deep += usize::from(self.length <= Self::USUAL);
        self.length /= Self::PIECES;
    }

    /// Go on behind this part: what was cut is behind where its last piece is.
    #[inline(always)]
    fn next(&mut self) {
        self.at += self.length;
        while self.length < Self::PARTS && self.at.is_multiple_of(Self::PIECES * self.length) {
            self.length *= Self::PIECES;
        }
    }

    /// Which part of the `s`-th step this is: the whole is the first, then come its pieces, then theirs.
    #[inline(always)]
    fn part(&self, s: usize) -> Part {
        let (mut before, mut length) = (0, Self::PARTS);
        while length > self.length {
            before = before * Self::PIECES + 1;
            length /= Self::PIECES;
        }
        Part { step: s, number: before + self.at / self.length }
    }

    /// When this part begins and how long it is, of a step that begins at `t` and is `h` long.
    #[inline(always)]
    fn span(&self, t: f64, h: f64) -> (f64, f64) {
        let share = |parts: usize| parts as f64 / Self::PARTS as f64;
        (t + share(self.at) * h, share(self.length) * h)
    }

    /// Where the beginning, the middle or the end (0, 1, 2) of this part of the `s`-th step is: half steps are the
    /// parts of the way.
    #[inline(always)]
    fn place(&self, s: usize, half: usize, substeps: Substeps) -> Place {
        let behind = 2 * (s * Self::PARTS + self.at) + half * self.length;
        Place { parts: 2 * substeps.count, behind }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cuts, JUMP, Plan, Substeps, jumps};

    /// Every piece is gone through once, and what is behind a cut part is whole again.
    #[test]
    fn pieces_follow_one_another() {
        let mut cuts = Cuts::of(Substeps::cut(1), true);
        cuts.cut();
        let quarter = Cuts::PARTS / 4;
        let mut through = vec![];
        while cuts.is_left() {
            if cuts.length > quarter / 16 && cuts.at == quarter {
                cuts.cut();
                continue;
            }
            through.push((cuts.at, cuts.length));
            cuts.next();
        }
        let piece = |at: usize, length: usize| (quarter / 16 * at, quarter / 16 * length);
        let pieces = [
            (0, 16),
            (16, 1),
            (17, 1),
            (18, 1),
            (19, 1),
            (20, 4),
            (24, 4),
            (28, 4),
            (32, 16),
            (48, 16),
        ];
        assert_eq!(through, pieces.map(|(at, length)| piece(at, length)));
        assert!(!Cuts::of(Substeps::even(3), true).is_long());
    }

    /// Every part that can be cut is told from every other.
    #[test]
    fn a_plan_knows_each_part() {
        let substeps = Substeps::cut(2);
        let mut plan = Plan::default();
        plan.begin();
        let mut count = 0;
        let lengths = (0..7).map(|level| Cuts::PARTS / Cuts::PIECES.pow(level));
        for (step, length) in [0, 1].into_iter().flat_map(|s| lengths.clone().map(move |l| (s, l)))
        {
            for at in (0..Cuts::PARTS).step_by(length) {
                let part = Cuts { at, length, ..Cuts::of(substeps, true) }.part(step);
                assert!(!plan.holds(part) && !plan.grew());
                plan.add(part);
                assert!(plan.holds(part) && plan.grew());
                count += 1;
            }
        }
        assert_eq!(count, 2 * 5461);
        plan.begin();
        assert!(!plan.holds(Cuts::of(substeps, true).part(1)));
    }

    #[test]
    fn kinks_jump_and_smooth_slopes_do_not() {
        let along = |slope: fn(f64) -> f64| {
            let at = [0.0, 0.5, 0.5, 1.0].map(slope);
            jumps(JUMP, 0..1, |_, k| at[k], |_| 0.0)
        };
        assert!(!along(|t| (0.4 * t).sin()) && !along(|_| 0.0) && !along(|t| 1.0 - 0.3 * t));
        assert!(along(|t| if t < 0.7 { 1.0 } else { -1.0 }));
        assert!(along(|t| if t > 0.0 { 1.0 } else { 0.5 }));
        // What rounding leaves of entries that do not move, and what is no number.
        let rows = [[1.0; 4], [1e-17, -1e-17, 1e-17, 0.0]];
        assert!(!jumps(JUMP, 0..2, |i, k| rows[i][k], |_| 0.0));
        assert!(jumps(JUMP, 1..2, |i, k| rows[i][k], |_| 0.0));
        assert!(!jumps(JUMP, 1..2, |i, k| rows[i][k], |_| 1.0));
        assert!(!jumps(JUMP, 0..1, |_, _| f64::NAN, |_| 0.0));
    }
}
