//! Tests without a device: files, scenes, points, camera paths, images and the float64 references.

mod camera_paths;
mod clips;
mod comments;
mod deep;
mod in_place;
mod io;
mod metrics;
mod output;
mod reach;
mod rooms;
mod soft_model;
