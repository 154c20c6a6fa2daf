// image-space/deliver: the filtered image, without what was rendered around the window for the filters' sake, to the
// order of the window. The window is background at the start. One
// workgroup per listed tile, one invocation per column and STRIP of rows.
#import tiled
#import dispatch
#import filtered

@group(0) @binding(0) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> depths: array<f32>;
@group(0) @binding(2) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> image_depths: array<f32>;
#push

#main {
    let p = push;
    let entry = entries[workgroup_index(workgroup, groups)];
    let x = local % TILE;
    let first_row = local / TILE * STRIP;
    let corner = vec2<u32>(entry.x % p.columns, entry.x / p.columns) * TILE;
    let size = vec2<u32>(p.width, p.height);
    for (var i = 0u; i < STRIP; i++) {
        let y = first_row + i;
        // Beyond the left and upper border it wraps to what is larger than any window.
        let pixel = corner + vec2<u32>(x, y) - vec2<u32>(p.left, p.top);
        if all(pixel < size) {
            let filtered = filtered_pixel(entry, p.tiles, x, y);
            let q = pixel.y * size.x + pixel.x;
            image[q] = filtered.color;
            image_depths[q] = filtered.depth;
        }
    }
}
