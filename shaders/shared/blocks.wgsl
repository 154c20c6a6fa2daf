// A tile in the hands of one subgroup: BLOCKS x BLOCKS blocks of 8 x 8 pixels, of each of which every invocation holds the
// same few. Splats are taken one per invocation; a ballot says which of them may touch a block, and these are handed to
// all invocations one by one by shuffles.
#import splat

// Side of a block, pixels of a block that an invocation holds, blocks of a tile in x and y.
const SIDE = 8u;
const HELD = SIDE * SIDE / SUBGROUP;
const BLOCKS = TILE_SIDE / SIDE;

fn block_corner(block: u32) -> vec2<u32> {
    return vec2<u32>(block % BLOCKS, block / BLOCKS) * SIDE;
}

// Where in the tile the i-th pixel lies that this invocation holds.
fn place(lane: u32, i: u32) -> vec2<u32> {
    let within = lane + SUBGROUP * (i % HELD);
    return vec2<u32>(within % SIDE, within / SIDE) + block_corner(i / HELD);
}

// Whether a splat may touch a block. A disc lies within its radius around its centre, give or take rounding; an oriented
// one does not quite in perspective, and is handed to every block.
fn touches(splat: Splat, low: vec2<u32>) -> bool {
    if SHAPE == SHAPE_ORIENTED {
        return true;
    }
    let half = 0.5 * f32(SIDE - 1u);
    let middle = vec2<f32>(vec2<i32>(low) - center_pixel(splat)) - vec2<f32>(splat.fraction_x, splat.fraction_y) + half + 0.5;
    let outside = max(abs(middle) - half, vec2<f32>(0.0));
    // The pixel of the centre lies at most 0.71 away.
    let reach = max(splat.radius, 0.75) + 1e-5 * (splat.radius + abs(middle.x) + abs(middle.y));
    return dot(outside, outside) <= reach * reach;
}
