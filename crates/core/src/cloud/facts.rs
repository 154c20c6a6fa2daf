//! Facts about all points of a cloud together.

use glam::Vec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::gaussians::{ByDegree, Gaussians, reach};
use super::{Bounds, Cloud};

/// Facts about a cloud, or about a part of one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Number of points.
    pub points: u64,
    /// The box of the points; `None` without points.
    pub bounds: Option<Bounds>,
    /// Bits of the classes: set for those that points have.
    classes: [u64; 4],
    /// `true` if all colors are black; and if there are none.
    pub all_black: bool,
    /// `true` if all colors are white; and if there are none.
    pub all_white: bool,
    /// `true` if any intensity isn't 0.
    pub has_intensity: bool,
    /// `true` if any point has a normal.
    pub has_normals: bool,
    /// `true` if any point of a cloud with normals has none.
    pub lacks_normals: bool,
    /// `true` if any alpha is below 1.
    pub is_transparent: bool,
    /// The largest component of a color, linear; 0 without colors.
    pub brightest: f32,
    /// The largest radius that a point has; of a Gaussian how far it reaches; 0 without radii.
    pub largest_radius: f32,
    /// Bounds on the display values of Gaussians by the degree that is drawn ([`Gaussians::brightest`]); 0 without any.
    #[serde(default)]
    pub brightest_splats: ByDegree,
}

impl Default for Facts {
    fn default() -> Self {
        Self {
            points: 0,
            bounds: None,
            classes: [0; 4],
            all_black: true,
            all_white: true,
            has_intensity: false,
            has_normals: false,
            lacks_normals: false,
            is_transparent: false,
            brightest: 0.0,
            largest_radius: 0.0,
            brightest_splats: ByDegree::default(),
        }
    }
}

impl Facts {
    /// Returns those of some points.
    pub fn of(cloud: &Cloud) -> Self {
        let mut classes = [0; 4];
        for code in cloud.classification.iter().flatten() {
            classes[usize::from(code >> 6)] |= 1 << (code & 63);
        }
        let colors = || cloud.colors.par_iter().flatten();
        let normals = || cloud.normals.par_iter().flatten();
        let reaches = cloud.gaussians.iter().flat_map(|all| &all.extents).map(|extents| reach(*extents));
        Self {
            points: cloud.len() as u64,
            bounds: cloud.bounds(),
            classes,
            all_black: colors().all(|color| *color == Vec3::ZERO),
            all_white: colors().all(|color| *color == Vec3::ONE),
            has_intensity: cloud.intensity.iter().flatten().any(|value| *value != 0.0),
            has_normals: normals().any(|normal| *normal != Vec3::ZERO),
            lacks_normals: normals().any(|normal| *normal == Vec3::ZERO),
            is_transparent: cloud.alphas.iter().flatten().any(|alpha| *alpha < 1.0),
            brightest: colors().map(|color| color.max_element()).reduce(|| 0.0, f32::max),
            largest_radius: cloud.radii.iter().flatten().copied().chain(reaches).fold(0.0, f32::max),
            brightest_splats: cloud.gaussians.as_ref().map(Gaussians::brightest).unwrap_or_default(),
        }
    }

    /// Returns those of two parts together.
    #[must_use]
    pub fn and(self, other: &Self) -> Self {
        Self {
            points: self.points + other.points,
            bounds: [self.bounds, other.bounds].into_iter().flatten().reduce(Bounds::union),
            classes: std::array::from_fn(|i| self.classes[i] | other.classes[i]),
            all_black: self.all_black && other.all_black,
            all_white: self.all_white && other.all_white,
            has_intensity: self.has_intensity || other.has_intensity,
            has_normals: self.has_normals || other.has_normals,
            lacks_normals: self.lacks_normals || other.lacks_normals,
            is_transparent: self.is_transparent || other.is_transparent,
            brightest: self.brightest.max(other.brightest),
            largest_radius: self.largest_radius.max(other.largest_radius),
            brightest_splats: std::array::from_fn(|degree| {
                self.brightest_splats[degree].max(other.brightest_splats[degree])
            }),
        }
    }

    /// Returns `true` if points have a class.
    pub fn has_class(&self, code: u8) -> bool {
        self.classes[usize::from(code >> 6)] >> (code & 63) & 1 == 1
    }

    /// Returns `true` for colors of which nothing can be seen: all black, or all white.
    pub fn is_blank(&self) -> bool {
        self.all_black || self.all_white
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn facts_of_parts_are_those_of_the_whole() {
        let cloud = Cloud {
            positions: [1.0, 5.0, 3.0].map(DVec3::splat).to_vec(),
            colors: Some(vec![Vec3::ZERO, Vec3::ZERO, Vec3::ONE]),
            normals: Some(vec![Vec3::ZERO, Vec3::X, Vec3::X]),
            classification: Some(vec![2, 255, 64]),
            intensity: Some(vec![0.0, 0.0, 3.0]),
            alphas: Some(vec![1.0, 0.5, 1.0]),
            radii: Some(vec![0.25, 0.5, 0.125]),
            ..Cloud::default()
        };
        let whole = Facts::of(&cloud);
        let classes: Vec<u8> = (0..=255).filter(|code| whole.has_class(*code)).collect();
        assert_eq!(classes, [2, 64, 255]);
        assert_eq!(whole.bounds, Some(Bounds { min: DVec3::ONE, max: DVec3::splat(5.0) }));
        assert!(!whole.is_blank() && whole.has_intensity && whole.is_transparent);
        assert!(whole.has_normals && whole.lacks_normals && whole.largest_radius == 0.5);
        for part in 0..=3 {
            let [first, rest] = [0..part, part..3].map(|range| Facts::of(&cloud.subset(&range.collect::<Vec<_>>())));
            assert_eq!(first.clone().and(&rest), whole, "{part}");
            assert_eq!(rest.and(&first), whole, "{part}");
        }
        let splats = Gaussians { extents: vec![Vec3::new(1.0, 3.0, 0.0)], ..Gaussians::none(1) };
        let splat = Cloud { positions: vec![DVec3::ZERO], gaussians: Some(splats), ..Cloud::default() };
        assert_eq!(Facts::of(&splat).largest_radius, reach(Vec3::splat(3.0)));
        let dark = Facts::of(&cloud.subset(&[0]));
        assert!(dark.is_blank() && !dark.has_intensity && !dark.is_transparent && !dark.has_normals);
    }
}
