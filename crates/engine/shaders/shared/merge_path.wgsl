// Passes merge pairs of sorted runs of `width` fragments from one buffer into the other. Bisection finds where a part
// of RUN_LENGTH fragments of the result begins in both runs (merge path, Green et al. 2012), so that no work grows
// with the list.
#import long_list
#import fragments

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read> unmerged: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> merged: array<vec2<u32>>;
#push

// A part of the result, and the pair of runs that it comes from: [pair, middle) and [middle, end) of the list.
struct MergePart {
    start: u32,
    first: u32,
    last: u32,
    pair: u32,
    middle: u32,
    end: u32,
}

fn part_of(run: ListRun) -> MergePart {
    let first = run.run * RUN_LENGTH;
    let pair = first - first % (2u * push.width);
    let middle = min(pair + push.width, run.length);
    let end = min(pair + 2u * push.width, run.length);
    return MergePart(run.start, first, min(first + RUN_LENGTH, run.length), pair, middle, end);
}

// How many of the pair's first `rank` fragments come from the left run.
fn left_of(part: MergePart, rank: u32) -> u32 {
    let right_length = part.end - part.middle;
    var low = select(0u, rank - right_length, rank > right_length);
    var high = min(rank, part.middle - part.pair);
    while low < high {
        let taken = (low + high) / 2u;
        let left = unmerged[part.start + part.pair + taken];
        let right = unmerged[part.start + part.middle + rank - taken - 1u];
        if before(left, right) {
            low = taken + 1u;
        } else {
            high = taken;
        }
    }
    return low;
}
