//! Writes clouds as octrees of Potree 2.0, whatever their size.

mod assembler;
mod cube;
mod encode;
mod hierarchy;
mod sink;
mod tree;
mod types;

pub use super::octree::attributes::Layout;
pub use assembler::{Assembler, NODE_POINTS, Told};
pub use cube::{Cell, Cube};
pub use encode::{Encoded, encode};
pub use types::{Narrow, Types};

#[cfg(test)]
mod tests;
