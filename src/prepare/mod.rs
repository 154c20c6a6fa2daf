//! What is computed once for a cloud: radii, and the order of its points.

mod morton;
pub mod order;
pub mod radius;
