//! `tradeoff` and `render` on Gaussian splats: errors by cause, and popping along a path.

mod causes;
mod popping;
mod splats;

pub use splats::write as write_splats;
