// abuffer/sort-blocks: sorts each block of BLOCK fragments of a long list where it lies. One invocation per list; the host
// writes the network out, as for the short lists. First step of sorting in place.
#import long_list
#import fragments
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> runs: array<ListRun>;
@group(0) @binding(2) var<storage, read> lists: array<LongList>;
@group(0) @binding(3) var<storage, read_write> fragments: array<vec2<u32>>;

// Behind everything beyond the list's end.
fn slot(i: u32, end: u32) -> vec2<u32> {
    return select(vec2<u32>(0xffffffffu), fragments[min(i, end - 1u)], i < end);
}

fn put(i: u32, end: u32, fragment: vec2<u32>) {
    if i < end {
        fragments[i] = fragment;
    }
}

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let item = invocation_index(workgroup, groups, local);
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = runs[lists[item].first_run];
    let end = list.start + list.length;
    for (var block = list.start; block < end; block += BLOCK) {
#repeat         var x{i} = slot(block + {i}u, end);
#comparators
#repeat         put(block + {i}u, end, x{i});
    }
}
