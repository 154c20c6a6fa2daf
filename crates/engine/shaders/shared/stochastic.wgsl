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
