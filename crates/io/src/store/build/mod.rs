//! Writes clouds as octrees of Potree 2.0, whatever their size.

mod assembler;
mod builder;
mod checkpoint;
mod columns;
mod cube;
mod encode;
mod feeder;
mod hierarchy;
mod input;
mod plan;
mod ranges;
mod scatter;
mod sink;
mod state;
mod stream;
mod survey;
mod target;
mod tree;
mod types;

pub use super::octree::attributes::AttributeLayout;
pub use assembler::{Assembler, NODE_POINTS, Told};
pub use builder::{Built, Settings, build};
pub use cube::{Cell, Cube};
pub use encode::{Encoded, encode};
#[doc(hidden)]
pub use state::key;
pub use stream::{Streamed, stream};
#[doc(hidden)]
pub use target::check_target;
pub use types::{Narrow, Types};

#[cfg(test)]
mod tests;
