// abuffer/order: writes the band's pixels into the work list, class by class. One invocation per CLASSIFY_RUN pixels.
// The order within a class depends on arrival, but every pixel is worked on by itself.
#import classify

@group(0) @binding(2) var<storage, read_write> pixels: array<u32>;

#main item {
    let run = run_of(item);
    var next = count_classes(run);
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if next[c] > 0u {
            let word = c * CLASS_WORDS;
            next[c] = atomicLoad(&classes[word + CLASS_START]) + atomicAdd(&classes[word + CLASS_PLACED], next[c]);
        }
    }
    for (var p = run.x; p < run.y; p++) {
        let c = class_at(p);
        if c < CLASS_COUNT {
            pixels[next[c]] = p;
            next[c] += 1u;
        }
    }
}
