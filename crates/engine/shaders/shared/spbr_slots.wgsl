// Goes through slots: WG_SIZE * RUN of them per workgroup. Squares of more than SMALL_SQUARE pixels are put on a list.

// Slots of one invocation, at most 32.
override RUN: u32 = 8u;

fn cover_pixels(slot: Slot, hit: Hit) {
    let width = view.window.z - view.window.x;
    if SQUARES == 0u {
        visit(slot.point, slot.plane, hit.key, window_index(vec2<u32>(hit.low), view.window));
        return;
    }
    let size = vec2<u32>(hit.high - hit.low);
    if size.x * size.y > SMALL_SQUARE {
        let place = 2u * atomicAdd(&counters[0].large, 1u);
        // The host took room for every slot, or found no such square.
        if place + 1u < arrayLength(&large) {
            large[place] = vec4<u32>(slot.point, slot.plane, hit.key, 0u);
            large[place + 1u] = vec4<u32>(vec2<u32>(hit.low), vec2<u32>(hit.high));
        }
        return;
    }
    var row = window_index(vec2<u32>(hit.low), view.window);
    var column = 0u;
    var left = size.x * size.y;
    // The condition stands at the end: most squares are one pixel, and a loop with it at the top runs once more.
    loop {
        visit(slot.point, slot.plane, hit.key, row + column);
        column += 1u;
        if column == size.x {
            column = 0u;
            row += width;
        }
        left -= 1u;
        continuing {
            break if left == 0u;
        }
    }
}

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
    while unsure != 0u {
        let slot = slot_of(start + firstTrailingBit(unsure) * WG_SIZE);
        let hit = exact_hit(slot);
        if hit.seen {
            cover_pixels(slot, hit);
            visible += 1u;
        }
        unsure &= unsure - 1u;
    }
    if COUNTED != 0u && visible > 0u {
        let before = atomicAdd(&counters[0].visible_low, visible);
        if before + visible < before {
            atomicAdd(&counters[0].visible_high, 1u);
        }
    }
}

// 1: drawn points are counted, by the first pass that meets them.
override COUNTED: u32 = 0u;
