// abuffer/classify: how many pixels of the band are in each class. One invocation per CLASSIFY_RUN pixels, so that few
// atomics meet. The table is zero before.
#import classes
#import dispatch

struct Push {
    band_start: u32,
    band_end: u32,
}

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read_write> classes: array<atomic<u32>>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = push.band_start + invocation_index(workgroup, groups, local) * CLASSIFY_RUN;
    let last = min(first + CLASSIFY_RUN, push.band_end);
    var found: array<u32, CLASS_COUNT + 1u>;
    for (var c = 0u; c <= CLASS_COUNT; c++) {
        found[c] = 0u;
    }
    for (var p = first; p < last; p++) {
        found[class_of(offsets[p + 1u] - offsets[p])] += 1u;
    }
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if found[c] > 0u {
            atomicAdd(&classes[c * CLASS_WORDS + CLASS_TOTAL], found[c]);
        }
    }
}
