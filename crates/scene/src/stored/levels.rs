//! The levels of a store's nodes: what stands in for whom, and by how much larger it then is.

use crate::supply::Branch;
use pellucid_io::store::Node;

/// Returns the branch of each node of a cloud whose lengths are so many times as large in the scene; without levels of
/// none. Nodes without points are none's parent.
///
/// Points of the levels above are shared out to the nodes below in proportion to all points there. If a node with all
/// below it is left out, those that are shared out to it stand for all of its place: their discs have the area of all
/// if radii grow by the root of the ratio of numbers, which is 2 for each level of a surface.
pub(super) fn branches(nodes: &[Node], scale: f64) -> Vec<Option<Branch>> {
    if !nodes.iter().any(|node| node.parent.is_some() && node.spacing > 0.0) {
        return vec![None; nodes.len()];
    }
    let parent = |at: usize| nodes[at].parent.map(|parent| parent as usize);
    // Own points with those below, and the sum of these over the children of each.
    let (mut all, mut below) = (vec![0.0; nodes.len()], vec![0.0; nodes.len()]);
    for at in (0..nodes.len()).rev() {
        all[at] = below[at] + nodes[at].points as f64;
        if let Some(parent) = parent(at) {
            below[parent] += all[at];
        }
    }
    // For each node the block that is nearest above it, with its spacing, and the points above that are shared out to
    // it.
    let mut above: Vec<(Option<(u32, f64)>, f64)> = Vec::with_capacity(nodes.len());
    let mut block_of: Vec<Option<u32>> = Vec::with_capacity(nodes.len());
    let mut blocks = 0;
    let mut branches = Vec::with_capacity(nodes.len());
    for (at, node) in nodes.iter().enumerate() {
        let (stand_in, shared) = parent(at).map_or((None, 0.0), |parent| {
            let (higher, shared) = above[parent];
            let own = block_of[parent].map(|block| (block, nodes[parent].spacing));
            let part = if below[parent] > 0.0 { all[at] / below[parent] } else { 0.0 };
            (own.or(higher), (shared + nodes[parent].points as f64) * part)
        });
        above.push((stand_in, shared));
        block_of.push((node.points > 0).then_some(blocks));
        blocks += u32::from(node.points > 0);
        let spacing = stand_in.map_or(f64::INFINITY, |(_, spacing)| scale * spacing);
        let growth = if shared > 0.0 { ((shared + all[at]) / shared).sqrt() as f32 } else { 1.0 };
        branches.push(Some(Branch { parent: stand_in.map(|(block, _)| block), spacing, growth }));
    }
    branches
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use pellucid_core::cloud::Bounds;

    fn node(parent: Option<u32>, points: u64, spacing: f64) -> Node {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        Node { level: 0, parent, bounds, points, bytes: 0, spacing, largest_radius: None }
    }

    #[test]
    fn radii_grow_by_two_for_each_level_of_a_surface() {
        // A surface that each level covers with four times as many points as all above it: 64, and 3 · 64 more below
        // it, and so on.
        let mut nodes = vec![node(None, 64, 4.0)];
        nodes.extend((0..4).map(|_| node(Some(0), 48, 2.0)));
        nodes.extend((0..16).map(|i| node(Some(1 + i / 4), 48, 1.0)));
        let found = branches(&nodes, 0.5);
        assert_eq!(found[0], Some(Branch { parent: None, spacing: f64::INFINITY, growth: 1.0 }));
        // Without the second level and the third one radii are 4 times as large, without the third one 2 times.
        assert_eq!(found[1], Some(Branch { parent: Some(0), spacing: 2.0, growth: 4.0 }));
        assert_eq!(found[20], Some(Branch { parent: Some(4), spacing: 1.0, growth: 2.0 }));
    }

    #[test]
    fn few_points_left_out_make_others_little_larger() {
        // Of 100 points at the root 75 are shared out to the first child, which brings 27 more, and 25 to the other
        // one.
        let nodes = [node(None, 100, 4.0), node(Some(0), 27, 2.0), node(Some(0), 9, 2.0)];
        let growth = (102.0f64 / 75.0).sqrt() as f32;
        let found: Vec<f32> = branches(&nodes, 1.0).into_iter().flatten().map(|branch| branch.growth).collect();
        assert_eq!(found, [1.0, growth, (34.0f64 / 25.0).sqrt() as f32]);
    }

    #[test]
    fn nodes_without_points_stand_in_for_none() {
        let nodes = [
            node(None, 0, 8.0),
            node(Some(0), 40, 4.0),
            node(Some(1), 0, 2.0),
            node(Some(2), 120, 1.0),
            node(Some(0), 10, 4.0),
        ];
        let found = branches(&nodes, 2.0);
        // Nothing is above the first ones with points.
        assert_eq!(found[1], Some(Branch { parent: None, spacing: f64::INFINITY, growth: 1.0 }));
        assert_eq!(found[4], found[1]);
        // The block above is the first one, and the distance that of its points.
        assert_eq!(found[3], Some(Branch { parent: Some(0), spacing: 8.0, growth: 2.0 }));
        let without = [node(None, 5, 0.0), node(None, 5, 0.0)];
        assert_eq!(branches(&without, 1.0), [None, None]);
        assert!(branches(&[], 1.0).is_empty());
    }
}
