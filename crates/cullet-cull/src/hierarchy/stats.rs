//! What one walk did.

use core::ops::AddAssign;

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
    /// Boxes of nodes, by level; level 0 holds the children of the root.
    pub levels: [Counts; MAX_LEVELS],
    /// Boxes of items, all levels together.
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

impl WalkStats {
    /// Boxes of nodes, all levels together.
    pub fn nodes(&self) -> Counts {
        let mut sum = Counts::default();
        self.levels.iter().for_each(|counts| sum += *counts);
        sum
    }
}

impl AddAssign<&WalkStats> for WalkStats {
    fn add_assign(&mut self, other: &WalkStats) {
        for (sum, counts) in self.levels.iter_mut().zip(&other.levels) {
            *sum += *counts;
        }
        self.items += other.items;
        self.n_groups += other.n_groups;
        self.n_untested += other.n_untested;
        self.n_visible += other.n_visible;
        self.n_occluded += other.n_occluded;
    }
}
