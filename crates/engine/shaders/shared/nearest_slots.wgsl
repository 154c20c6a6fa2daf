// Finds each pixel's SLOTS smallest ranks of depth key and index, in order, by 64-bit atomic minima; all ones at the
// start. A rank goes to the first slot that holds a larger one, and the displaced rank to the slots behind. Each slot
// ends with the smallest rank that reached it, so that the order of arrival cannot show.
@group(0) @binding(NEAREST_BINDING) var<storage, read_write> nearest: array<atomic<u64>>;
override SLOTS: u32 = 1u;

// As in shared/nearest_wide.
fn offer(pixel: u32, key: u32, id: u32) -> u32 {
    let first = SLOTS * pixel;
    let end = first + SLOTS;
    var rank = (u64(key) << 32u) | u64(id);
    // Reading is cheaper than an atomic. Slots only fall: a rank behind the last one now is behind it in the end.
    if atomicLoad(&nearest[end - 1u]) < rank {
        return 1u;
    }
    for (var slot = first; slot < end; slot++) {
        if atomicLoad(&nearest[slot]) < rank {
            continue;
        }
        rank = max(rank, atomicMin(&nearest[slot], rank));
        // Nothing was displaced but an empty slot.
        if u32(rank >> 32u) == 0xffffffffu {
            break;
        }
    }
    return 1u;
}
