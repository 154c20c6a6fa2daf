// Every invocation adds what it found to the statistics of the chunk, and lists its large splats with the tiles that
// they meet.
fn list_large(i: u32) {
    let count = tiles_of(i);
    let place = atomicAdd(&stats[push.chunk].large, 1u);
    large[place] = i;
    tile_counts[place] = count;
    // A 64-bit counter made of two words.
    let old = atomicAdd(&stats[push.chunk].tiles_low, count);
    if old + count < old {
        atomicAdd(&stats[push.chunk].tiles_high, 1u);
    }
}

#main {
    view = camera;
    let first = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    let found = project_run(first);
    var waiting = found.waiting;
    while waiting != 0u {
        list_large(first + firstTrailingBit(waiting) * WG_SIZE);
        waiting &= waiting - 1u;
    }
    if found.visible > 0u {
        atomicAdd(&stats[push.chunk].visible, found.visible);
        let old = atomicAdd(&stats[push.chunk].area_low, found.area);
        if old + found.area < old {
            atomicAdd(&stats[push.chunk].area_high, 1u);
        }
        atomicMax(&stats[push.chunk].widest, found.most.x);
        atomicMax(&stats[push.chunk].tallest, found.most.y);
    }
}
