// Walkers over slots share this: an invocation that walks a square by itself, the list of squares too large for that,
// slots whose place is in doubt, and the count of drawn points.

// Slots of one invocation, at most 32.
override RUN: u32 = 8u;
// Pixels of a square at most that is not put on the list.
override SMALL_SQUARE: u32 = 64u;
// 1: drawn points are counted, by the first pass that meets them.
override COUNTED: u32 = 0u;

fn cover_pixels(slot: Slot, hit: Hit) {
    let width = view.window.z - view.window.x;
    if SQUARES == 0u {
        visit(slot.point, slot.plane, hit.key, window_index(vec2<u32>(hit.low), view.window));
        return;
    }
    let size = vec2<u32>(hit.high - hit.low);
    if size.x * size.y > SMALL_SQUARE {
        list_square(slot, hit);
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

fn list_square(slot: Slot, hit: Hit) {
    let place = 2u * atomicAdd(&counters[0].large, 1u);
    // The host took room for every slot, or found no such square.
    if place + 1u < arrayLength(&large) {
        large[place] = vec4<u32>(slot.point, slot.plane, hit.key, 0u);
        large[place + 1u] = vec4<u32>(vec2<u32>(hit.low), vec2<u32>(hit.high));
    }
}

// Shows those of an invocation's slots whose place is in doubt, one bit for each; returns how many are seen.
fn show_unsure(start: u32, slots: u32) -> u32 {
    var unsure = slots;
    var visible = 0u;
    while unsure != 0u {
        let slot = slot_of(start + firstTrailingBit(unsure) * WG_SIZE);
        let hit = exact_hit(slot);
        if hit.seen {
            cover_pixels(slot, hit);
            visible += 1u;
        }
        unsure &= unsure - 1u;
    }
    return visible;
}

fn count_visible(visible: u32) {
    if COUNTED != 0u && visible > 0u {
        let before = atomicAdd(&counters[0].visible_low, visible);
        if before + visible < before {
            atomicAdd(&counters[0].visible_high, 1u);
        }
    }
}
