// abuffer/merge: merges pairs of sorted runs. One invocation writes RUN_LENGTH fragments of the result.
#import merge_path
#import dispatch

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let part = part_of(runs[item]);
    let rank = part.first - part.pair;
    let low = left_of(part, rank);
    var a = part.pair + low;
    var b = part.middle + rank - low;
    for (var k = part.first; k < part.last; k++) {
        var take_left = b >= part.end;
        if a < part.middle && b < part.end {
            take_left = before(unmerged[part.start + a], unmerged[part.start + b]);
        }
        if take_left {
            merged[part.start + k] = unmerged[part.start + a];
            a++;
        } else {
            merged[part.start + k] = unmerged[part.start + b];
            b++;
        }
    }
}
