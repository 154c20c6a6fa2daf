// peel-layers/blend: a filtered layer behind what is in the image already, and the depths that points of the next layer
// must have at least. One invocation per pixel of the rectangle in work; what lies outside of the window only gets those.
// Reference: reference::peel_layers.
#import tiled
#import dispatch
#import filtered

struct Push {
    // Columns of tiles, and all tiles.
    columns: u32,
    tiles: u32,
    // The window's corner in the rectangle in work, and its size.
    left: u32,
    top: u32,
    width: u32,
    height: u32,
    // Size of the rectangle in work.
    outer_width: u32,
    outer_height: u32,
    // d~ in world units.
    distance: f32,
}

@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> depths: array<f32>;
@group(0) @binding(2) var<storage, read> colors: array<vec4<f32>>;
// Index and depth key; made ready for the next layer.
@group(0) @binding(3) var<storage, read_write> nearest: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> limits: array<u32>;
// Layers of each pixel; a single word that stays untouched unless COUNTED.
@group(0) @binding(5) var<storage, read_write> layers: array<u32>;
@group(0) @binding(6) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> image_depths: array<f32>;
var<immediate> push: Push;
override COUNTED: u32 = 0u;

const NOTHING = 0xffffffffu;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.outer_width * push.outer_height {
        return;
    }
    let pixel = vec2<u32>(p % push.outer_width, p / push.outer_width);
    let layer = filtered_pixel(pixel, push.columns, push.tiles);
    let background = is_background(layer.depth);
    nearest[p] = vec2<u32>(NOTHING);
    // No point has the largest key: what is background has no further layer.
    limits[p] = select(depth_key(layer.depth + push.distance), NOTHING, background);
    let corner = vec2<u32>(push.left, push.top);
    let size = vec2<u32>(push.width, push.height);
    let within = pixel - corner;
    if any(pixel < corner) || any(within >= size) {
        return;
    }
    let q = within.y * size.x + within.x;
    let front = image[q];
    if front.a == 0.0 && layer.color.a > 0.0 {
        image_depths[q] = layer.depth;
    }
    image[q] = front + (1.0 - front.a) * layer.color;
    if COUNTED == 1u {
        layers[q] += select(1u, 0u, background);
    }
}
