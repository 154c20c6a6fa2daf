//! The points of a scene, and fewer of them.

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use pellucid_core::points::Points;
use pellucid_engine::methods::{Error, Renderer, Upload};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::Detail;
use pellucid_scene::prepare::Arranged;

/// A scene's points on the device, all or some of them; one cloud at a time, so that a frame's memory is its own.
pub(in super::super) struct Clouds<'a> {
    arranged: &'a Arranged,
    thinned: BTreeMap<u32, Points>,
    on_device: Option<(u32, Detail, DeviceCloud)>,
}

impl<'a> Clouds<'a> {
    /// Prepares the thinned clouds; 1 stands for the complete cloud, which always exists.
    pub fn new(arranged: &'a Arranged, thinning: &[u32], seed: u64) -> Self {
        let thinned = if thinning.iter().any(|one_of| *one_of > 1) {
            thinned(arranged.points(), thinning, seed)
        } else {
            BTreeMap::new()
        };
        Self { arranged, thinned, on_device: None }
    }

    /// The number of points that remain with this thinning.
    pub fn len(&self, thinning: u32) -> u64 {
        self.thinned.get(&thinning).unwrap_or(self.arranged.points()).len() as u64
    }

    /// True if those points are on the device, and were drawn with this detail.
    pub fn are_on_device(&self, thinning: u32, detail: &Detail) -> bool {
        self.on_device.as_ref().is_some_and(|(there, drawn, _)| (*there, drawn) == (thinning, detail))
    }

    /// Takes everything off the device, what was found for the points included.
    pub fn forget(&mut self) {
        self.on_device = None;
    }

    /// Returns those points on the device, for frames with this detail, and uploads them if needed.
    ///
    /// # Errors
    /// Uploading fails.
    pub fn on_device(
        &mut self,
        renderer: &Renderer,
        thinning: u32,
        detail: &Detail,
    ) -> Result<&mut DeviceCloud, Error> {
        // Points that come some at a time serve every detail, but for all of them.
        let serves = |there: u32, drawn: &Detail| there == thinning && drawn.is_whole() == detail.is_whole();
        if !self.on_device.as_ref().is_some_and(|(there, drawn, _)| serves(*there, drawn)) {
            // The memory of the others first.
            self.on_device = None;
            let cloud = match self.thinned.get(&thinning) {
                Some(points) => renderer.upload(points)?,
                None => renderer.upload(Upload::with_detail(self.arranged, detail))?,
            };
            self.on_device = Some((thinning, *detail, cloud));
        }
        let (_, drawn, cloud) = self.on_device.as_mut().expect("uploaded above");
        *drawn = *detail;
        Ok(cloud)
    }
}

/// Random subsets with every n-th point on average; each thinner cloud is a subset of the denser ones. Radii grow as
/// the inverse root of the share, as the distance to the K-th neighbor (Eq. 20) does on a surface.
fn thinned(points: &Points, thinning: &[u32], seed: u64) -> BTreeMap<u32, Points> {
    // Places of points on a device are 32-bit numbers.
    let mut places: Vec<u32> = (0..points.len() as u32).collect();
    places.shuffle(&mut Pcg64::seed_from_u64(seed));
    let cloud = |one_of: u32| {
        let count = places.len().div_ceil(one_of as usize);
        let mut chosen = places[..count].to_vec();
        // In the order of the scene's points, which keeps neighbors together.
        chosen.sort_unstable();
        let factor = (places.len() as f64 / count.max(1) as f64).sqrt();
        (one_of, points.subset(&chosen, factor as f32))
    };
    thinning.iter().copied().filter(|one_of| *one_of > 1).map(cloud).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    fn line(count: usize) -> Points {
        Points {
            positions: (0..count).map(|i| DVec3::new(i as f64, 0.0, 0.0)).collect(),
            colors: vec![Vec3::ONE; count],
            opacities: vec![1.0; count],
            radii: (0..count).map(|i| i as f32).collect(),
            ..Points::default()
        }
    }

    #[test]
    fn thinner_clouds_are_part_of_denser_ones() {
        let points = line(1000);
        let clouds = thinned(&points, &[1, 4, 16], 3);
        let [quarter, sixteenth] = [&clouds[&4], &clouds[&16]];
        assert_eq!((clouds.len(), quarter.len(), sixteenth.len()), (2, 250, 63));
        let x = |points: &Points| points.positions.iter().map(|p| p.x).collect::<Vec<_>>();
        assert!(x(sixteenth).iter().all(|place| x(quarter).contains(place)));
        assert!(x(quarter).is_sorted() && x(sixteenth).is_sorted());
        // Twice the radius for a quarter of the points; √(1000/63) for 63.
        assert!(quarter.positions.iter().zip(&quarter.radii).all(|(p, r)| *r == 2.0 * p.x as f32));
        let factor = (1000.0f32 / 63.0).sqrt();
        assert!(sixteenth.positions.iter().zip(&sixteenth.radii).all(|(p, r)| (r - factor * p.x as f32).abs() < 1e-2));
        assert_eq!((quarter.normals.is_none(), quarter.colors.len(), quarter.fields.len()), (true, 250, 0));
        // Random, neither the first quarter nor every fourth: 250 of 1000 with a standard error of 6.9 in the first
        // half.
        let low = x(quarter).iter().filter(|place| **place < 500.0).count();
        assert!((90..160).contains(&low), "{low}");
        assert_eq!(thinned(&points, &[4], 3)[&4], *quarter, "the same by the same seed");
        assert_ne!(thinned(&points, &[4], 4)[&4], *quarter);
    }

    #[test]
    fn of_few_points_one_is_left() {
        let clouds = thinned(&line(2), &[1, 4, 16], 0);
        assert!(clouds.values().all(|points| points.len() == 1));
        assert_eq!(thinned(&Points::default(), &[4], 0)[&4].len(), 0);
    }
}
