// abuffer/run-groups: counts of runs and lists to workgroups, folded over x and y. One invocation.
#import folded
#import long_list

@group(0) @binding(0) var<storage, read_write> work: LongWork;

const MOST = 65535u;

fn arguments(groups: u32) -> array<u32, 3> {
    let sides = folded(groups, MOST);
    return array<u32, 3>(sides.x, sides.y, 1u);
}

@compute @workgroup_size(1)
fn main() {
    let runs = atomicLoad(&work.run_count);
    work.whole_groups = arguments(runs);
    work.run_groups = arguments((runs + WG_SIZE - 1u) / WG_SIZE);
    work.list_groups = arguments((atomicLoad(&work.list_count) + WG_SIZE - 1u) / WG_SIZE);
}
