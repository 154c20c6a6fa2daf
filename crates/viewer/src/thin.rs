//! One of so many points of a scene on the device, for coarser pictures.

use pellucid_engine::methods::soft::SoftModel;
use pellucid_engine::methods::{Error, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::Points;
use pellucid_engine::scene::{Density, Method, Soft};

/// Some of a scene's points, with the radii that they have there.
pub struct Thin {
    one_of: usize,
    cloud: DeviceCloud,
}

impl Thin {
    /// One of each `one_of` points, taken from `kept` if it has these; the rest of what was kept is freed first.
    ///
    /// # Errors
    /// No memory for them.
    pub fn of<'a>(
        kept: &'a mut Option<Self>,
        renderer: &Renderer,
        points: &Points,
        one_of: usize,
    ) -> Result<&'a mut DeviceCloud, Error> {
        if kept.as_ref().is_none_or(|thin| thin.one_of != one_of) {
            *kept = None;
            let cloud = renderer.upload(&points.subset(&places(points.len(), one_of), 1.0))?;
            *kept = Some(Self { one_of, cloud });
        }
        Ok(kept.as_mut().map(|thin| &mut thin.cloud).expect("made above"))
    }
}

/// Places of one of each so many points, the middle one. Points stand along a curve through space (Morton), so that these lie evenly
/// among them.
fn places(count: usize, one_of: usize) -> Vec<u32> {
    // Places of points on a device are 32-bit numbers.
    (0..count.div_ceil(one_of)).map(|i| (i * one_of + one_of / 2).min(count - 1) as u32).collect()
}

/// A method for radii that are larger by a factor: as dense as `median_radius` makes it for the radii as they were, where the scene
/// gives a factor λ on lengths.
pub fn as_dense(method: Method, median_radius: f32) -> Method {
    let with = |soft: Soft| {
        let peak = SoftModel::new(&method, &soft, median_radius).peak;
        Soft { density: Density::Softness(peak), ..soft }
    };
    match method {
        Method::SoftBase(soft) => Method::SoftBase(with(soft)),
        Method::SoftConcentric(soft) => Method::SoftConcentric(with(soft)),
        Method::SoftExpress(soft) => Method::SoftExpress(with(soft)),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_evenly() {
        assert_eq!(places(10, 4), [2, 6, 9]);
        assert_eq!(places(3, 1), [0, 1, 2]);
        assert_eq!(places(1, 64), [0]);
        assert_eq!(places(0, 4), [0u32; 0]);
    }

    #[test]
    fn larger_spheres_are_as_dense() {
        for method in [Method::SoftBase, Method::SoftConcentric, Method::SoftExpress] {
            let given = method(Soft { density: Density::Lambda(0.7), ..Soft::default() });
            let dense = as_dense(given, 0.3);
            let peak = |method: &Method, radius| SoftModel::new(method, method.soft().unwrap(), radius).peak;
            assert!((peak(&dense, 0.6) - peak(&given, 0.3)).abs() < 1e-6, "{given:?}");
        }
        assert_eq!(as_dense(Method::Points, 1.0), Method::Points);
    }
}
