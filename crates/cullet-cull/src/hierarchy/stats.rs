//! What one walk did.

use core::ops::AddAssign;

use crate::PlaneMask;
use crate::wide::Verdict;

/// The most levels a tree has. Eight to the tenth is all that 32-bit item numbers can name, the
/// rest is room for boxes that refuse to be balanced.
pub const MAX_LEVELS: usize = 32;

/// Verdicts on a number of boxes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Boxes asked about: the sum of the other three.
    pub tested: u64,
    /// Excluded by a plane.
    pub outside: u64,
    /// Wholly inside all planes.
    pub inside: u64,
    /// Neither.
    pub straddling: u64,
}

impl Counts {
    /// Of one box, by the planes that cut it, or `None` if one excludes it.
    #[inline]
    pub(super) fn of_one(cutting: Option<PlaneMask>) -> Counts {
        let mut counts = Counts { tested: 1, ..Counts::default() };
        match cutting {
            None => counts.outside = 1,
            Some(PlaneMask::NONE) => counts.inside = 1,
            Some(_) => counts.straddling = 1,
        }
        counts
    }

    /// Of the boxes that are `present` in a group.
    #[inline(always)]
    pub(super) fn of(present: u8, verdict: Verdict) -> Counts {
        let count = |bits: u8| u64::from(bits.count_ones());
        let (visible, inside) = (count(verdict.visible), count(verdict.inside()));
        let tested = count(present);
        Counts { tested, outside: tested - visible, inside, straddling: visible - inside }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Counts) {
        self.tested += other.tested;
        self.outside += other.outside;
        self.inside += other.inside;
        self.straddling += other.straddling;
    }
}

/// What a walk tested and found. Adds up over walks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WalkStats {
    /// Boxes of nodes: the one around everything, and if it is not outside, those below it.
    pub nodes: Counts,
    /// Boxes of items.
    pub items: Counts,
    /// Eight-wide tests made.
    pub n_groups: u64,
    /// Items returned without a test because a box above them was wholly inside.
    pub n_untested: u64,
    /// Items returned.
    pub n_visible: u64,
    /// Nodes and leaves that `occluded` said are hidden.
    pub n_occluded: u64,
}

impl AddAssign<&WalkStats> for WalkStats {
    fn add_assign(&mut self, other: &WalkStats) {
        self.nodes += other.nodes;
        self.items += other.items;
        self.n_groups += other.n_groups;
        self.n_untested += other.n_untested;
        self.n_visible += other.n_visible;
        self.n_occluded += other.n_occluded;
    }
}
