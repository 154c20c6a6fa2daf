//! Image metrics on linear float32 images.
