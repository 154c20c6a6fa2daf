// abuffer/measure: the longest list, and how many fragments lie in long ones. One invocation per RUN pixels, so that
// few atomics meet; those of a workgroup look at adjacent pixels.
#import dispatch

struct Lengths {
    longest: atomic<u32>,
    in_long_lists: atomic<u32>,
}

@group(0) @binding(0) var<storage, read> counts: array<u32>;
@group(0) @binding(1) var<storage, read_write> lengths: Lengths;
#push
override RUN: u32 = 64u;
// Lists of more fragments are long ones.
override LONG: u32 = 256u;

#main item {
    let block = item / WG_SIZE * WG_SIZE * RUN;
    let start = block + item % WG_SIZE;
    if start >= push.count {
        return;
    }
    let end = min(block + WG_SIZE * RUN, push.count);
    var most = 0u;
    var in_long = 0u;
    for (var i = start; i < end; i += WG_SIZE) {
        let count = counts[i];
        most = max(most, count);
        in_long += select(0u, count, count > LONG);
    }
    atomicMax(&lengths.longest, most);
    if in_long > 0u {
        atomicAdd(&lengths.in_long_lists, in_long);
    }
}
