// What the kernels share that sort and blend the events of soft spheres. The variant says how they are blended.
#import lists
#import stop
#import soft_push
#import soft_terms

// Events between two looks at what may stop.
const LOOK = 16u;

#walker
