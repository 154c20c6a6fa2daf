// peel-layers/blend: a filtered layer behind what is in the image already, and the depths that points of the next layer
// must have at least; of a layer that is not shown these depths alone. One workgroup per listed tile, one invocation
// per column and STRIP of rows; what lies outside of the window only gets those depths. Pixels of tiles that are not
// listed have no point, nor will they have one. Reference: reference::peel_layers.
#import tiled
#import dispatch
#import filtered

@group(0) @binding(0) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> depths: array<f32>;
@group(0) @binding(2) var<storage, read> colors: array<vec4<f32>>;
// Index and depth key; made ready for the next layer.
@group(0) @binding(3) var<storage, read_write> nearest: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> limits: array<u32>;
// Layers of each pixel; a single word that stays untouched unless COUNTED.
@group(0) @binding(5) var<storage, read_write> layers: array<u32>;
@group(0) @binding(6) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> image_depths: array<f32>;
#push
override COUNTED: u32 = 0u;

const NOTHING = 0xffffffffu;

#main {
    let p = push;
    let entry = entries[workgroup_index(workgroup, groups)];
    let x = local % TILE;
    let first_row = local / TILE * STRIP;
    let corner = vec2<u32>(entry.x % p.columns, entry.x / p.columns) * TILE;
    let outer_size = vec2<u32>(p.outer_width, p.outer_height);
    let size = vec2<u32>(p.width, p.height);
    for (var i = 0u; i < STRIP; i++) {
        let y = first_row + i;
        let pixel = corner + vec2<u32>(x, y);
        let layer = filtered_pixel(entry, p.tiles, x, y);
        let background = is_background(layer.depth);
        if all(pixel < outer_size) {
            let at = pixel.y * outer_size.x + pixel.x;
            nearest[at] = vec2<u32>(NOTHING);
            // No point has the largest key: what is background has no further layer. Nor is a layer its own next one,
            // however small d~ is.
            let next = max(depth_key(layer.depth + p.distance), depth_key(layer.depth) + 1u);
            limits[at] = select(next, NOTHING, background);
        }
        // Beyond the left and upper border it wraps to what is larger than any window.
        let within = pixel - vec2<u32>(p.left, p.top);
        if p.shown == 1u && all(within < size) {
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
    }
}
