//! Tests of scenes: files, settings, points, cameras, built-in scenes and what is prepared of clouds.

mod classes;
mod coloring;
mod ensembles;
mod legend;
mod path_keys;
mod photo_keys;
mod pictured;
mod prepare;
mod prepare_store;
mod procedural;
mod scene;
mod scene_camera;
mod scene_points;
mod shading_normals;
mod splat_stores;
mod stated_camera;
mod strays;
mod surface_opacity;
mod terrain;
mod terrain_store;
mod tracked;
mod turntable;
