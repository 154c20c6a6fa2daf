// abuffer/merge: merges pairs of sorted runs of `width` fragments from one buffer into the other. One invocation writes
// RUN_LENGTH fragments of the result; it finds where they begin in both runs by bisection (merge path, Green et al.
// 2012), so that no invocation's work grows with the list.
#import long_list
#import fragments
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read> unmerged: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> merged: array<vec2<u32>>;
#push

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let first = run.run * RUN_LENGTH;
    let last = min(first + RUN_LENGTH, run.length);
    // The pair of runs that this part of the result comes from: [a, middle) and [middle, end) of the list.
    let pair = first - first % (2u * push.width);
    let middle = min(pair + push.width, run.length);
    let end = min(pair + 2u * push.width, run.length);
    // How many of the pair's first `rank` fragments come from the left run.
    let rank = first - pair;
    var low = select(0u, rank - (end - middle), rank > end - middle);
    var high = min(rank, middle - pair);
    while low < high {
        let taken = (low + high) / 2u;
        let left = unmerged[run.start + pair + taken];
        let right = unmerged[run.start + middle + rank - taken - 1u];
        if before(left, right) {
            low = taken + 1u;
        } else {
            high = taken;
        }
    }
    var a = pair + low;
    var b = middle + rank - low;
    for (var k = first; k < last; k++) {
        var take_left = b >= end;
        if a < middle && b < end {
            take_left = before(unmerged[run.start + a], unmerged[run.start + b]);
        }
        if take_left {
            merged[run.start + k] = unmerged[run.start + a];
            a++;
        } else {
            merged[run.start + k] = unmerged[run.start + b];
            b++;
        }
    }
}
