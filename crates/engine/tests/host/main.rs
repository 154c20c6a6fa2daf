//! Tests without a device: files, scenes, points, camera paths, images and the float64 references.

mod camera_paths;
mod classes;
mod clips;
mod coloring;
mod comments;
mod edl;
mod ensembles;
mod legend;
mod photo_keys;
mod prepare;
mod prepare_store;
mod procedural;
mod profiles;
mod reach;
mod reference;
mod rooms;
mod scene;
mod scene_camera;
mod scene_points;
mod shading_normals;
mod splat_stores;
mod strays;
mod surface_opacity;
mod terrain;
mod terrain_store;
mod tracked;
