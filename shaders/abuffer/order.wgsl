// abuffer/order: writes the band's pixels into the work list, class by class. One invocation per CLASSIFY_RUN pixels. The
// order within a class depends on arrival, but every pixel is worked on by itself.
#import classes
#import dispatch

struct Push {
    band_start: u32,
    band_end: u32,
}

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read_write> classes: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read_write> pixels: array<u32>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = push.band_start + invocation_index(workgroup, groups, local) * CLASSIFY_RUN;
    let last = min(first + CLASSIFY_RUN, push.band_end);
    var next: array<u32, CLASS_COUNT + 1u>;
    for (var c = 0u; c <= CLASS_COUNT; c++) {
        next[c] = 0u;
    }
    for (var p = first; p < last; p++) {
        next[class_of(offsets[p + 1u] - offsets[p])] += 1u;
    }
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if next[c] > 0u {
            let word = c * CLASS_WORDS;
            next[c] = atomicLoad(&classes[word + CLASS_START]) + atomicAdd(&classes[word + CLASS_PLACED], next[c]);
        }
    }
    for (var p = first; p < last; p++) {
        let c = class_of(offsets[p + 1u] - offsets[p]);
        if c < CLASS_COUNT {
            pixels[next[c]] = p;
            next[c] += 1u;
        }
    }
}
