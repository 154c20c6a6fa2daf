// A tile in the hands of one subgroup: BLOCKS x BLOCKS blocks of 8 x 8 pixels, of each of which every invocation holds
// the same few. Splats are taken one per invocation; a ballot says which of them may touch a block, and these are
// handed to all invocations one by one by shuffles. The stage binds `view`.
#import splat
#import middle
#import sample_place

// Pixels of a block that an invocation holds, blocks of a tile in x and y.
const HELD = BLOCK_SIDE * BLOCK_SIDE / SUBGROUP;
const BLOCKS = TILE_SIDE / BLOCK_SIDE;

fn block_corner(block: u32) -> vec2<u32> {
    return vec2<u32>(block % BLOCKS, block / BLOCKS) * BLOCK_SIDE;
}

// Where in the tile this invocation's first pixel lies. The others follow in steps of SUBGROUP, row by row in a block.
fn first_place(lane: u32) -> vec2<u32> {
    return vec2<u32>(lane % BLOCK_SIDE, lane / BLOCK_SIDE);
}

// How far a splat may reach from its center, in pixels: a disc its radius. An oriented one lies within a ball of that
// radius, which perspective stretches: the offset of a point u on it is f (u.xy - c.xy / z u.z) / (z + u.z).
fn reach_of(splat: Splat) -> f32 {
    if SHAPE != SHAPE_ORIENTED || view.orthographic != 0u {
        return splat.radius;
    }
    let of_depth = splat.radius / view.focal.x;
    let axis = (vec2<f32>(center_pixel(splat)) + vec2<f32>(splat.fraction_x, splat.fraction_y) - middle_of_image()) / view.focal.x;
    let stretched = splat.radius * sqrt(1.0 + dot(axis, axis)) / (1.0 - of_depth);
    // Close to the eye it may be seen anywhere.
    return select(1e9, stretched, of_depth < 0.9);
}

// True if a screen-aligned splat reaches so far out, give or take rounding, which grows with `middle`. The samples that
// are always covered lie at most 0.71 of the picture's pixels away.
fn reaches(outside: vec2<f32>, radius: f32, middle: vec2<f32>) -> bool {
    let reach = max(radius, 0.75 * columns_of_pixel()) + 1e-5 * (radius + abs(middle.x) + abs(middle.y));
    if SHAPE == SHAPE_SQUARE {
        return all(outside <= vec2<f32>(reach));
    }
    return dot(outside, outside) <= reach * reach;
}

// True if a splat may touch a block, give or take rounding.
fn touches(splat: Splat, low: vec2<u32>) -> bool {
    let half = 0.5 * f32(BLOCK_SIDE - 1u);
    let middle = vec2<f32>(vec2<i32>(low) - center_pixel(splat)) - vec2<f32>(splat.fraction_x, splat.fraction_y) + half + 0.5;
    let outside = max(abs(middle) - (half + most_aside()), vec2<f32>(0.0));
    let radius = reach_of(splat);
    return reaches(outside, radius, middle);
}
