// abuffer/order: writes the band's pixels into the work list, class by class. One invocation per CLASSIFY_RUN pixels.
// The order within a class depends on arrival, but every pixel is worked on by itself. The first invocation also turns
// the numbers of pixels into workgroups (folded over x and y), and into places where the passes behind it find them.
#import classify
#import folded

@group(0) @binding(2) var<storage, read_write> pixels: array<u32>;

const MOST = 65535u;

#main item {
    let run = run_of(item);
    var next = count_classes(run.x, 1u, run.y);
    var start = 0u;
    for (var c = 0u; c < CLASS_COUNT; c++) {
        let word = c * CLASS_WORDS;
        let total = atomicLoad(&classes[word + CLASS_TOTAL]);
        if item == 0u {
            let groups = folded((total + WG_SIZE - 1u) / WG_SIZE, MOST);
            atomicStore(&classes[word], groups.x);
            atomicStore(&classes[word + 1u], groups.y);
            atomicStore(&classes[word + 2u], 1u);
            atomicStore(&classes[word + CLASS_START], start);
        }
        if next[c] > 0u {
            next[c] = start + atomicAdd(&classes[word + CLASS_PLACED], next[c]);
        }
        start += total;
    }
    for (var p = run.x; p < run.y; p++) {
        let c = class_at(p);
        if c < CLASS_COUNT {
            pixels[next[c]] = p;
            next[c] += 1u;
        }
    }
}
