// Stochastic transparency tile by tile: shared by the passes through the splats. A run works on STRATA strata of four
// samples each. Buffers that have one element for each stratum and pixel hold all pixels of a stratum together.
#import random

#push

const NOTHING = 0xffffffffu;

// The smallest rank of the fragments that cover each sample of some strata, as depth key and index.
struct SampleRanks {
    keys: array<vec4<u32>, STRATA>,
    indices: array<vec4<u32>, STRATA>,
}

fn farthest_of(ranks: SampleRanks) -> u32 {
    var most = vec4<u32>(0u);
#each stratum     most = max(most, ranks.keys[{stratum}u]);
    return max(max(most.x, most.y), max(most.z, most.w));
}
