// abuffer/classify: how many pixels of the band are in each class. One invocation per CLASSIFY_RUN pixels, so that few
// atomics meet; those of a workgroup look at adjacent pixels, which one transaction of a GPU's memory brings. The
// table is zero before.
#import classify

#main item {
    let first = push.band_start + item / WG_SIZE * WG_SIZE * CLASSIFY_RUN;
    let end = min(first + WG_SIZE * CLASSIFY_RUN, push.band_end);
    var found = count_classes(first + item % WG_SIZE, WG_SIZE, end);
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if found[c] > 0u {
            atomicAdd(&classes[c * CLASS_WORDS + CLASS_TOTAL], found[c]);
        }
    }
}
