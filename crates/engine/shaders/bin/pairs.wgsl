// bin/pairs: a pair of tile and entry for each tile that a splat meets, splat after splat in order of depth. One
// invocation per record. offsets are the prefix sums of the counts of bin/tile-count: those of the tiles, their total,
// and the tiles that each splat meets. A splat's pairs lie one behind another, so that neighboring invocations write
// neighboring words.
#import tile_push
#import tile_entry
#import dispatch
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
@group(0) @binding(4) var<storage, read_write> pairs: array<vec2<u32>>;

#main rank {
    if rank >= push.count {
        return;
    }
    let index = records[rank].y;
    let rectangle = rectangle_of(index);
    if !any(rectangle != vec2<u32>(0u)) {
        return;
    }
    let met = tiles_of(rectangle, view.window.xy);
    let tiles = push.columns * push.rows;
    // The total stands once before the counts of the first splat, as the sum of the tiles' own.
    var slot = offsets[tiles + 1u + rank] - offsets[tiles];
    var tile = met.xy;
    // A drawn splat meets a tile, so the condition may stand at the end: CPU drivers run every loop once.
    loop {
        // Both passes walk the same tiles; should a driver ever disagree with itself, nothing is written outside.
        if slot < arrayLength(&pairs) {
            pairs[slot] = vec2<u32>(tile.y * push.columns + tile.x, entry_of(index, rectangle, view.window.xy + tile * TILE_SIDE));
        }
        slot += 1u;
        tile.x += 1u;
        if tile.x >= met.z {
            tile = vec2<u32>(met.x, tile.y + 1u);
        }
        if tile.y >= met.w {
            break;
        }
    }
}
