// Images in tiles of TILE × TILE pixels, a tile's pixels row by row, for filters that run over a list of tiles: what
// they share. There are two places for each tile, the sides. A filter reads a tile and what surrounds it from the sides
// that hold the image, and writes the tile's other side, which holds the image from the next filter on; whoever is not
// listed stays where it is. Colors and depths have sides of their own, since some filters change colors alone. Behind
// both sides lies one pixel more, which is background: all that is outside.
#import splat

const AREA = TILE * TILE;
// Rows of a tile that an invocation takes, one after the other, so that loaded values serve again.
const STRIP = 4u;
const INFINITY_BITS = 0x7f800000u;

// A tile: bits of the smallest and the largest depth of what is not background (+inf, -inf if there is nothing), flags,
// and the run of a filter that last changed it. A vector, which is loaded at once.
alias Tile = vec4<u32>;
// Some pixel within the rectangle in work is background.
const HAS_BACKGROUND = 1u;
// The sides that hold its depths and its colors.
const DEPTH_SIDE = 2u;
const COLOR_SIDE = 4u;

// A tile of a work list: its number, and a bit for each of the 3 × 3 tiles around it, row by row: whether there is such
// a tile with anything in it, from ENTRY_DEPTHS on the side of its depths, from ENTRY_COLORS on that of its colors.
// What a tile of background alone has in memory nobody reads.
alias Entry = vec2<u32>;
const ENTRY_DEPTHS = 9u;
const ENTRY_COLORS = 18u;

fn is_background(depth: f32) -> bool {
    return bitcast<u32>(depth) == INFINITY_BITS;
}

fn infinity() -> f32 {
    var bits = INFINITY_BITS;
    return bitcast<f32>(bits);
}

// Place of a tile's pixel on a side.
fn pixel_place(tile: u32, tiles: u32, side: u32, x: u32, y: u32) -> u32 {
    return (side * tiles + tile) * AREA + y * TILE + x;
}
