//! Eight stored boxes, one array per bound.

/// A box in stored units; see [`super::Space`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Box32 {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

impl Box32 {
    /// Neutral in unions.
    pub const EMPTY: Box32 = Box32 { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The least box around both, exactly. An absent box (NaN) is neutral.
    #[inline]
    pub fn union(&self, other: &Box32) -> Box32 {
        let mut all = *self;
        for axis in 0..3 {
            all.min[axis] = all.min[axis].min(other.min[axis]);
            all.max[axis] = all.max[axis].max(other.max[axis]);
        }
        all
    }

    /// The largest coordinate along each axis, without sign; 0 for an empty box.
    #[inline]
    pub fn reach(&self) -> [f32; 3] {
        core::array::from_fn(|i| {
            if self.min[i] <= self.max[i] { (-self.min[i]).max(self.max[i]) } else { 0.0 }
        })
    }

    /// Whether it reaches so far out that f32 is noticeably coarse there: a thousand times what
    /// half of all boxes keep to, if the space is theirs. False for an absent box.
    pub fn is_far(&self) -> bool {
        const FAR: f32 = 1024.0;
        self.min.iter().chain(&self.max).any(|x| x.abs() > FAR)
    }

    /// One of the bounds.
    #[inline(always)]
    pub fn at(&self, row: Row) -> f32 {
        let row = row as usize;
        if row < 3 { self.min[row] } else { self.max[row - 3] }
    }

    /// Twice the middle along `axis`.
    #[inline]
    pub fn center2(&self, axis: usize) -> f32 {
        self.min[axis] + self.max[axis]
    }

    /// Half the area of the six faces, stored units; 0 for an empty box.
    ///
    /// In f64, which holds the square of every f32: one box of 10^20 units would make all areas around
    /// it infinite and all splits equally bad.
    #[inline]
    pub fn half_area(&self) -> f64 {
        let [x, y, z] =
            core::array::from_fn(|i| (f64::from(self.max[i]) - f64::from(self.min[i])).max(0.0));
        x * y + y * z + z * x
    }

    /// What both have in common, if anything. An absent box has nothing.
    pub fn intersection(&self, other: &Box32) -> Option<Box32> {
        let common = Box32 {
            min: core::array::from_fn(|i| self.min[i].max(other.min[i])),
            max: core::array::from_fn(|i| self.max[i].min(other.max[i])),
        };
        let holds = (0..3).all(|i| common.min[i] <= common.max[i]);
        (holds && !other.min[0].is_nan()).then_some(common)
    }
}

/// Which bound of eight boxes: a row of a [`Group`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Row {
    MinX,
    MinY,
    MinZ,
    MaxX,
    MaxY,
    MaxZ,
}

impl Row {
    /// The lesser bounds by axis.
    pub const MIN: [Row; 3] = [Row::MinX, Row::MinY, Row::MinZ];
    /// The greater bounds by axis.
    pub const MAX: [Row; 3] = [Row::MaxX, Row::MaxY, Row::MaxZ];
}

/// Eight boxes; an absent one is NaN throughout, so that every comparison rejects it.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Group {
    /// By [`Row`] and lane.
    rows: [[f32; 8]; 6],
}

impl Group {
    /// Eight absent boxes.
    pub const ABSENT: Group = Group { rows: [[f32::NAN; 8]; 6] };

    /// One bound of all boxes.
    #[inline(always)]
    pub fn row(&self, row: Row) -> &[f32; 8] {
        &self.rows[row as usize]
    }

    /// The box in `lane`; NaN if absent.
    #[inline]
    pub fn get(&self, lane: usize) -> Box32 {
        let [min, max] = [Row::MIN, Row::MAX].map(|rows| rows.map(|row| self.row(row)[lane]));
        Box32 { min, max }
    }

    /// Puts a box in `lane`.
    #[inline]
    pub fn set(&mut self, lane: usize, bounds: &Box32) {
        for axis in 0..3 {
            self.rows[axis][lane] = bounds.min[axis];
            self.rows[axis + 3][lane] = bounds.max[axis];
        }
    }

    /// Takes the box in `lane` away.
    pub fn clear(&mut self, lane: usize) {
        self.set(lane, &Box32 { min: [f32::NAN; 3], max: [f32::NAN; 3] });
    }

    /// The least box around all present.
    pub fn union(&self) -> Box32 {
        let fold = |row: Row, start: f32, f: fn(f32, f32) -> f32| {
            self.row(row).iter().copied().fold(start, f) // f32::min and max pass over NaN
        };
        Box32 {
            min: Row::MIN.map(|row| fold(row, f32::INFINITY, f32::min)),
            max: Row::MAX.map(|row| fold(row, f32::NEG_INFINITY, f32::max)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_boxes_are_neutral() {
        let mut group = Group::ABSENT;
        assert_eq!(group.union(), Box32::EMPTY);
        assert_eq!(group.union().reach(), [0.0; 3]);
        let a = Box32 { min: [-3.0, 0.0, 1.0], max: [1.0, 2.0, 4.0] };
        group.set(5, &a);
        assert_eq!((group.union(), group.get(5)), (a, a));
        assert_eq!(group.union().reach(), [3.0, 2.0, 4.0]);
        assert!(group.get(4).min[0].is_nan());
        group.clear(5);
        assert_eq!(group.union(), Box32::EMPTY);
    }

    #[test]
    fn areas() {
        let a = Box32 { min: [0.0; 3], max: [1.0, 2.0, 3.0] };
        assert_eq!(a.half_area(), 11.0);
        assert_eq!(Box32::EMPTY.half_area(), 0.0);
        let b = Box32 { min: [-1e30; 3], max: [1e30, 1e30, 0.0] };
        assert!((b.half_area() / 8e60 - 1.0).abs() < 1e-6);
    }
}
