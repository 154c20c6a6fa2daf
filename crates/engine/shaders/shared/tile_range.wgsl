// Range of depths and marks that a workgroup finds in its tile.
#import tiled

var<workgroup> lowest: atomic<u32>;
var<workgroup> highest: atomic<u32>;
var<workgroup> marks: atomic<u32>;

const NO_KEY = 0xffffffffu;
// Beside HAS_BACKGROUND.
const CHANGED = 8u;

fn begin_range(local: u32) {
    if local == 0u {
        atomicStore(&lowest, NO_KEY);
        atomicStore(&highest, 0u);
        atomicStore(&marks, 0u);
    }
    workgroupBarrier();
}

// Smallest and largest key of an invocation's pixels, NO_KEY and 0 if all are background, and its marks.
fn add_range(low: u32, high: u32, marked: u32) {
    if low != NO_KEY {
        atomicMin(&lowest, low);
        atomicMax(&highest, high);
    }
    if marked != 0u {
        atomicOr(&marks, marked);
    }
    workgroupBarrier();
}

// The tile once all have added theirs.
fn found_tile(flags: u32, changed: u32) -> Tile {
    let low = atomicLoad(&lowest);
    let nothing = low == NO_KEY;
    let low_bits = select(bitcast<u32>(key_depth(low)), INFINITY_BITS, nothing);
    let high_bits = select(bitcast<u32>(key_depth(atomicLoad(&highest))), INFINITY_BITS | 0x80000000u, nothing);
    return Tile(low_bits, high_bits, flags, changed);
}
