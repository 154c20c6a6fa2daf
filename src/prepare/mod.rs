//! What is computed once for a cloud: radii, the order of its points, and their orders along the axes.

pub mod axes;
mod morton;
pub mod order;
pub mod radius;
