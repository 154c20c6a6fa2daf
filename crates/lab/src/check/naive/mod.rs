//! Formulas as they are written first, in float32 on the host. The cases must tell them from what the device does.

mod fading;
mod filters;
pub mod gaussians;
mod points;
mod soft;

use glam::Vec3;

use super::stage::Dot;

pub use fading::{moments, wavelet};
pub use filters::Filtered;
pub use points::{blended, covers, gaussian, half, is_between, pixel, weighted};
pub use soft::{Soft, disc};

/// Composes fragments with "over", as the product of 1 − α.
pub fn over(dots: &[Dot]) -> [f32; 4] {
    over_until(dots, 0.0)
}

/// Composes fragments like [`over`], until less than a share of the light passes.
pub fn over_until(dots: &[Dot], least: f32) -> [f32; 4] {
    let (mut color, mut rest) = (Vec3::ZERO, 1f32);
    for dot in dots {
        if rest < least {
            break;
        }
        color += dot.color * (dot.opacity * rest);
        rest *= 1.0 - dot.opacity;
    }
    [color.x, color.y, color.z, 1.0 - rest]
}

/// Depth of the nearest dot, however transparent it is.
pub fn nearest(dots: &[Dot]) -> f32 {
    dots.iter().map(|dot| -dot.position.z as f32).fold(f32::INFINITY, f32::min)
}

/// Layers of surfaces from near to far (`peel-layers`), each at `distance` behind the last one minus a tolerance
/// relative to its depth: the pixel, and the number of layers.
pub fn peel(dots: &[Dot], distance: f32, tolerance: f32, most: u32) -> ([f32; 4], u32) {
    let depth = |dot: &Dot| -dot.position.z as f32;
    let (mut layers, mut from) = (Vec::new(), f32::NEG_INFINITY);
    for _ in 0..most {
        let behind = dots.iter().filter(|dot| depth(dot) >= from);
        let Some(next) = behind.min_by(|a, b| depth(a).total_cmp(&depth(b))) else { break };
        layers.push(*next);
        from = depth(next) + distance - tolerance * depth(next);
    }
    (over(&layers), layers.len() as u32)
}

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
