// abuffer/merge-in-place: some steps of merging pairs of sorted runs of 2^width_log fragments where they lie, by
// Batcher's odd-even merge (Batcher 1968; Knuth, TAOCP 3, 5.3.4). One invocation per long list. A step compares
// fragments that lie 2^distance_log apart; a level begins with the runs' length as distance and halves it with every
// step. What lies beyond the end of a list counts as behind everything and so never moves: lists of any length are
// sorted.
#import long_list
#import fragments
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read> lists: array<LongList>;
@group(0) @binding(3) var<storage, read_write> fragments: array<vec2<u32>>;
#push

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = runs[lists[item].first_run];
    if (list.length - 1u) >> push.width_log == 0u {
        // One run: sorted already.
        return;
    }
    // Every other stretch of `distance` fragments is compared with the one behind it.
    let comparisons = (list.length + 1u) / 2u;
    for (var s = 0u; s < push.steps; s++) {
        let distance_log = push.distance_log - s;
        let distance = 1u << distance_log;
        // The first step takes the left runs, the others what lies one distance into each pair of runs.
        let shift = select(distance, 0u, distance_log == push.width_log);
        for (var c = 0u; c < comparisons; c++) {
            let i = ((c >> distance_log) << (distance_log + 1u)) + (c & (distance - 1u)) + shift;
            let j = i + distance;
            let same_pair = (i ^ j) >> (push.width_log + 1u) == 0u;
            if same_pair && j < list.length {
                let a = fragments[list.start + i];
                let b = fragments[list.start + j];
                if before(b, a) {
                    fragments[list.start + i] = b;
                    fragments[list.start + j] = a;
                }
            }
        }
    }
}
