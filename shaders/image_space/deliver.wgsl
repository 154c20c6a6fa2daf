// image-space/deliver: the filtered image, without what was rendered around the window for the filters' sake, to the order
// of the window. One invocation per pixel of the window.
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
}

@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> depths: array<f32>;
@group(0) @binding(2) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> image_depths: array<f32>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.width * push.height {
        return;
    }
    let pixel = vec2<u32>(push.left + p % push.width, push.top + p / push.width);
    let filtered = filtered_pixel(pixel, push.columns, push.tiles);
    image[p] = filtered.color;
    image_depths[p] = filtered.depth;
}
