// scan/spread: exclusive prefix sums of each run of SCAN_RUN elements, begun at the run's own offset. One invocation
// per run. Second half of reduce-then-scan; at the top level there is one run, and it begins at zero.
#import dispatch

struct Push {
    count: u32,
}

@group(0) @binding(0) var<storage, read> values: array<u32>;
@group(0) @binding(1) var<storage, read> starts: array<u32>;
@group(0) @binding(2) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(3) var<storage, read_write> overflow: array<atomic<u32>>;
var<immediate> push: Push;
override TOP: u32 = 0u;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let run = invocation_index(workgroup, groups, local);
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
