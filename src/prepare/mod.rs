//! What is computed once for a cloud (stub).

/// Stub.
pub mod radius {
    /// Stub.
    pub fn estimate(positions: &[glam::DVec3], neighbors: usize, _progress: &indicatif::ProgressBar) -> Vec<f32> {
        vec![neighbors as f32; positions.len()]
    }
}

/// Stub.
pub mod order {
    /// Stub.
    pub fn canonical(points: crate::points::Points) -> crate::points::Points {
        points
    }
}
