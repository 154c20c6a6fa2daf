//! Surfaces of the garden: each maps the unit square onto itself, area-preserving except for balls that are not round.

use glam::DVec3;

use super::super::random::{Random, unit_circle};

/// A piece of surface, in meters.
#[derive(Clone)]
pub(super) enum PatchShape {
    /// A parallelogram; the normal is u × v.
    Quad { corner: DVec3, u: DVec3, v: DVec3 },
    /// Half of that: corner, corner + u, corner + v.
    Triangle { corner: DVec3, u: DVec3, v: DVec3 },
    /// A cone's frustum without caps.
    Tube { from: DVec3, to: DVec3, radii: [f64; 2] },
    /// An ellipsoid with axes along x, y and z.
    Ball { center: DVec3, semi: DVec3 },
    /// Leaves inside such an ellipsoid, denser toward its outside.
    Leaves { center: DVec3, semi: DVec3 },
    /// Leaves in the outer decimeters of a box.
    Hedge { center: DVec3, half: DVec3 },
}

/// A place on a surface.
pub(super) struct PatchPoint {
    pub(super) position: DVec3,
    pub(super) normal: DVec3,
    /// Depth inside foliage, from 0 outside to 1.
    pub(super) depth: f64,
}

/// Leaf area over the area of a hull around the leaves.
const LEAF_AREA: f64 = 2.0;

impl PatchShape {
    /// Square meters.
    pub(super) fn area(&self) -> f64 {
        let [u, v] = self.lengths();
        match self {
            Self::Quad { u, v, .. } => u.cross(*v).length(),
            Self::Triangle { u, v, .. } => 0.5 * u.cross(*v).length(),
            Self::Leaves { .. } => LEAF_AREA * u * v,
            Self::Hedge { half, .. } => LEAF_AREA * 4.0 * (half.x * half.y + half.z * (half.x + half.y)),
            Self::Tube { .. } | Self::Ball { .. } => u * v,
        }
    }

    /// Meters over which the unit square's sides are spread.
    pub(super) fn lengths(&self) -> [f64; 2] {
        use std::f64::consts::{PI, TAU};
        match self {
            Self::Quad { u, v, .. } | Self::Triangle { u, v, .. } => [u.length(), v.length()],
            Self::Tube { from, to, radii } => [PI * (radii[0] + radii[1]), (*to - *from).length()],
            Self::Ball { semi, .. } | Self::Leaves { semi, .. } => {
                let r = ((semi.x * semi.y + semi.y * semi.z + semi.z * semi.x) / 3.0).sqrt();
                [TAU * r, 2.0 * r]
            }
            Self::Hedge { half, .. } => [2.0 * half.x.max(half.y), 2.0 * half.z],
        }
    }

    /// Returns the position of (s, t) in the unit square; `None` for the half of it that a triangle leaves out.
    pub(super) fn at(&self, s: f64, t: f64, random: &mut Random) -> Option<PatchPoint> {
        let surface =
            |position, normal: DVec3| PatchPoint { position, normal: normal.normalize_or(DVec3::Z), depth: 0.0 };
        match *self {
            Self::Quad { corner, u, v } => Some(surface(corner + s * u + t * v, u.cross(v))),
            Self::Triangle { corner, u, v } => (s + t <= 1.0).then(|| surface(corner + s * u + t * v, u.cross(v))),
            Self::Tube { from, to, radii: [r0, r1] } => {
                let r = (r0 * r0 + t * (r1 * r1 - r0 * r0)).sqrt();
                let along = if (r1 - r0).abs() < 1e-6 { t } else { (r - r0) / (r1 - r0) };
                let axis = (to - from).normalize_or(DVec3::Z);
                let (side, other) = axis.any_orthonormal_pair();
                let (cos, sin) = unit_circle(s);
                let out = cos * side + sin * other;
                Some(surface(from + along * (to - from) + r * out, out + axis * ((r0 - r1) / (to - from).length())))
            }
            Self::Ball { center, semi } => {
                let out = on_sphere(s, t);
                Some(surface(center + semi * out, out / semi))
            }
            Self::Leaves { center, semi } => {
                let out = on_sphere(s, t);
                // The largest of two uniform numbers favors the outside.
                let r = 0.25 + 0.75 * random.unit().max(random.unit());
                let normal = (out / semi).normalize_or(DVec3::Z) + 0.8 * random.direction();
                let normal = normal.normalize_or(DVec3::Z);
                Some(PatchPoint { position: center + semi * out * r, normal, depth: 1.0 - r })
            }
            Self::Hedge { center, half } => {
                let q = DVec3::from_array(std::array::from_fn(|_| random.range(-1.0, 1.0)));
                let gap = half * (DVec3::ONE - q.abs());
                let inward = gap.x.min(gap.y).min(gap.z);
                let out = DVec3::select(gap.cmple(DVec3::splat(inward)), q.signum(), DVec3::ZERO);
                let normal = (out + 0.7 * random.direction()).normalize_or(DVec3::Z);
                let position = center + half * q + 0.05 * random.direction();
                (inward < 0.18).then_some(PatchPoint { position, normal, depth: inward / 0.3 })
            }
        }
    }

    /// Turned about the vertical through the origin by a fraction of a full turn, then moved.
    pub(super) fn moved(&self, turn: f64, by: DVec3) -> Self {
        let (cos, sin) = unit_circle(turn);
        let rotate = |p: DVec3| DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
        match *self {
            Self::Quad { corner, u, v } => Self::Quad { corner: by + rotate(corner), u: rotate(u), v: rotate(v) },
            Self::Triangle { corner, u, v } => {
                Self::Triangle { corner: by + rotate(corner), u: rotate(u), v: rotate(v) }
            }
            Self::Tube { from, to, radii } => Self::Tube { from: by + rotate(from), to: by + rotate(to), radii },
            Self::Ball { center, semi } => Self::Ball { center: by + rotate(center), semi: rotate(semi).abs() },
            Self::Leaves { center, semi } => Self::Leaves { center: by + rotate(center), semi: rotate(semi).abs() },
            Self::Hedge { center, half } => Self::Hedge { center: by + rotate(center), half: rotate(half).abs() },
        }
    }
}

fn on_sphere(s: f64, t: f64) -> DVec3 {
    let z = 2.0 * t - 1.0;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (cos, sin) = unit_circle(s);
    DVec3::new(r * cos, r * sin, z)
}
