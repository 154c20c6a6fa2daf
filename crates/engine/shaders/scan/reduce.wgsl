// scan/reduce: sums of runs of SCAN_RUN elements. One invocation per run. A sum over 32 bits sets the flag.
// First half of reduce-then-scan (Harris, Sengupta, Owens 2007), without barriers or forward progress between
// workgroups.
#import dispatch

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read_write> sums: array<u32>;
@group(0) @binding(2) var<storage, read_write> overflow: array<atomic<u32>>;
#push

#main run {
    let start = run * SCAN_RUN;
    if start >= push.count {
        return;
    }
    let end = min(start + SCAN_RUN, push.count);
    var sum = 0u;
    var carried = false;
    for (var i = start; i < end; i++) {
        let next = sum + values[i];
        carried = carried || next < sum;
        sum = next;
    }
    sums[run] = sum;
    if carried {
        atomicOr(&overflow[0], 1u);
    }
}
