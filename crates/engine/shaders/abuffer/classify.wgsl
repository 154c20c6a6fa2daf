// abuffer/classify: how many pixels of the band are in each class. One invocation per CLASSIFY_RUN pixels, so that few
// atomics meet. The table is zero before.
#import classify

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let run = run_of(invocation_index(workgroup, groups, local));
    var found = count_classes(run);
    for (var c = 0u; c < CLASS_COUNT; c++) {
        if found[c] > 0u {
            atomicAdd(&classes[c * CLASS_WORDS + CLASS_TOTAL], found[c]);
        }
    }
}
