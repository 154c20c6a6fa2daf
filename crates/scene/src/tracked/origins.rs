//! Finds the cloud of a point, and its place there, from its number among all points of a scene.

/// The number of points of each cloud in the scene, and their indices.
#[derive(Debug, Clone, Default)]
pub(super) struct Origins {
    /// Number of each cloud's first point among those of all clouds, cloud after cloud.
    starts: Vec<u32>,
    /// Points of a cloud that are there; `None`: all.
    kept: Vec<Option<Vec<u32>>>,
    count: u32,
}

impl Origins {
    /// Adds a cloud with `count` points in the scene; `keep` marks the points that are present, if some aren't.
    pub fn push(&mut self, count: usize, keep: Option<&[bool]>) {
        self.starts.push(self.count);
        // Points are counted in 32 bits: more of them don't fit any device.
        self.count += count as u32;
        self.kept.push(keep.map(|keep| (0..).zip(keep).filter(|(_, keep)| **keep).map(|(i, _)| i).collect()));
    }

    /// Returns the cloud of a point, and its place in it.
    pub fn locate(&self, number: u32) -> (usize, usize) {
        // Clouds without points share their start with the next one, so the last match is taken.
        let cloud = self.starts.partition_point(|start| *start <= number) - 1;
        let place = (number - self.starts[cloud]) as usize;
        (cloud, self.kept[cloud].as_ref().map_or(place, |kept| kept[place] as usize))
    }

    /// Returns the places of a cloud's points that are not in the scene, of `count` points.
    pub fn left_out(&self, cloud: usize, count: usize) -> Vec<usize> {
        let Some(kept) = &self.kept[cloud] else { return Vec::new() };
        let mut kept = kept.iter().map(|place| *place as usize).peekable();
        (0..count).filter(|place| kept.next_if_eq(place).is_none()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_may_be_empty_and_lack_points() {
        let mut origins = Origins::default();
        origins.push(2, None);
        origins.push(0, None);
        origins.push(2, Some(&[false, true, false, true, false]));
        origins.push(0, Some(&[false]));
        origins.push(1, None);
        let all: Vec<_> = (0..5).map(|number| origins.locate(number)).collect();
        assert_eq!(all, [(0, 0), (0, 1), (2, 1), (2, 3), (4, 0)]);
        assert_eq!([0, 2, 3].map(|cloud| origins.left_out(cloud, 5)), [vec![], vec![0, 2, 4], vec![0, 1, 2, 3, 4]]);
    }
}
