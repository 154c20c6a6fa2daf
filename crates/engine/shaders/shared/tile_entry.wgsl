// Entries of the tiles' lists: a splat's index, and which of the tile's 2 x 2 blocks of pixels its rectangle meets.
// One bit for each block of a tile that a rectangle meets which meets the tile, given the tile's first pixel.
fn blocks_met(rectangle: vec2<u32>, first: vec2<u32>) -> u32 {
    let middle = first + BLOCK_SIDE;
    let before = (rectangle & vec2<u32>(0xffffu)) < middle;
    let behind = (rectangle >> vec2<u32>(16u)) > middle;
    let columns = select(0u, 1u, before.x) | select(0u, 2u, behind.x);
    return select(0u, columns, before.y) | select(0u, columns << 2u, behind.y);
}

fn entry_of(index: u32, rectangle: vec2<u32>, first: vec2<u32>) -> u32 {
    return index | blocks_met(rectangle, first) << INDEX_BITS;
}
