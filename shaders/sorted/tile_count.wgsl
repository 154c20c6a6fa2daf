// sorted/tile-count: how many splats of each run meet each tile. counts is zero before.
#import tile_walk
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

fn visit(cell: u32, rank: u32) {
    counts[cell] += 1u;
}
