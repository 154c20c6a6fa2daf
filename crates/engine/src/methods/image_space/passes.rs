//! The passes of image-space rendering.

use crate::methods::peel::PeelWork;
use crate::methods::prelude::*;
use crate::passes::project::{Shaded, View};

gpu_struct! {
    /// Push constants of `image-space/measure` and `image-space/resolve`.
    pub struct ResolvePush {
        columns: u32, // Columns of tiles.
        width: u32, // Size of the rectangle in work, in pixels.
        height: u32,
    }

    /// Push constants of `image-space/list`.
    pub struct ListPush {
        columns: u32, // Columns and rows of tiles.
        rows: u32,
        // The run before, where the filter ran already: what it left alone then, with all around, stays. Else 0.
        before: u32,
        slot: u32, // Whose dispatch this is.
        distance: f32,
        threshold: f32,
    }

    /// Push constants of the filters.
    pub struct FilterPush {
        columns: u32, // Columns of tiles, and all tiles.
        tiles: u32,
        width: u32, // Size of the rectangle in work, in pixels.
        height: u32,
        run: u32, // The run of a filter: each has its number.
        distance: f32, // d~ in world units, far, and the share of an edge from which on it is softened.
        far: f32,
        threshold: f32,
    }

    /// Push constants of `image-space/deliver`.
    pub struct DeliverPush {
        columns: u32, // Columns of tiles, and all tiles.
        tiles: u32,
        left: u32, // The window's corner in the rectangle in work, and its size.
        top: u32,
        width: u32,
        height: u32,
    }
}

pass! {
    /// Finds whether each tile of 16 × 16 pixels has background, and the smallest and largest depth of its nearest
    /// points.
    pub Measure(ResolvePush) = "image-space/measure" in "image_space/measure" {
        nearest: Read<[u32; 2]>,
        tiles: ReadWrite<[u32; 4]>,
        work: ReadWrite<PeelWork>,
    }

    /// Turns the index of the nearest point of each pixel, in tiles with points, into color, shaded only here, and
    /// depth; with `peel-layers` by its opacity.
    pub Resolve(ResolvePush) = "image-space/resolve" in "image_space/resolve" {
        camera: Uniform<View>,
        points_hi: Parts<[f32; 4]>,
        points_lo: Parts<[f32; 4]>,
        point_colors: Parts<[f32; 4]>,
        normals: Parts<[f32; 4]>,
        nearest: Read<[u32; 2]>,
        entries: Read<[u32; 2]>,
        depths: ReadWrite<f32>,
        colors: ReadWrite<[f32; 4]>,
    }

    /// Lists the tiles that the next pass may change, by their contents and those of the 8 tiles around, and sets that
    /// pass's indirect dispatch. It runs once before each pass over listed tiles.
    pub List(ListPush) = "image-space/list" in "image_space/list" {
        tiles: Read<[u32; 4]>,
        entries: ReadWrite<[u32; 2]>,
        arguments: ReadWrite<u32>,
        totals: ReadWrite<u32>,
    }

    /// Gives background within a surface the values of the nearest of its 3 × 3 pixels; once for each iteration, over
    /// listed tiles.
    pub Fill(FilterPush) = "image-space/fill" in "image_space/fill",
    /// Gives pixels that are seen through a hole, with others d̃ before them, the values of the nearest of their 3 × 3
    /// pixels; once for each iteration, over listed tiles.
    pub Occlusion(FilterPush) = "image-space/occlusion" in "image_space/occlusion",
    /// Replaces each pixel by the weighted mean of the 3 × 3 around it that are not background; once for each
    /// iteration, over listed tiles.
    pub Smooth(FilterPush) = "image-space/smooth" in "image_space/smooth",
    /// Blends color and alpha of each pixel with those of its four neighbors where depths have an edge, over listed
    /// tiles.
    pub Antialias(FilterPush) = "image-space/antialias" in "image_space/antialias" {
        tiled: Shared<TiledGroup>,
    }

    /// Copies each pixel of tiles that are not background alone to its place in the window.
    pub Deliver(DeliverPush) = "image-space/deliver" in "image_space/deliver" {
        entries: Read<[u32; 2]>,
        depths: Read<f32>,
        colors: Read<[f32; 4]>,
        image: ReadWrite<[f32; 4]>,
        image_depths: ReadWrite<f32>,
    }
}

group! {
    /// Bindings of the filters, which shaders/shared/filter.wgsl and tiled.wgsl explain.
    pub Tiled as TiledGroup {
        /// The work list.
        entries: Read<[u32; 2]>,
        /// Properties of each tile.
        tiles: ReadWrite<[u32; 4]>,
        /// Both sides of all tiles' depths, and one more.
        depths: ReadWrite<f32>,
        /// Both sides of all tiles' colors, and one more.
        colors: ReadWrite<[f32; 4]>,
    }
}

/// A filter; its place among those that run over tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Fills background.
    Fill = 0,
    /// Replaces occluded pixels.
    Occlusion = 1,
    /// Smooths by a low-pass filter.
    Smooth = 2,
    /// Softens edges.
    Antialias = 3,
}

impl Filter {
    /// All filters in the order in which they run.
    pub const ALL: [Self; 4] = [Self::Fill, Self::Occlusion, Self::Smooth, Self::Antialias];

    /// Returns `true` if a tile that the filter left alone stays as it is when it runs again, unless something around
    /// the tile changes.
    pub fn is_settling(self) -> bool {
        matches!(self, Self::Fill | Self::Occlusion)
    }
}

/// Pass that a work list of tiles belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Listed {
    /// A filter's.
    Filter(Filter),
    /// Shading.
    Resolve,
    /// The pass that puts a finished image into the window.
    Deliver,
}

const LIST_RESOLVE: u32 = 4;
const LIST_DELIVER: u32 = 5;

/// Constants that shaders share with this module.
pub(crate) const CONSTANTS: [(&str, u32); 6] = [
    ("LIST_FILL", Filter::Fill as u32),
    ("LIST_OCCLUSION", Filter::Occlusion as u32),
    ("LIST_SMOOTH", Filter::Smooth as u32),
    ("LIST_ANTIALIAS", Filter::Antialias as u32),
    ("LIST_RESOLVE", LIST_RESOLVE),
    ("LIST_DELIVER", LIST_DELIVER),
];

impl Listed {
    /// Returns the variant of `image-space/list`.
    pub(super) fn variant(self) -> Variant {
        let value = match self {
            Self::Filter(filter) => filter as u32,
            Self::Resolve => LIST_RESOLVE,
            Self::Deliver => LIST_DELIVER,
        };
        Variant::plain().with("FILTER", value)
    }
}

/// Returns a variant of `image-space/resolve`, from that of shading.
pub(super) fn resolve_variant(shaded: Variant, transparent: bool) -> Variant {
    shaded.with("TRANSPARENT", u32::from(transparent))
}

/// Returns the passes with their variants.
pub fn shaders() -> Vec<Shader> {
    let listed = Filter::ALL.map(Listed::Filter).into_iter().chain([Listed::Resolve, Listed::Deliver]);
    let shaded = Shaded::cut_variants();
    let resolve = shaded.iter().flat_map(|shaded| [false, true].map(|t| resolve_variant(shaded.clone(), t)));
    vec![
        Shader::new::<Resolve>(resolve),
        Shader::plain::<Measure>(),
        Shader::new::<List>(listed.map(Listed::variant)),
        Shader::plain::<Fill>(),
        Shader::plain::<Occlusion>(),
        Shader::plain::<Smooth>(),
        Shader::plain::<Antialias>(),
        Shader::plain::<Deliver>(),
    ]
}
