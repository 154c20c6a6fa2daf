//! The planes of an SPZ file, and the splats in them.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, DVec3, Vec3};

use super::super::{Splat, from_coefficient};
use super::Header;
use super::frame::Frame;
use crate::number::{half, word};
use pellucid_core::cloud::gaussians::coefficients;

/// A byte of color is 255·(½ + this·coefficient).
const COLOR: f64 = 0.15;

/// Contents of the planes, in order.
pub(super) const NAMES: [&str; 6] = ["positions", "opacities", "colors", "scales", "rotations", "harmonics"];

/// The bytes of each attribute.
#[derive(Debug)]
pub(super) struct Planes {
    version: u32,
    /// The length of a step of positions.
    step: f64,
    /// Planes of the file, in the order of [`NAMES`].
    planes: [Vec<u8>; 6],
    /// The axes of the file.
    pub frame: Frame,
}

/// Returns bytes of each plane.
pub(super) fn lengths(header: &Header) -> [u64; 6] {
    let position = if header.version == 1 { 6 } else { 9 };
    let rotation = if header.version < 3 { 3 } else { 4 };
    let each = [position, 1, 3, 3, rotation, 3 * coefficients(header.degree) as u64];
    each.map(|bytes| bytes * header.count)
}

impl Planes {
    /// Returns planes of the lengths that the header tells.
    pub fn new(header: &Header, planes: [Vec<u8>; 6]) -> Self {
        Self { version: header.version, step: (-f64::from(header.fraction)).exp2(), planes, frame: Frame::default() }
    }

    /// Returns the planes that stand one behind the other; if one ends too early, a message that says which.
    pub fn cut(header: &Header, mut bytes: &[u8]) -> Result<Self, String> {
        let mut planes: [Vec<u8>; 6] = Default::default();
        for ((plane, len), name) in planes.iter_mut().zip(lengths(header)).zip(NAMES) {
            let Some((own, rest)) = usize::try_from(len).ok().and_then(|len| bytes.split_at_checked(len)) else {
                return Err(format!("{} bytes are left for the {len} bytes of {name}", bytes.len()));
            };
            *plane = own.to_vec();
            bytes = rest;
        }
        Ok(Self::new(header, planes))
    }

    /// Returns a splat, in the axes of other splats.
    pub fn splat(&self, at: usize, harmonics: &mut [Vec3]) -> Splat {
        let [_, alphas, colors, scales, _, coefficients] = &self.planes;
        let three = |plane: &[u8]| [0, 1, 2].map(|channel| f64::from(plane[at * 3 + channel]));
        let stride = harmonics.len();
        for (place, color) in harmonics.iter_mut().enumerate() {
            let stored = &coefficients[(at * stride + place) * 3..][..3];
            *color = Vec3::from([0, 1, 2].map(|channel| (f32::from(stored[channel]) - 128.0) / 128.0));
        }
        self.frame.turn_harmonics(harmonics);
        Splat {
            center: self.frame.position(self.position(at)),
            extents: DVec3::from(three(scales).map(|byte| (byte / 16.0 - 10.0).exp())),
            rotation: self.frame.rotation(self.rotation(at)),
            base: from_coefficient(DVec3::from(three(colors).map(|byte| (byte / 255.0 - 0.5) / COLOR))),
            linear: false,
            alpha: f64::from(alphas[at]) / 255.0,
        }
    }

    fn position(&self, at: usize) -> DVec3 {
        let plane = &self.planes[0];
        DVec3::from([0, 1, 2].map(|axis| {
            let place = at * 3 + axis;
            if self.version == 1 {
                return half(plane, place * 2);
            }
            let bytes = &plane[place * 3..][..3];
            // The uppermost byte holds the sign.
            f64::from(i32::from_le_bytes([0, bytes[0], bytes[1], bytes[2]]) >> 8) * self.step
        }))
    }

    fn rotation(&self, at: usize) -> DQuat {
        let plane = &self.planes[4];
        let [x, y, z, w] = if self.version < 3 {
            let [x, y, z] = [0, 1, 2].map(|part| f64::from(plane[at * 3 + part]) / 127.5 - 1.0);
            [x, y, z, (1.0 - (x * x + y * y + z * z)).max(0.0).sqrt()]
        } else {
            smallest_three(word(plane, at * 4))
        };
        DQuat::from_xyzw(x, y, z, w)
    }
}

/// x, y, z and w: the two upper bits tell the largest, the others have a sign and nine bits each.
fn smallest_three(word: u32) -> [f64; 4] {
    let largest = (word >> 30) as usize;
    let (mut rest, mut parts, mut squares) = (word, [0.0; 4], 0.0);
    for at in (0..4).rev().filter(|at| *at != largest) {
        let size = f64::from(rest & 511) / 511.0 * FRAC_1_SQRT_2;
        parts[at] = if rest >> 9 & 1 == 1 { -size } else { size };
        squares += size * size;
        rest >>= 10;
    }
    parts[largest] = f64::max(1.0 - squares, 0.0).sqrt();
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_part_is_left_out() {
        // 01: y is the largest; from the low end w = 511/511/√2, z = 0, x = −256/511/√2.
        let word = 1 << 30 | (512 + 256) << 20 | 511;
        let [x, y, z, w] = smallest_three(word);
        assert!((w - FRAC_1_SQRT_2).abs() < 1e-15 && z == 0.0);
        assert!((x + 256.0 / 511.0 * FRAC_1_SQRT_2).abs() < 1e-15);
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-15 && y > 0.0);
    }
}
