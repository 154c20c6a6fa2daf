// Bindings of the passes that meet drawn splats with tiles.
#import splat

@group(0) @binding(0) var<uniform> view: View;
// Splats in order: key, and index.
@group(0) @binding(1) var<storage, read> records: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> bounds: array<Bounds>;
#push

// A splat's rectangle; nothing for a record without a splat, which stands behind the others.
fn rectangle_of(index: u32) -> vec2<u32> {
    return select(vec2<u32>(0u), bounds[min(index, arrayLength(&bounds) - 1u)], index < arrayLength(&bounds));
}

// First column and row of tiles that a rectangle meets, and one past the last ones; tiles start at `corner`.
fn tiles_of(rect: vec2<u32>, corner: vec2<u32>) -> vec4<u32> {
    let low = (vec2<u32>(rect.x & 0xffffu, rect.y & 0xffffu) - corner) / TILE_SIDE;
    let high = (vec2<u32>(rect.x >> 16u, rect.y >> 16u) - 1u - corner) / TILE_SIDE + 1u;
    return vec4<u32>(low, high);
}
