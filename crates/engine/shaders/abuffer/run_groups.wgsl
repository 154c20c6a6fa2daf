// abuffer/run-groups: counts of runs and lists to workgroups, folded over x and y. One invocation.
#import long_list

@group(0) @binding(0) var<storage, read_write> work: LongWork;

const MOST = 65535u;

@compute @workgroup_size(1)
fn main() {
    let runs = atomicLoad(&work.run_count);
    work.whole_groups = array<u32, 3>(min(runs, MOST), (runs + MOST - 1u) / MOST, 1u);
    let run_groups = (runs + WG_SIZE - 1u) / WG_SIZE;
    work.run_groups = array<u32, 3>(min(run_groups, MOST), (run_groups + MOST - 1u) / MOST, 1u);
    let list_groups = (atomicLoad(&work.list_count) + WG_SIZE - 1u) / WG_SIZE;
    work.list_groups = array<u32, 3>(min(list_groups, MOST), (list_groups + MOST - 1u) / MOST, 1u);
}
