// image-space/measure: depths and marks of each tile, from the nearest points of its pixels. One workgroup per tile,
// one invocation per column and STRIP of rows.
#import tile_range
#import dispatch
#import peel_work

// Index and depth key.
@group(0) @binding(0) var<storage, read> nearest: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> tiles: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> work: PeelWork;
#push

#main {
    let size = vec2<u32>(push.width, push.height);
    let tile = workgroup_index(workgroup, groups);
    let corner = vec2<u32>(tile % push.columns, tile / push.columns) * TILE;
    let first = corner + vec2<u32>(local % TILE, local / TILE * STRIP);
    begin_range(local);
    var low = NO_KEY;
    var high = 0u;
    var marked = 0u;
    for (var i = 0u; i < STRIP; i++) {
        let pixel = first + vec2<u32>(0u, i);
        let inside = all(pixel < size);
        let key = nearest[select(0u, pixel.y * size.x + pixel.x, inside)].y;
        let hit = inside && key != NO_KEY;
        low = select(low, min(low, key), hit);
        high = select(high, max(high, key), hit);
        marked |= select(0u, HAS_BACKGROUND, inside && !hit);
    }
    add_range(low, high, marked);
    if local == 0u {
        let range = found_tile(atomicLoad(&marks), 0u);
        tiles[tile] = range;
        if range.x != INFINITY_BITS {
            atomicStore(&work.found, 1u);
        }
    }
}
