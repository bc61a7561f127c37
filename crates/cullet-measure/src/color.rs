//! The colour spaces the metrics are defined in, in f64.
//!
//! Sources: IEC 61966-2-1:1999 (sRGB); CIE 15:2018 (CIELAB). The XYZ matrix follows from
//! the sRGB primaries and the white point x = 0.31271, y = 0.32902, the one behind the
//! published FLIP values; the standard's rounded 0.3127, 0.3290 moves its entries by 1e-5.

/// sRGB-encoded to linear, both in [0, 1].
pub(crate) fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Linear to sRGB-encoded, both in [0, 1].
pub(crate) fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    }
}

/// Luma: Rec. 709 weights on encoded values.
pub(crate) fn luma([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

const XYZ_FROM_LINEAR: [[f64; 3]; 3] = [
    [0.4123865632529917, 0.35759149092062537, 0.18045049120356368],
    [0.21263682167732384, 0.7151829818412507, 0.07218019648142547],
    [0.019330620152483987, 0.11919716364020845, 0.9503725870054354],
];

const LINEAR_FROM_XYZ: [[f64; 3]; 3] = [
    [3.2410032329763587, -1.5373989694887855, -0.4986158819963629],
    [-0.9692242522025166, 1.875929983695176, 0.041554226340084724],
    [0.055639419851975444, -0.20401120612390997, 1.0571489771875335],
];

/// XYZ of linear (1, 1, 1).
const WHITE: [f64; 3] = [0.9504285453771807, 1.0, 1.0889003707981277];

/// Linear RGB to XYZ divided by the white point's: white is (1, 1, 1).
pub(crate) fn relative_xyz_from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = apply(&XYZ_FROM_LINEAR, rgb);
    std::array::from_fn(|i| xyz[i] / WHITE[i])
}

/// Inverse of [`relative_xyz_from_linear`].
pub(crate) fn linear_from_relative_xyz(xyz: [f64; 3]) -> [f64; 3] {
    apply(&LINEAR_FROM_XYZ, std::array::from_fn(|i| xyz[i] * WHITE[i]))
}

/// CIELAB of a white-relative XYZ: L in [0, 100] for colours within the screen's gamut.
pub(crate) fn lab_from_relative_xyz(xyz: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] = xyz.map(|t| {
        if t > DELTA * DELTA * DELTA {
            libm::cbrt(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// YCxCz of a white-relative XYZ: CIELAB without its cube root, an opponent space that
/// blurs as light does.
pub(crate) fn opponent_from_relative_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Inverse of [`opponent_from_relative_xyz`].
pub(crate) fn relative_xyz_from_opponent([luminance, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (luminance + 16.0) / 116.0;
    [y + cx / 500.0, y, y - cz / 200.0]
}

fn apply(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_near(found: [f64; 3], expected: [f64; 3]) {
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-12, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn white_is_one_and_a_hundred() {
        let white = relative_xyz_from_linear([1.0; 3]);
        check_near(white, [1.0; 3]);
        check_near(lab_from_relative_xyz(white), [100.0, 0.0, 0.0]);
        check_near(opponent_from_relative_xyz(white), [100.0, 0.0, 0.0]);
    }

    #[test]
    fn there_and_back_is_the_identity() {
        for rgb in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.25, 0.5, 0.75], [0.001, 1.0, 0.4]] {
            let xyz = relative_xyz_from_linear(rgb);
            let back = relative_xyz_from_opponent(opponent_from_relative_xyz(xyz));
            check_near(linear_from_relative_xyz(back), rgb);
            check_near(rgb.map(srgb_from_linear).map(linear_from_srgb), rgb);
        }
    }
}
