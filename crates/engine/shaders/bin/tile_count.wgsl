// bin/tile-count: how many splats of each run meet each tile. One invocation per record; those behind the
// drawn splats count nothing. counts is zero before. Where pairs of tile and splat are sorted there is one run, and
// behind the counts of the tiles and a place for their total is the number of tiles that each splat meets.
#import tile_push
#import dispatch
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;

override PAIRS: u32 = 0u;

#main rank {
    if rank >= push.count {
        return;
    }
    let rectangle = rectangle_of(records[rank].y);
    if !any(rectangle != vec2<u32>(0u)) {
        return;
    }
    let met = tiles_of(rectangle, view.window.xy);
    if PAIRS != 0u {
        atomicStore(&counts[push.columns * push.rows + 1u + rank], (met.z - met.x) * (met.w - met.y));
    }
    let run = rank / push.run_length;
    var tile = met.xy;
    // A drawn splat meets a tile, so the condition may stand at the end: CPU drivers run every loop once.
    loop {
        atomicAdd(&counts[(tile.y * push.columns + tile.x) * push.runs + run], 1u);
        tile.x += 1u;
        if tile.x >= met.z {
            tile = vec2<u32>(met.x, tile.y + 1u);
        }
        if tile.y >= met.w {
            break;
        }
    }
}
