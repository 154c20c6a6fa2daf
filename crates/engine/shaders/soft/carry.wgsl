// soft/carry: the running sums before each run of a long list, from what the runs before it add. One invocation per
// list.
#import long_list
#import run_sums
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> lists: array<LongList>;
@group(0) @binding(2) var<storage, read_write> sums: array<RunSums>;

// The error of a rounded sum.
fn left(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    let s = a + b;
    let bb = s - a;
    return (a - (s - bb)) + (b - bb);
}

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = lists[item];
    var high = vec4<f32>(0.0);
    var low = vec4<f32>(0.0);
    var rest = vec4<f32>(0.0);
    for (var k = 0u; k < list.runs; k++) {
        let run = sums[list.first_run + k];
        sums[list.first_run + k] = RunSums(high, low, rest);
        low += run.low + left(high, run.high);
        high += run.high;
        let error = left(rest, run.rest).x;
        rest += run.rest;
        rest.y += error;
        if rest.z == 0.0 {
            high = vec4<f32>(0.0);
            low = vec4<f32>(0.0);
            rest = vec4<f32>(0.0);
        }
    }
}
