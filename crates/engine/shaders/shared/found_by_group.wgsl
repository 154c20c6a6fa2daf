// The invocations of a workgroup add what they found in the memory that they share, and one of them adds that to the
// statistics of the chunk: a GPU takes atomics on the same word of its memory one by one. As shared/found_alone.wgsl
// otherwise.
var<workgroup> group_visible: atomic<u32>;
var<workgroup> group_large: atomic<u32>;
var<workgroup> group_most: array<atomic<u32>, 2>;
// 64-bit counters made of two words.
var<workgroup> group_area: array<atomic<u32>, 2>;
var<workgroup> group_tiles: array<atomic<u32>, 2>;
// Where the workgroup's large splats begin among those of the chunk.
var<workgroup> group_first: u32;

fn begin_group(local: u32) {
    if local == 0u {
        atomicStore(&group_visible, 0u);
        atomicStore(&group_large, 0u);
    }
    if local < 2u {
        atomicStore(&group_most[local], 0u);
        atomicStore(&group_area[local], 0u);
        atomicStore(&group_tiles[local], 0u);
    }
    workgroupBarrier();
}

// Adds what the group found to the statistics of the chunk.
fn end_group() {
    atomicAdd(&stats[push.chunk].visible, atomicLoad(&group_visible));
    atomicMax(&stats[push.chunk].widest, atomicLoad(&group_most[0]));
    atomicMax(&stats[push.chunk].tallest, atomicLoad(&group_most[1]));
    let area = atomicLoad(&group_area[0]);
    let old_area = atomicAdd(&stats[push.chunk].area_low, area);
    let area_high = atomicLoad(&group_area[1]) + u32(old_area + area < old_area);
    if area_high > 0u {
        atomicAdd(&stats[push.chunk].area_high, area_high);
    }
    if atomicLoad(&group_large) > 0u {
        group_first = atomicAdd(&stats[push.chunk].large, atomicLoad(&group_large));
        let tiles = atomicLoad(&group_tiles[0]);
        let old_tiles = atomicAdd(&stats[push.chunk].tiles_low, tiles);
        let tiles_high = atomicLoad(&group_tiles[1]) + u32(old_tiles + tiles < old_tiles);
        if tiles_high > 0u {
            atomicAdd(&stats[push.chunk].tiles_high, tiles_high);
        }
    }
}

#main {
    view = camera;
    begin_group(local);
    let first = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    let found = project_run(first);
    var place = 0u;
    if found.visible > 0u {
        atomicAdd(&group_visible, found.visible);
        atomicMax(&group_most[0], found.most.x);
        atomicMax(&group_most[1], found.most.y);
        let old = atomicAdd(&group_area[0], found.area);
        if old + found.area < old {
            atomicAdd(&group_area[1], 1u);
        }
    }
    if found.waiting != 0u {
        place = atomicAdd(&group_large, countOneBits(found.waiting));
    }
    for (var waiting = found.waiting; waiting != 0u; waiting &= waiting - 1u) {
        let count = tiles_of(first + firstTrailingBit(waiting) * WG_SIZE);
        let old = atomicAdd(&group_tiles[0], count);
        if old + count < old {
            atomicAdd(&group_tiles[1], 1u);
        }
    }
    workgroupBarrier();
    if local == 0u && atomicLoad(&group_visible) > 0u {
        end_group();
    }
    workgroupBarrier();
    place += group_first;
    for (var waiting = found.waiting; waiting != 0u; waiting &= waiting - 1u) {
        let i = first + firstTrailingBit(waiting) * WG_SIZE;
        large[place] = i;
        tile_counts[place] = tiles_of(i);
        place += 1u;
    }
}
