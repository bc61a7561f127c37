//! Where a pixel is sampled.
//!
//! The patterns of multisampling are the standard ones of Direct3D 11 (`D3D11_STANDARD_MULTISAMPLE_QUALITY_LEVELS`;
//! the Vulkan specification's standard sample locations agree), in sixteenths of a pixel from its centre.

/// A sample's place: sixteenths of a pixel right of and below the pixel's centre, in `-8..=7`.
pub type Offset = [i32; 2];

/// How many samples a pixel has, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Samples {
    /// One, at the centre.
    #[default]
    One,
    /// Two.
    Two,
    /// Four.
    Four,
    /// Eight.
    Eight,
}

impl Samples {
    /// Every pattern.
    pub const ALL: [Samples; 4] = [Samples::One, Samples::Two, Samples::Four, Samples::Eight];

    /// The places, in the order of sample numbers.
    pub const fn offsets(self) -> &'static [Offset] {
        match self {
            Samples::One => &[[0, 0]],
            Samples::Two => &[[4, 4], [-4, -4]],
            Samples::Four => &[[-2, -6], [6, -2], [-6, 2], [2, 6]],
            Samples::Eight => {
                &[[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]]
            }
        }
    }

    /// How many.
    pub const fn count(self) -> usize {
        self.offsets().len()
    }

    /// The farthest that any sample lies from the centre along either axis, sixteenths.
    pub const fn reach(self) -> i32 {
        match self {
            Samples::One => 0,
            Samples::Two => 4,
            Samples::Four => 6,
            Samples::Eight => 7,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_a_row_and_a_column_of_its_own() {
        for samples in Samples::ALL {
            for axis in 0..2 {
                let mut places: Vec<_> = samples.offsets().iter().map(|o| o[axis]).collect();
                let reach = places.iter().map(|place| place.abs()).max();
                assert_eq!(reach, Some(samples.reach()));
                places.sort_unstable();
                places.dedup();
                assert_eq!(places.len(), samples.count());
            }
        }
    }
}
