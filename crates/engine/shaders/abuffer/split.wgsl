// abuffer/split: lists the runs of every long list. One invocation per pixel of the last class. The order of the lists
// depends on arrival, but every run writes only what belongs to its own list.
#import classes
#import long_list
#import dispatch

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read> classes: array<u32>;
@group(0) @binding(2) var<storage, read> pixels: array<u32>;
@group(0) @binding(3) var<storage, read_write> work: LongWork;
@group(0) @binding(4) var<storage, read_write> runs: array<ListRun>;
@group(0) @binding(5) var<storage, read_write> lists: array<LongList>;
#push

#main item {
    let word = push.class_index * CLASS_WORDS;
    if item >= classes[word + CLASS_TOTAL] {
        return;
    }
    let p = pixels[classes[word + CLASS_START] + item];
    let n = offsets[p + 1u] - offsets[p];
    let start = offsets[p] - push.first_fragment;
    let count = (n + RUN_LENGTH - 1u) / RUN_LENGTH;
    let first = atomicAdd(&work.run_count, count);
    let list = atomicAdd(&work.list_count, 1u);
    // The host took room for as many as the counts allow; should they ever be wrong, nothing is written outside.
    if list < arrayLength(&lists) {
        lists[list] = LongList(p, first, count);
    }
    for (var k = 0u; k < min(count, arrayLength(&runs) - min(first, arrayLength(&runs))); k++) {
        runs[first + k] = ListRun(start, n, k, p);
    }
}
