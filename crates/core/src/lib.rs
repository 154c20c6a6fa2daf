//! Types and functions that all crates of pellucid share: clouds, points, cameras, images, color, light, random
//! numbers, progress, and files that are whole or absent.

pub mod atomic;
pub mod camera;
pub mod cloud;
pub mod color;
pub mod image;
pub mod light;
pub mod metrics;
#[doc(hidden)]
pub mod morton;
pub mod points;
pub mod progress;
pub mod random;
#[doc(hidden)]
pub mod words;
