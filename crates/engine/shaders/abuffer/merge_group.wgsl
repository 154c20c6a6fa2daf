// abuffer/merge where invocations share work: one workgroup per RUN_LENGTH fragments of the result. It loads the
// fragments of both runs that these come from side by side, and each invocation merges a few of them in the memory that
// it shares.
#import merge_path
#import dispatch

// Fragments of the result that an invocation writes.
const OWN = RUN_LENGTH / WG_SIZE;

// How many fragments before this part and up to its end come from the left run.
var<workgroup> lefts: array<u32, 2>;
// Those of the left run, then those of the right one.
var<workgroup> sources: array<vec2<u32>, RUN_LENGTH>;

#main {
    let item = workgroup_index(workgroup, groups);
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let part = part_of(runs[item]);
    let rank = part.first - part.pair;
    let count = part.last - part.first;
    if local < 2u {
        lefts[local] = left_of(part, rank + local * count);
    }
    workgroupBarrier();
    let left = lefts[1] - lefts[0];
    let right = count - left;
    let left_start = part.start + part.pair + lefts[0];
    let right_start = part.start + part.middle + rank - lefts[0];
    for (var i = local; i < count; i += WG_SIZE) {
        sources[i] = unmerged[select(right_start + i - left, left_start + i, i < left)];
    }
    workgroupBarrier();
    let first = min(local * OWN, count);
    // As `left_of`, among the sources.
    var a = select(0u, first - right, first > right);
    var high = min(first, left);
    while a < high {
        let taken = (a + high) / 2u;
        if before(sources[taken], sources[left + first - taken - 1u]) {
            a = taken + 1u;
        } else {
            high = taken;
        }
    }
    var b = first - a;
    for (var k = first; k < min(first + OWN, count); k++) {
        var take_left = b >= right;
        if a < left && b < right {
            take_left = before(sources[a], sources[left + b]);
        }
        merged[part.start + part.first + k] = sources[select(left + b, a, take_left)];
        a += select(0u, 1u, take_left);
        b += select(1u, 0u, take_left);
    }
}
