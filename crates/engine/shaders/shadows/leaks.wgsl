// shadows/leaks: counts the holes that the filters left in the surfaces of a light's image, and those through which
// points behind are seen. A block has a surface if it and the eight around it have points: the farthest of their
// nearest depths. One invocation per RUN pixels of a row. Reference: reference::shadows::holes.
#import dispatch

// Depths after the filters, +inf where there is nothing.
@group(0) @binding(0) var<storage, read> depths: array<f32>;
// Keys of the smallest depths of blocks, all ones where there is nothing.
@group(0) @binding(1) var<storage, read> blocks: array<u32>;
// Pixels with a surface, holes among them, pixels that show points, holes that do.
@group(0) @binding(2) var<storage, read_write> counts: array<atomic<u32>>;
#push

override RUN: u32 = 32u;

const NOTHING = 0xffffffffu;

// The key of the surface in a block; all ones without one.
fn surface(column: u32, row: u32) -> u32 {
    // Blocks at the border have none on one side.
    if column == 0u || row == 0u || column + 1u >= push.side || row + 1u >= push.side {
        return NOTHING;
    }
    var farthest = 0u;
    for (var k = 0u; k < 9u; k++) {
        farthest = max(farthest, blocks[(row + k / 3u - 1u) * push.side + column + k % 3u - 1u]);
    }
    return farthest;
}

#main i {
    let runs = (push.resolution + RUN - 1u) / RUN;
    let row = i / runs;
    if row >= push.resolution {
        return;
    }
    let first = i % runs * RUN;
    var block = first / push.block;
    var key = surface(block, row / push.block);
    var found = vec4<u32>(0u);
    for (var x = first; x < min(first + RUN, push.resolution); x++) {
        if x / push.block != block {
            block = x / push.block;
            key = surface(block, row / push.block);
        }
        let word = bitcast<u32>(depths[row * push.pitch + x]);
        let is_covered = key != NOTHING;
        let is_shown = is_covered && word != 0x7f800000u;
        let is_hole = is_covered && bitcast<f32>(word) > bitcast<f32>(key & 0x7fffffffu) + push.apart;
        found += select(vec4<u32>(0u), vec4<u32>(1u), vec4<bool>(is_covered, is_hole, is_shown, is_shown && is_hole));
    }
    if found.x != 0u {
        atomicAdd(&counts[0], found.x);
        atomicAdd(&counts[1], found.y);
        atomicAdd(&counts[2], found.z);
        atomicAdd(&counts[3], found.w);
    }
}
