// Stochastic transparency tile by tile: shared by the passes through the splats. A run works on STRATA strata of four
// samples each. Buffers that have one element for each stratum and pixel hold all pixels of a stratum together.
#import random

struct Push {
    walk: TileWalk,
    // Pixels of the window.
    pixels: u32,
    // Samples of the strata before this run's, and those to take from its first one on.
    before: u32,
    left: u32,
    // The random numbers' key for the run's first two strata.
    key_low: u32,
    key_high: u32,
}
var<immediate> push: Push;

const NOTHING = 0xffffffffu;

// The smallest rank of the fragments that cover each sample of some strata, as depth key and index.
struct SampleRanks {
    keys: array<vec4<u32>, STRATA>,
    indices: array<vec4<u32>, STRATA>,
}
