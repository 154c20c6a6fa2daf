// scan/spread: exclusive prefix sums of each run of SCAN_RUN elements, begun at the run's own offset. One invocation
// per run. Second half of reduce-then-scan; at the top level there is one run, and it begins at zero.
#import dispatch

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> overflow: array<atomic<u32>>;
#push
override TOP: u32 = 0u;

#main run {
    let start = run * SCAN_RUN;
    if start >= push.count {
        return;
    }
    let end = min(start + SCAN_RUN, push.count);
    var sum = 0u;
    if TOP == 0u {
        sum = starts[run];
    }
    for (var i = start; i < end; i++) {
        let value = values[i];
        offsets[i] = sum;
        let next = sum + value;
        if next < sum {
            atomicOr(&overflow[0], 1u);
        }
        sum = next;
    }
}
