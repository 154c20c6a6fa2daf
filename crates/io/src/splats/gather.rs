//! Splats as formats give them, made into the columns of a cloud.

use glam::{DQuat, DVec3, Quat, Vec3};

use crate::columns::taken;
use pellucid_core::cloud::gaussians::{ColorCoding, Gaussians, Y0, coefficients};
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::parallel;
use pellucid_core::progress::Progress;

/// Splats that a thread decodes at a time.
const RUN: usize = 1 << 14;

/// The end of the warning about splats that are none.
const LEFT_OUT: &str = "splats are left out: each has a number that is not finite, no axes, or no extent";

/// A splat as a file gives it. Any number may be one that no splat has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Splat {
    pub center: DVec3,
    /// Standard deviations along the three axes; a sign means nothing.
    pub extents: DVec3,
    /// Rotation, a quaternion of any length but zero.
    pub rotation: DQuat,
    /// Color without harmonics of higher degree.
    pub base: DVec3,
    /// `true` if the color and the harmonics are linear instead of display values.
    pub linear: bool,
    /// Opacity; values beyond 0 and 1 count as these.
    pub alpha: f64,
}

/// Returns the color of coefficients of degree 0.
pub(crate) fn from_coefficient(coefficient: DVec3) -> DVec3 {
    coefficient * Y0 + 0.5
}

/// Returns a unit quaternion of three of its parts and the place of the fourth, the largest, among w, x, y and z.
pub(crate) fn quaternion(largest: u32, [a, b, c]: [f64; 3]) -> DQuat {
    let rest = (1.0 - (a * a + b * b + c * c)).max(0.0).sqrt();
    let [w, x, y, z] = match largest {
        0 => [rest, a, b, c],
        1 => [a, rest, b, c],
        2 => [a, b, rest, c],
        _ => [a, b, c, rest],
    };
    DQuat::from_xyzw(x, y, z, w)
}

/// Columns of splats that grow.
#[derive(Debug, Default)]
pub(crate) struct Splats {
    positions: Vec<DVec3>,
    alphas: Vec<f32>,
    /// Without the meaning of their colors.
    gaussians: Gaussians,
    /// `true` of splats of linear colors.
    linear: Vec<bool>,
    /// Splats left out because their center is not finite.
    without_center: usize,
    /// Splats left out for another reason.
    odd: usize,
}

impl Splats {
    /// No splats, with room for some.
    pub fn new(degree: u32, room: usize) -> Self {
        Self {
            positions: Vec::with_capacity(room),
            alphas: Vec::with_capacity(room),
            gaussians: Gaussians {
                extents: Vec::with_capacity(room),
                rotations: Vec::with_capacity(room),
                bases: Vec::with_capacity(room),
                coding: ColorCoding::Display,
                degree,
                harmonics: Vec::with_capacity(room * coefficients(degree)),
            },
            linear: Vec::with_capacity(room),
            without_center: 0,
            odd: 0,
        }
    }

    /// Returns the number of bytes of a splat in the columns of a cloud.
    pub fn bytes(degree: u32) -> u64 {
        let own = size_of::<DVec3>() + size_of::<f32>() + size_of::<bool>() + 3 * size_of::<Vec3>() + size_of::<Quat>();
        (own + coefficients(degree) * size_of::<Vec3>()) as u64
    }

    /// Returns splats of a degree, each decoded by its number on all cores. `splat` also writes the harmonics, which
    /// are zero before.
    pub fn gather(
        count: usize,
        degree: u32,
        progress: &Progress,
        splat: impl Fn(usize, &mut [Vec3]) -> Splat + Sync,
    ) -> Self {
        progress.set_length(count as u64);
        let run = |first: usize| {
            let end = count.min(first + RUN);
            let mut some = Self::new(degree, end - first);
            let mut harmonics = vec![Vec3::ZERO; coefficients(degree)];
            for at in first..end {
                harmonics.fill(Vec3::ZERO);
                let splat = splat(at, &mut harmonics);
                some.push(&splat, &harmonics);
            }
            progress.inc((end - first) as u64);
            some
        };
        Self::join(degree, parallel::gather(count.div_ceil(RUN), |at| run(at * RUN)))
    }

    /// Adds a splat with as many harmonics as the degree has; false if it is none, and was counted instead.
    pub fn push(&mut self, splat: &Splat, harmonics: &[Vec3]) -> bool {
        if !splat.center.is_finite() {
            self.without_center += 1;
            return false;
        }
        let base = splat.base.as_vec3();
        let shape = extents(splat.extents).zip(rotation(splat.rotation));
        let shape = shape.filter(|_| base.is_finite() && harmonics.iter().all(|color| color.is_finite()));
        let Some((extents, rotation)) = shape.filter(|_| !splat.alpha.is_nan()) else {
            self.odd += 1;
            return false;
        };
        self.positions.push(splat.center);
        self.alphas.push(splat.alpha.clamp(0.0, 1.0) as f32);
        self.gaussians.extents.push(extents);
        self.gaussians.rotations.push(rotation);
        self.gaussians.bases.push(base);
        self.linear.push(splat.linear);
        self.gaussians.harmonics.extend_from_slice(harmonics);
        true
    }

    /// Parts of the same degree, one behind the other. Each column of the parts is gone once it is joined.
    pub fn join(degree: u32, mut parts: Vec<Self>) -> Self {
        Self {
            without_center: parts.iter().map(|part| part.without_center).sum(),
            odd: parts.iter().map(|part| part.odd).sum(),
            positions: taken(&mut parts, |part| &mut part.positions),
            alphas: taken(&mut parts, |part| &mut part.alphas),
            gaussians: Gaussians {
                extents: taken(&mut parts, |part| &mut part.gaussians.extents),
                rotations: taken(&mut parts, |part| &mut part.gaussians.rotations),
                bases: taken(&mut parts, |part| &mut part.gaussians.bases),
                coding: ColorCoding::Display,
                degree,
                harmonics: taken(&mut parts, |part| &mut part.gaussians.harmonics),
            },
            linear: parts.iter().flat_map(|part| &part.linear).copied().collect(),
        }
    }

    /// Returns the cloud of all of them.
    pub fn finish(self, up: UpAxis) -> Cloud {
        let warning = (self.odd > 0).then(|| left_out(self.odd as u64));
        let coding = if self.linear.contains(&true) { ColorCoding::of(self.linear) } else { ColorCoding::Display };
        let gaussians = Gaussians { coding, ..self.gaussians };
        Cloud {
            positions: self.positions,
            colors: Some(parallel::map(gaussians.len(), |i| gaussians.linear_base(i))),
            alphas: Some(self.alphas),
            gaussians: Some(gaussians),
            non_finite: self.without_center,
            up,
            warnings: warning.into_iter().collect(),
            ..Cloud::default()
        }
    }
}

/// Returns the warning that so many splats that have a center are left out.
pub(crate) fn left_out(count: u64) -> String {
    format!("{count} {LEFT_OUT}")
}

/// Returns the reason why splats of a cloud were left out that have a center.
pub(crate) fn reason(cloud: &Cloud) -> Option<&str> {
    cloud.warnings.iter().find(|warning| warning.ends_with(LEFT_OUT)).map(String::as_str)
}

/// Extents as a cloud has them, unless one is not finite there or all are zero.
fn extents(stored: DVec3) -> Option<Vec3> {
    let extents = stored.abs().as_vec3();
    (extents.is_finite() && extents != Vec3::ZERO).then_some(extents)
}

/// The unit quaternion of one, unless that is zero or not finite. Lengths of float64 are found without overflow.
fn rotation(stored: DQuat) -> Option<Quat> {
    let [x, y, z, w] = stored.to_array();
    let largest = x.abs().max(y.abs()).max(z.abs()).max(w.abs());
    let unit = (stored * (1.0 / largest)).normalize();
    (stored.is_finite() && largest > 0.0 && unit.is_finite()).then(|| unit.as_quat())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Splat = Splat {
        center: DVec3::ONE,
        extents: DVec3::ONE,
        rotation: DQuat::IDENTITY,
        base: DVec3::splat(0.5),
        linear: false,
        alpha: 0.5,
    };

    #[test]
    fn rows_that_are_no_splats_are_counted() {
        let nan = f64::NAN;
        let odd = [
            Splat { extents: DVec3::ZERO, ..PLAIN },
            Splat { extents: DVec3::new(1.0, nan, 1.0), ..PLAIN },
            Splat { extents: DVec3::new(1.0, 1e39, 1.0), ..PLAIN },
            Splat { extents: DVec3::splat(1e-60), ..PLAIN },
            Splat { rotation: DQuat::from_array([0.0; 4]), ..PLAIN },
            Splat { rotation: DQuat::from_array([0.0, f64::INFINITY, 0.0, 1.0]), ..PLAIN },
            Splat { base: DVec3::splat(1e39), ..PLAIN },
            Splat { alpha: nan, ..PLAIN },
        ];
        let mut splats = Splats::new(1, 0);
        let none = [Vec3::ZERO; 3];
        for splat in odd {
            assert!(!splats.push(&splat, &none), "{splat:?}");
        }
        assert!(!splats.push(&PLAIN, &[Vec3::ZERO, Vec3::NAN, Vec3::ZERO]));
        assert!(!splats.push(&Splat { center: DVec3::new(0.0, f64::INFINITY, 0.0), ..PLAIN }, &none));
        assert!(splats.push(&Splat { alpha: f64::INFINITY, extents: -DVec3::X, ..PLAIN }, &none));
        let cloud = splats.finish(UpAxis::NegativeY);
        assert_eq!((cloud.len(), cloud.non_finite, reason(&cloud)), (1, 1, Some(&*cloud.warnings[0])));
        assert_eq!(cloud.alphas, Some(vec![1.0]));
        assert!(cloud.warnings[0].starts_with("9 splats are left out"), "{:?}", cloud.warnings);
        assert_eq!(cloud.gaussians.unwrap().extents, [Vec3::X]);
    }

    #[test]
    fn quaternions_of_any_length_become_unit_ones() {
        for length in [1e-300, 1e-5, 1.0, 1e200] {
            let unit = rotation(DQuat::from_array([0.0, 3.0 * length, 0.0, 4.0 * length])).unwrap();
            assert!((unit.y - 0.6).abs() < 1e-7 && (unit.w - 0.8).abs() < 1e-7, "{length}: {unit}");
        }
    }

    #[test]
    fn splats_come_in_order_and_with_their_harmonics() {
        let count = 2 * RUN + 5;
        let splats = Splats::gather(count, 1, &Progress::hidden(), |at, harmonics| {
            harmonics[1] = Vec3::splat(at as f32);
            let center = if at % 7 == 3 { DVec3::NAN } else { DVec3::splat(at as f64) };
            Splat { center, ..PLAIN }
        });
        let cloud = splats.finish(UpAxis::Y);
        let gaussians = cloud.gaussians.unwrap();
        assert_eq!(cloud.positions.len() + cloud.non_finite, count);
        assert_eq!(gaussians.harmonics.len(), 3 * cloud.positions.len());
        for (at, position) in cloud.positions.iter().enumerate() {
            assert_eq!(gaussians.harmonics_of(at), [Vec3::ZERO, position.as_vec3(), Vec3::ZERO]);
        }
    }
}
