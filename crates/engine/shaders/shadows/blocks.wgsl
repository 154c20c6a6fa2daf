// shadows/blocks: the smallest depth of each square block of a light's image, by atomic minimum of its key; all ones at
// the start. One invocation per RUN pixels of a row.
#import dispatch

@group(0) @binding(0) var<storage, read> nearest: array<u32>;
@group(0) @binding(1) var<storage, read_write> blocks: array<atomic<u32>>;
#push

override RUN: u32 = 32u;

#main i {
    let runs = (push.resolution + RUN - 1u) / RUN;
    let row = i / runs;
    if row >= push.resolution {
        return;
    }
    let first = i % runs * RUN;
    let blocks_above = row / push.block * push.side;
    var block = first / push.block;
    var least = 0xffffffffu;
    for (var x = first; x < min(first + RUN, push.resolution); x++) {
        if x / push.block != block {
            atomicMin(&blocks[blocks_above + block], least);
            block = x / push.block;
            least = 0xffffffffu;
        }
        least = min(least, nearest[row * push.pitch + x]);
    }
    atomicMin(&blocks[blocks_above + block], least);
}
