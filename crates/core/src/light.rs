//! Directions that light comes from.

use glam::DVec3;

/// A light.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub enum Light {
    /// Light at the eye (perspective) or against the viewing direction (orthographic).
    #[default]
    Headlight,
    /// The direction in which the light travels, world space, not zero.
    Direction(DVec3),
    /// A position in the world.
    Position(DVec3),
}
