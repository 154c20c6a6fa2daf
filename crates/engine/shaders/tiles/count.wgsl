// tiles/count: how many large splats meet each tile. One invocation per pair. counts is zero before.
#import tiles
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

#main pair {
    if pair < pairs() {
        atomicAdd(&counts[pair_at(pair).tile], 1u);
    }
}
