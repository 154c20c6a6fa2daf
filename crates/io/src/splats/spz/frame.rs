//! The axes of an SPZ file, which an extension may name, and the way from them to those of other splats: right, down,
//! front.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3, Vec3};

use super::super::turn::Turn;

/// The number of the axes of files that name none: right, up, back.
const RUB: u32 = 4;

/// The way from the axes of a file to right, down, front.
#[derive(Debug)]
pub(super) struct Frame {
    /// 1 or −1 for each axis.
    flip: DVec3,
    /// 1 or −1 for each coefficient from degree 1 on: what `flip` makes of them.
    signs: [f32; 24],
    /// Turn after that, of axes the third of which is vertical.
    turn: Option<(DQuat, Turn)>,
}

impl Default for Frame {
    fn default() -> Self {
        Self::of(RUB)
    }
}

impl Frame {
    /// Returns the axes of a number of the extension; `None` of one that it does not define.
    ///
    /// 1 to 8 mean left or right, down or up, back or front: of the number less one, the lowest bit chooses the first
    /// axis, the next one the second, the third one the third. 9 to 16 mean left or right, front or back, down or up,
    /// of which the second bit chooses the last. 0 means that nothing was said.
    pub fn numbered(number: u32) -> Option<Self> {
        match number {
            0 => Some(Self::default()),
            1..=16 => Some(Self::of(number)),
            _ => None,
        }
    }

    /// The axes of a number from 1 to 16.
    fn of(number: u32) -> Self {
        let bit = |at: u32| (number - 1) >> at & 1 == 1;
        let sign = |is_meant: bool| if is_meant { 1.0 } else { -1.0 };
        if !bit(3) {
            let flip = DVec3::new(sign(bit(0)), sign(!bit(1)), sign(bit(2)));
            return Self { flip, signs: signs(flip), turn: None };
        }
        // Right, back, down first, and then a quarter turn that takes down from the third axis to the second one.
        let flip = DVec3::new(sign(bit(0)), sign(bit(2)), sign(!bit(1)));
        let turn = DQuat::from_rotation_x(-FRAC_PI_2);
        Self { flip, signs: signs(flip), turn: Some((turn, Turn::new(turn))) }
    }

    /// Returns a position of the file.
    pub fn position(&self, position: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = position * self.flip;
        // The quarter turn, without a rounding.
        if self.turn.is_some() { DVec3::new(x, z, -y) } else { DVec3::new(x, y, z) }
    }

    /// Returns a rotation of the file: flipped before and after it, which leaves the axes of a splat where they are,
    /// and then turned.
    pub fn rotation(&self, rotation: DQuat) -> DQuat {
        let DVec3 { x, y, z } = self.flip;
        let flipped = DQuat::from_xyzw(rotation.x * y * z, rotation.y * x * z, rotation.z * x * y, rotation.w);
        self.turn.as_ref().map_or(flipped, |(turn, _)| *turn * flipped)
    }

    /// Turns the coefficients of a splat.
    pub fn turn_harmonics(&self, harmonics: &mut [Vec3]) {
        harmonics.iter_mut().zip(self.signs).for_each(|(color, sign)| *color *= sign);
        if let Some((_, turn)) = &self.turn {
            turn.apply(harmonics);
        }
    }
}

/// Returns how the harmonics of each degree and order change with the signs of the axes: those of negative order are
/// odd in y, those whose degree and order differ by an odd number are odd in z, and those of odd positive or even
/// negative order are odd in x.
fn signs(flip: DVec3) -> [f32; 24] {
    let orders = (1..=4_i32).flat_map(|degree| (-degree..=degree).map(move |order| (degree, order)));
    let [x, y, z] = flip.to_array().map(|sign| sign < 0.0);
    let mut signs = [1.0; 24];
    for (sign, (degree, order)) in signs.iter_mut().zip(orders) {
        let odd = [order.rem_euclid(2) == i32::from(order >= 0), order < 0, (degree + order) % 2 != 0];
        let changes = [x && odd[0], y && odd[1], z && odd[2]].into_iter().filter(|change| *change).count();
        if changes % 2 == 1 {
            *sign = -1.0;
        }
    }
    signs
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    #[test]
    fn signs_are_those_of_the_polynomials() {
        // y, z, x; xy, yz, 2z²−x²−y², xz, x²−y²; y(3x²−y²), xyz, y(…z²…), z(…), x(…), z(x²−y²), x(…); of degree 4 xy,
        // yz, xy, yz, 1, xz, x²−y², xz, 1.
        let names = [
            "y", "z", "x", "xy", "yz", "", "xz", "", "y", "xyz", "y", "z", "x", "z", "x", "xy", "yz", "xy", "yz", "",
            "xz", "", "xz", "",
        ];
        for flip in 0..8 {
            let is_flipped = [0, 1, 2].map(|axis| flip >> axis & 1 == 1);
            let sign = |name: &str| {
                let odd =
                    "xyz".chars().zip(is_flipped).filter(|(axis, is_flipped)| *is_flipped && name.contains(*axis));
                if odd.count() % 2 == 1 { -1.0 } else { 1.0 }
            };
            let axes = DVec3::from(is_flipped.map(|is_flipped| if is_flipped { -1.0 } else { 1.0 }));
            assert_eq!(signs(axes), names.map(sign), "{axes}");
        }
    }

    /// Directions of the letters of the names of axes, as right, down, front.
    fn direction(letter: char) -> DVec3 {
        match letter {
            'R' => DVec3::X,
            'L' => DVec3::NEG_X,
            'D' => DVec3::Y,
            'U' => DVec3::NEG_Y,
            'F' => DVec3::Z,
            _ => DVec3::NEG_Z,
        }
    }

    #[test]
    fn each_number_means_the_axes_of_its_name() {
        let names = [
            "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF", "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU",
            "RBU",
        ];
        for (number, name) in (1..).zip(names) {
            let frame = Frame::numbered(number).unwrap();
            let [a, b, c] = [0, 1, 2].map(|at| direction(name.chars().nth(at).unwrap()));
            let axes = DMat3::from_cols(a, b, c);
            for point in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)] {
                assert_eq!(frame.position(point), axes * point, "{name}");
            }
            // An ellipsoid is where its points are.
            let (rotation, extents) = (DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize(), DVec3::new(1.0, 2.0, 3.0));
            let shape = |matrix: DMat3| {
                let scaled = matrix * DMat3::from_diagonal(extents);
                scaled * scaled.transpose()
            };
            let expected = axes * shape(DMat3::from_quat(rotation)) * axes.transpose();
            let found = shape(DMat3::from_quat(frame.rotation(rotation)));
            assert!((found - expected).to_cols_array().iter().all(|off| off.abs() < 1e-12), "{name}");
            // A color has the value in a direction that it had where that comes from: degree 1 is −y, z, −x.
            let mut harmonics = [Vec3::splat(1.0), Vec3::splat(2.0), Vec3::splat(4.0)];
            let color = |of: &[Vec3], d: DVec3| {
                let [y, z, x] = [of[0].x, of[1].x, of[2].x].map(f64::from);
                -y * d.y + z * d.z - x * d.x
            };
            let (old, d) = (harmonics, DVec3::new(0.6, -0.64, 0.48));
            frame.turn_harmonics(&mut harmonics);
            assert!((color(&harmonics, axes * d) - color(&old, d)).abs() < 1e-6, "{name}");
        }
        assert!(Frame::numbered(17).is_none());
        assert_eq!(Frame::numbered(0).unwrap().position(DVec3::ONE), DVec3::new(1.0, -1.0, -1.0), "right, up, back");
    }
}
