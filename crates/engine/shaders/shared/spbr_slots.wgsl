// Goes through slots: WG_SIZE * RUN of them per workgroup. Squares of more than SMALL_SQUARE pixels are put on a list.
#import spbr_squares

#main {
    view = camera;
    let start = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    var visible = 0u;
    // One bit for each step: invocations in step would all take both ways.
    var unsure = 0u;
    for (var k = 0u; k < RUN; k++) {
        let n = start + k * WG_SIZE;
        if n < push.count {
            let slot = slot_of(n);
            let hit = quick_hit(slot);
            if hit.seen {
                cover_pixels(slot, hit);
                visible += 1u;
            }
            unsure |= u32(hit.unsure) << k;
        }
    }
    count_visible(visible + show_unsure(start, unsure));
}
