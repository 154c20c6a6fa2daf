//! Radii of sparse clouds in pictures that are to be seen through. By Eq. 20 each place is covered by about four discs,
//! however large these are: where points are few, a picture of faint discs shows nothing but blobs.

use glam::DVec3;
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;

/// Most points of a sparse cloud.
const MOST: u64 = 12_000;
/// The median radius up to which discs merge into a surface, as a share of the image's height.
const FINE: f64 = 1.0 / 160.0;
/// The least factor: discs of about half the distance between neighbors, which hardly overlap.
const LEAST: f64 = 0.45;

/// Returns the factor on the radii with which the discs of a sparse cloud stay apart that are large in a picture of
/// this height; 1 of those that are not, and of clouds with more than 12 000 points. It follows from the median radius
/// of the drawn points before the camera, whatever their order.
pub(crate) fn radius_factor(points: &Points, camera: &Camera, height: u32) -> f32 {
    if points.count() > MOST {
        return 1.0;
    }
    let share = |(position, radius): (&DVec3, &f32)| {
        let z = camera.to_view(*position).z;
        let is_seen = z >= camera.near && z <= camera.far;
        is_seen.then(|| f64::from(*radius) * camera.pixels_per_unit(z, height) / f64::from(height))
    };
    let mut shares: Vec<f64> = points.positions.iter().zip(&points.radii).filter_map(share).collect();
    let Some(middle) = shares.len().checked_sub(1).map(|last| last / 2) else { return 1.0 };
    let median = *shares.select_nth_unstable_by(middle, f64::total_cmp).1;
    if median > FINE { (FINE / median).max(LEAST) as f32 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::camera::Projection;

    /// Points with these radii at a distance of 10, whose image shows 10 world units over its height.
    fn factor(radii: Vec<f32>, height: u32) -> f32 {
        let positions = (0..radii.len()).map(|i| DVec3::new(i as f64 * 1e-3, 0.0, -10.0)).collect();
        let points = Points { positions, radii, ..Points::default() };
        let projection = Projection::Orthographic { height: 10.0 };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, projection, 1.0, 20.0).unwrap();
        radius_factor(&points, &camera, height)
    }

    #[test]
    fn large_discs_of_sparse_clouds_shrink_and_small_ones_stay() {
        // A radius of 10/160 is a hundred-and-sixtieth of the height.
        for height in [360, 1024] {
            assert_eq!(factor(vec![0.06; 9], height), 1.0);
            assert_eq!(factor(vec![0.125; 9], height), 0.5);
            assert_eq!(factor(vec![5.0; 9], height), 0.45);
        }
        // The median counts, in any order.
        assert_eq!(factor(vec![0.01, 9.0, 0.125, 0.125, 0.2], 100), 0.5);
        assert_eq!(factor(vec![0.125, 0.2, 0.125, 0.01, 9.0], 100), 0.5);
        assert_eq!(factor(vec![], 100), 1.0);
        assert_eq!(factor(vec![5.0; 12_001], 100), 1.0, "many points");
    }
}
