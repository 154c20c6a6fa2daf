//! A regular subset of a scene's points on the device, for coarser pictures.

use pellucid_core::points::Points;
use pellucid_engine::methods::soft::SoftModel;
use pellucid_engine::methods::{Error, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::{Density, Method, Soft};

/// A subset of a scene's points, with their original radii.
pub struct ThinnedCloud {
    one_of: usize,
    cloud: DeviceCloud,
}

impl ThinnedCloud {
    /// Uploads every `one_of`-th point, or reuses `kept` if it holds that subset; any other subset is freed first.
    ///
    /// # Errors
    /// Returns an error if device memory is lacking.
    pub fn reuse_or_upload<'a>(
        kept: &'a mut Option<Self>,
        renderer: &Renderer,
        points: &Points,
        one_of: usize,
    ) -> Result<&'a mut DeviceCloud, Error> {
        if kept.as_ref().is_none_or(|thinned| thinned.one_of != one_of) {
            *kept = None;
            let cloud = renderer.upload(&points.subset(&places(points.len(), one_of), 1.0))?;
            *kept = Some(Self { one_of, cloud });
        }
        Ok(kept.as_mut().map(|thinned| &mut thinned.cloud).expect("made above"))
    }
}

/// Indices of every `one_of`-th point, the middle one of each group. Points are in Morton order, so the subset is
/// spread evenly among them.
fn places(count: usize, one_of: usize) -> Vec<u32> {
    // Point indices on a device have 32 bits.
    (0..count.div_ceil(one_of)).map(|i| (i * one_of + one_of / 2).min(count - 1) as u32).collect()
}

/// A method for enlarged radii. Where the scene gives the density as a factor λ on lengths, the result keeps the
/// density that `median_radius` gave the original radii.
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
