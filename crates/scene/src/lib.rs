//! A scene: image, camera, shading, clouds and method, as a TOML file or the command line give them.
//!
//! A file becomes a tree of keys ([`Overrides`] lay options over it), the tree a checked [`Scene`], the scene and its
//! clouds the [`Points`](pellucid_core::points::Points) and the [`Camera`](pellucid_core::camera::Camera) of a frame.

mod along;
mod along_curve;
mod assemble;
mod background;
mod batches;
mod broadest_side;
mod cache;
mod choice;
mod classes;
mod clip;
mod coloring;
mod covered;
mod document;
mod error;
mod framed;
mod framing;
mod gaussians;
mod keys;
mod layers;
pub mod legend;
mod lists;
mod method;
mod methods;
mod nothing_left;
mod odd_sizes;
mod open;
mod outermost;
mod overrides;
mod overview;
mod parse;
mod photo;
mod pictured;
pub mod prepare;
pub mod procedural;
mod range;
mod recipe;
#[cfg(test)]
mod reference;
mod scene;
mod schema;
mod seen;
mod sensor;
mod setting;
mod settings;
pub mod stored;
pub mod supply;
mod surface_opacity;
mod surroundings;
mod table;
pub mod tracked;
mod tree;
mod units;
mod view;

pub use along::{Course, path_defaults};
pub use assemble::{
    arrange, arrange_with_legend, assemble, load_clouds, notes, shadow_texture, take_generated, up_axis,
};
pub use background::are_dark;
pub use choice::MethodChoice;
pub use coloring::{automatic, colorings};
pub use document::{Change, Document};
pub use error::{Error, OpenError, Place};
pub use framing::{DEFAULT_FOV_Y, camera, camera_at, stated_camera, stated_camera_at};
pub use keys::{KeyTable, all_method_keys, gaussian_keys, method_keys, paths_of, tables};
pub use layers::note_of_layers;
pub use methods::{Family, METHODS, Method, Purpose, Relief, SoftMethod, edl_methods};
pub use odd_sizes::odd_sizes;
pub use open::{DEFAULT_SCENE, Input, Named, Opened, name, open};
pub use overrides::Overrides;
pub use overview::{Overview, overview};
pub use pictured::PictureCamera;
pub use recipe::{Lighting, Recipe};
pub use scene::Scene;
pub use schema::{Key, Ladder, Range, Slider, ValueKind, Word, rounded};
pub use setting::Setting;
pub use settings::*;
pub use surroundings::camera_notes;
pub use units::{Systems, Units, differing_units};
pub use view::{Vertical, View, ViewName};
