//! A list of painted surfaces and the solids it is built from.

use glam::DVec3;

use super::paint::Paint;
use super::shape::PatchShape;

/// LAS classes (ASPRS), and one of the range free for users.
pub(super) mod class {
    pub(in super::super) const GROUND: u8 = 2;
    pub(in super::super) const LOW_VEGETATION: u8 = 3;
    pub(in super::super) const MEDIUM_VEGETATION: u8 = 4;
    pub(in super::super) const HIGH_VEGETATION: u8 = 5;
    pub(in super::super) const BUILDING: u8 = 6;
    pub(in super::super) const NOISE: u8 = 7;
    pub(in super::super) const FURNITURE: u8 = 64;
}

/// A surface with its look and class.
#[derive(Clone)]
pub(super) struct Patch {
    pub(super) shape: PatchShape,
    pub(super) paint: Paint,
    pub(super) class: u8,
    /// Points per area against other surfaces of the cloud.
    pub(super) weight: f64,
}

/// Surfaces of one class in the making.
pub(super) struct Model {
    pub(super) patches: Vec<Patch>,
    class: u8,
}

impl Model {
    pub(super) fn new(class: u8) -> Self {
        Self { patches: Vec::new(), class }
    }

    pub(super) fn add(&mut self, shape: PatchShape, paint: Paint) {
        self.add_weighted(shape, paint, 1.0);
    }

    pub(super) fn add_weighted(&mut self, shape: PatchShape, paint: Paint, weight: f64) {
        self.patches.push(Patch { shape, paint, class: self.class, weight });
    }

    /// Puts another model in, turned about the vertical by a fraction of a full turn and moved.
    pub(super) fn place(&mut self, other: &Model, turn: f64, x: f64, y: f64, z: f64) {
        let by = DVec3::new(x, y, z);
        self.patches.extend(other.patches.iter().map(|p| Patch { shape: p.shape.moved(turn, by), ..p.clone() }));
    }

    pub(super) fn quad(&mut self, corner: DVec3, u: DVec3, v: DVec3, paint: Paint) {
        self.add(PatchShape::Quad { corner, u, v }, paint);
    }

    /// A block with its three half edges (right-handed).
    pub(super) fn block(&mut self, center: DVec3, [a, b, c]: [DVec3; 3], paint: Paint) {
        for (n, u, v) in [(a, b, c), (b, c, a), (c, a, b)] {
            self.quad(center + n - u - v, 2.0 * u, 2.0 * v, paint);
            self.quad(center - n - u - v, 2.0 * v, 2.0 * u, paint);
        }
    }

    /// An upright box from its lowest to its highest corner, without the underside that no scanner sees.
    pub(super) fn cuboid(&mut self, low: [f64; 3], high: [f64; 3], paint: Paint) {
        let (low, high) = (DVec3::from_array(low), DVec3::from_array(high));
        let size = high - low;
        let (x, y, z) = (size.x * DVec3::X, size.y * DVec3::Y, size.z * DVec3::Z);
        for (corner, u, v) in [(low + z, x, y), (low, x, z), (low + x, y, z), (high - z, -x, z), (low + y, -y, z)] {
            self.quad(corner, u, v, paint);
        }
    }

    /// A beam of square section along a segment; one face looks to `side` as far as the segment allows.
    pub(super) fn beam(&mut self, from: DVec3, to: DVec3, width: f64, side: DVec3, paint: Paint) {
        let axis = (to - from).normalize_or(DVec3::Z);
        let b = side.reject_from(axis).normalize_or(axis.any_orthonormal_vector());
        let c = axis.cross(b);
        self.block(0.5 * (from + to), [0.5 * (to - from), 0.5 * width * b, 0.5 * width * c], paint);
    }

    pub(super) fn tube(&mut self, from: [f64; 3], to: [f64; 3], radii: [f64; 2], paint: Paint) {
        self.add(PatchShape::Tube { from: DVec3::from_array(from), to: DVec3::from_array(to), radii }, paint);
    }

    pub(super) fn ball(&mut self, center: [f64; 3], semi: [f64; 3], paint: Paint) {
        self.add(PatchShape::Ball { center: DVec3::from_array(center), semi: DVec3::from_array(semi) }, paint);
    }

    /// A level disc that looks up.
    pub(super) fn disc(&mut self, center: [f64; 3], radius: f64, paint: Paint) {
        let [x, y, z] = center;
        self.tube([x, y, z], [x, y, z + 1e-3], [radius, 0.0], paint);
    }
}
