//! The headings under which `--help` groups options. Options without one stand first.

pub const APPEARANCE: &str = "Appearance";
pub const POINTS: &str = "Points";
pub const CAMERA: &str = "Camera";
pub const METHOD: &str = "Method";
pub const OUTPUT: &str = "Output";
pub const FRAMES: &str = "Several frames";
pub const DEVICE: &str = "Device and memory";
pub const MEASUREMENTS: &str = "Measurements";
