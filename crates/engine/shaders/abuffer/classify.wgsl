// abuffer/classify: how many pixels of the band are in each class. One invocation per CLASSIFY_RUN pixels, so that few
// atomics meet. The table is zero before.
#import classify

#main item {
    let run = run_of(item);
    var found = count_classes(run);
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if found[c] > 0u {
            atomicAdd(&classes[c * CLASS_WORDS + CLASS_TOTAL], found[c]);
        }
    }
}
