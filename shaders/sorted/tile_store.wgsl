// sorted/tile-store: each tile's splats, in order of depth. cursors are the prefix sums of the counts before, and where
// each cell's entries end after.
#import tile_walk
@group(0) @binding(2) var<storage, read_write> cursors: array<u32>;
@group(0) @binding(3) var<storage, read_write> entries: array<u32>;

fn visit(cell: u32, rank: u32) {
    let slot = cursors[cell];
    cursors[cell] = slot + 1u;
    // Both passes walk the same tiles; should a driver ever disagree with itself, nothing is written outside.
    if slot < arrayLength(&entries) {
        entries[slot] = rank;
    }
}
