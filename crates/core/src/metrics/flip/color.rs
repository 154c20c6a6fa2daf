//! The color spaces of FLIP. XYZ is in units of the white point's, (1, 1, 1).

use glam::{DMat3, DVec3};

/// XYZ of linear sRGB: rows of integers, to be divided by their sums.
const XYZ: [[f64; 3]; 3] = [
    [10_135_552.0, 8_788_810.0, 4_435_075.0],
    [2_613_072.0, 8_788_810.0, 887_015.0],
    [1_425_312.0, 8_788_810.0, 70_074_185.0],
];

/// Conversions from and to linear sRGB.
#[derive(Debug)]
pub struct Colors {
    xyz: DMat3,
    rgb: DMat3,
}

impl Colors {
    pub fn new() -> Self {
        let xyz =
            DMat3::from_cols_array_2d(&XYZ.map(|row| row.map(|weight| weight / row.iter().sum::<f64>()))).transpose();
        Self { xyz, rgb: xyz.inverse() }
    }

    /// YCxCz of linear RGB that is clamped to [0, 1]: CIELAB without its curve.
    pub fn opponent(&self, rgb: [f32; 3]) -> DVec3 {
        opponents(self.xyz * DVec3::from_array(rgb.map(|value| f64::from(value.clamp(0.0, 1.0)))))
    }

    /// Returns linear RGB of YCxCz.
    pub fn linear(&self, opponent: DVec3) -> DVec3 {
        let y = (opponent.x + 16.0) / 116.0;
        self.rgb * DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0)
    }

    /// CIELAB of linear RGB, in which a and b count the less the darker a color is (Hunt's effect): a·L/100, b·L/100.
    pub fn hunt_lab(&self, rgb: DVec3) -> DVec3 {
        let lab = opponents((self.xyz * rgb).map(curve));
        DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
    }
}

fn opponents(xyz: DVec3) -> DVec3 {
    DVec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
}

/// The cube root with a straight piece near 0, as CIELAB defines it.
fn curve(t: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_gray_and_black_have_no_hue() {
        let colors = Colors::new();
        for (rgb, lightness) in [(1.0, 100.0), (0.0, 0.0), (0.125, 42.0)] {
            // The cube root of 0.125 is 0.5: 116/2 − 16 = 42.
            let lab = colors.hunt_lab(DVec3::splat(rgb));
            assert!((lab - DVec3::new(lightness, 0.0, 0.0)).length() < 1e-12, "{lab}");
        }
    }

    #[test]
    fn opponents_and_back() {
        let colors = Colors::new();
        let rgb = [0.25f32, 0.5, 0.875];
        let there = colors.opponent(rgb);
        assert!((colors.linear(there) - DVec3::from_array(rgb.map(f64::from))).length() < 1e-14);
        // Gray: 116 · 0.5 − 16.
        assert!((colors.opponent([0.5; 3]) - DVec3::new(42.0, 0.0, 0.0)).length() < 1e-12);
        assert_eq!(colors.opponent([2.0, -1.0, 1.0]), colors.opponent([1.0, 0.0, 1.0]), "clamped");
    }

    #[test]
    fn published_lab_of_the_primaries() {
        // CIELAB of sRGB's green and blue under D65 (87.73, −86.18, 83.18 and 32.30, 79.19, −107.86), times L/100.
        let colors = Colors::new();
        for (rgb, [l, a, b]) in [(DVec3::Y, [87.73, -86.18, 83.18]), (DVec3::Z, [32.30, 79.19, -107.86])] {
            let expected = DVec3::new(l, 0.01 * l * a, 0.01 * l * b);
            assert!((colors.hunt_lab(rgb) - expected).abs().max_element() < 0.02, "{}", colors.hunt_lab(rgb));
        }
    }
}
