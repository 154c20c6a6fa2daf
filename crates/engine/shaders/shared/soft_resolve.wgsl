// Shared by the kernels that sort and blend the events of soft spheres. The variant says how they are blended.
#import lists
#import stop
#push
#import soft_terms
@group(0) @binding(23) var<storage, read> records: array<vec4<u32>>;

// Events between two tests for an early stop.
const LOOK = 16u;

#walker
