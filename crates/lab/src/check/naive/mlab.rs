//! Multi-layer alpha blending after Salvi and Vaidyanathan (2014).

use glam::Vec3;

use crate::check::stage::Dot;

#[derive(Clone, Copy)]
struct Node {
    depth: f32,
    /// Premultiplied.
    color: Vec3,
    through: f32,
}

fn merged(front: &Node, back: &Node) -> Node {
    let (color, through) = (front.color + front.through * back.color, front.through * back.through);
    Node { depth: front.depth, color, through }
}

/// A pixel of dots in the order in which they come; `nodes` are kept of it at any time. Transmittances are products of
/// 1 − α.
pub fn mlab(dots: &[Dot], nodes: usize) -> [f32; 4] {
    let mut kept: Vec<Node> = Vec::new();
    for dot in dots {
        let depth = -dot.position.z as f32;
        let node = Node { depth, color: dot.opacity * dot.color, through: 1.0 - dot.opacity };
        let at = kept.partition_point(|other| other.depth <= depth);
        kept.insert(at, node);
        if kept.len() > nodes
            && let (Some(back), Some(front)) = (kept.pop(), kept.pop())
        {
            kept.push(merged(&front, &back));
        }
    }
    let whole = kept.into_iter().reduce(|front, back| merged(&front, &back));
    whole.map_or([0.0; 4], |node| node.color.extend(1.0 - node.through).to_array())
}
