//! Points as they stand in a file: everything that methods of ensembles need of them.

use glam::{DVec3, Vec3};

use pellucid_core::parallel;
use pellucid_core::points::Points;

/// Layout of a point in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RecordLayout {
    /// `true` if points have normals.
    pub has_normals: bool,
}

/// Words without a normal: position, color, opacity, radius, id.
const WORDS: usize = 6 + 3 + 1 + 1 + 1;

impl RecordLayout {
    /// Words of 32 bits that a point takes.
    pub fn words(self) -> usize {
        if self.has_normals { WORDS + 3 } else { WORDS }
    }

    /// Puts a point with its id behind others.
    pub fn put(self, points: &Points, at: usize, id: u32, into: &mut Vec<u32>) {
        for coordinate in points.positions[at].to_array() {
            let bits = coordinate.to_bits();
            into.extend([bits as u32, (bits >> 32) as u32]);
        }
        into.extend(points.colors[at].to_array().map(f32::to_bits));
        into.extend([points.opacities[at].to_bits(), points.radii[at].to_bits(), id]);
        if self.has_normals {
            let normal = points.normals.as_ref().map_or(Vec3::ZERO, |normals| normals[at]);
            into.extend(normal.to_array().map(f32::to_bits));
        }
    }

    /// Returns the id of a point.
    pub fn id(record: &[u32]) -> u32 {
        record[11]
    }

    /// Returns the points that stand in some words, with their ids.
    pub fn points(self, words: &[u32]) -> Points {
        let (size, count) = (self.words(), words.len() / self.words());
        let record = |i: usize| &words[i * size..][..size];
        let vector = |words: &[u32]| Vec3::from_array([words[0], words[1], words[2]].map(f32::from_bits));
        let normals = self.has_normals.then(|| parallel::map(count, |i| vector(&record(i)[WORDS..])));
        Points {
            positions: parallel::map(count, |i| position(record(i))),
            colors: parallel::map(count, |i| vector(&record(i)[6..])),
            opacities: parallel::map(count, |i| f32::from_bits(record(i)[9])),
            radii: parallel::map(count, |i| f32::from_bits(record(i)[10])),
            dealt_ids: parallel::map(count, |i| Self::id(record(i))),
            normals,
            ..Points::default()
        }
    }

    /// Decodes the positions of the records alone.
    pub fn positions(self, words: &[u32]) -> Vec<DVec3> {
        let size = self.words();
        parallel::map(words.len() / size, |i| position(&words[i * size..][..size]))
    }
}

fn position(record: &[u32]) -> DVec3 {
    let coordinate = |axis: usize| f64::from_bits(u64::from(record[2 * axis + 1]) << 32 | u64::from(record[2 * axis]));
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_to_the_bit() {
        let points = Points {
            positions: vec![DVec3::new(-0.0, 1e300, 5e-324), DVec3::new(0.1, -2.5, 7.0)],
            colors: vec![Vec3::new(0.25, 3.0, -0.0), Vec3::ONE],
            opacities: vec![0.3, 1.0],
            radii: vec![0.0, 2.0],
            normals: Some(vec![Vec3::Z, Vec3::new(0.6, -0.8, 0.0)]),
            dealt_ids: vec![7, u32::MAX],
            ..Points::default()
        };
        for has_normals in [true, false] {
            let layout = RecordLayout { has_normals };
            let mut words = Vec::new();
            (0..2).for_each(|at| layout.put(&points, at, points.dealt_ids[at], &mut words));
            assert_eq!(words.len(), 2 * layout.words());
            let found = layout.points(&words);
            let normals = points.normals.clone().filter(|_| has_normals);
            assert_eq!(found, Points { normals, ..points.clone() });
            assert!(found.positions[0].x.is_sign_negative() && found.colors[0].z.is_sign_negative());
            assert_eq!(layout.positions(&words), points.positions);
        }
    }
}
