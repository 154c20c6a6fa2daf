// tiles/store: the large splats of each tile, in any order: tile t owns entries[starts[t] .. starts[t + 1]]. One
// invocation per pair. cursors is a copy of starts before.
#import tiles
@group(0) @binding(5) var<storage, read_write> cursors: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> entries: array<u32>;

#main number {
    if number < pairs() {
        let pair = pair_at(number);
        let slot = atomicAdd(&cursors[pair.tile], 1u);
        // Both passes find the same pairs; should a driver ever disagree with itself, nothing is written outside.
        if slot < arrayLength(&entries) {
            entries[slot] = pair.splat;
        }
    }
}
