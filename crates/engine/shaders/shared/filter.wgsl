// Bindings of the filters, and access to the pixels around one. A filter defines filter_tile(entry, column, first row,
// place in the workgroup). One workgroup per listed tile, one invocation per column and STRIP of rows.
#import tiled
#import dispatch

@group(0) @binding(0) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> tiles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> depths: array<f32>;
@group(0) @binding(3) var<storage, read_write> colors: array<vec4<f32>>;
#push
// A copy: what is stored might change the constants as far as a compiler knows.
var<private> p: Push;

// Place of a pixel, -1 to TILE in both coordinates, where it is read; `sides` is the first bit of its kind of side.
fn read_place(entry: Entry, sides: u32, x: i32, y: i32) -> u32 {
    let across = u32(x + i32(TILE)) / TILE;
    let down = u32(y + i32(TILE)) / TILE;
    let number = down * 3u + across;
    let tile = entry.x + down * p.columns + across - p.columns - 1u;
    let place = pixel_place(tile, p.tiles, (entry.y >> (number + sides)) & 1u, u32(x) % TILE, u32(y) % TILE);
    return select(2u * p.tiles * AREA, place, ((entry.y >> number) & 1u) != 0u);
}

fn depth_at(entry: Entry, x: i32, y: i32) -> f32 {
    return depths[read_place(entry, ENTRY_DEPTHS, x, y)];
}

fn color_at(entry: Entry, x: i32, y: i32) -> vec4<f32> {
    return colors[read_place(entry, ENTRY_COLORS, x, y)];
}

// Place where the listed tile's own pixel is written.
fn write_place(entry: Entry, sides: u32, x: u32, y: u32) -> u32 {
    return pixel_place(entry.x, p.tiles, 1u - ((entry.y >> (4u + sides)) & 1u), x, y);
}

#main {
    p = push;
    let entry = entries[workgroup_index(workgroup, groups)];
    filter_tile(entry, local % TILE, local / TILE * STRIP, local);
}
