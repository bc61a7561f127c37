//! The six planes of a view volume, and sets of them.
//!
//! Culling answers "which planes cut this box", the clipper is asked to clip against just
//! those: the answer travels in a [`PlaneMask`].

/// One side of the view volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Plane {
    /// `x >= -w`
    Left,
    /// `x <= w`
    Right,
    /// `y >= -w`
    Bottom,
    /// `y <= w`
    Top,
    /// `z <= w`: depth is reversed, so near is 1.
    Near,
    /// `z >= 0`; never cuts anything when far is infinite.
    Far,
}

impl Plane {
    /// All six, in the order of their indices.
    pub const ALL: [Plane; 6] =
        [Plane::Left, Plane::Right, Plane::Bottom, Plane::Top, Plane::Near, Plane::Far];

    /// 0..6, the order of [`Plane::ALL`].
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Lower-case name, for tables.
    pub const fn name(self) -> &'static str {
        ["left", "right", "bottom", "top", "near", "far"][self as usize]
    }
}

/// A set of planes, one bit each, in the order of [`Plane::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct PlaneMask(u8);

impl PlaneMask {
    /// No plane: nothing to clip.
    pub const NONE: PlaneMask = PlaneMask(0);
    /// All six planes.
    pub const ALL: PlaneMask = PlaneMask(0b11_1111);

    /// The set with the low six of these bits.
    pub const fn from_bits(bits: u8) -> Self {
        PlaneMask(bits & Self::ALL.0)
    }

    /// One bit per plane.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Adds plane `index` (below 6; others are ignored).
    pub const fn insert(&mut self, index: usize) {
        if index < 6 {
            self.0 |= 1 << index;
        }
    }

    /// Takes plane `index` away.
    pub const fn remove(&mut self, index: usize) {
        if index < 6 {
            self.0 &= !(1 << index);
        }
    }

    /// Whether plane `index` is in the set.
    pub const fn contains(self, index: usize) -> bool {
        index < 6 && self.0 & (1 << index) != 0
    }

    /// Whether there is no plane in the set.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// How many planes.
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Planes in both sets.
    #[must_use]
    pub const fn and(self, other: PlaneMask) -> PlaneMask {
        PlaneMask(self.0 & other.0)
    }

    /// Planes in either set.
    #[must_use]
    pub const fn or(self, other: PlaneMask) -> PlaneMask {
        PlaneMask(self.0 | other.0)
    }

    /// Indices of the planes in the set, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..6).filter(move |&i| self.contains(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_holds_what_was_put_in() {
        let mut mask = PlaneMask::NONE;
        mask.insert(Plane::Near.index());
        mask.insert(Plane::Left.index());
        mask.insert(7);
        assert_eq!(mask.iter().collect::<Vec<_>>(), [0, 4]);
        assert_eq!((mask.len(), mask.is_empty()), (2, false));
        mask.remove(0);
        assert_eq!(mask, PlaneMask::from_bits(0b1_0000));
        assert_eq!(PlaneMask::from_bits(0xff), PlaneMask::ALL);
        assert_eq!(mask.and(PlaneMask::ALL), mask);
        assert_eq!(mask.or(PlaneMask::ALL), PlaneMask::ALL);
    }

    #[test]
    fn names_follow_the_indices() {
        for (i, plane) in Plane::ALL.into_iter().enumerate() {
            assert_eq!(plane.index(), i);
        }
        assert_eq!(Plane::Far.name(), "far");
    }
}
