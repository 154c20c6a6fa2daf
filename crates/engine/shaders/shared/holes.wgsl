// The filters that close holes (Dobrev et al. 2010, Sections 3.2 and 3.3): pixels that no mask keeps take the values of
// the nearest of the 3 × 3 around them. A filter says which pixels it looks at, and beyond which depth neighbors keep
// one: is_looked_at(depth) and floor_of(depth).
#import filter
#import tile_range

// True if five consecutive ones of the ring of eight are set: one of the eight masks.
fn is_kept(ring: u32) -> bool {
    let round = ring | (ring << 8u);
    let two = round & (round >> 1u);
    let four = two & (two >> 2u);
    return (four & (round >> 4u) & 0xffu) != 0u;
}

fn bit(is_set: bool, place: u32) -> u32 {
    return select(0u, 1u << place, is_set);
}

// Lexicographic, as the order among equal depths.
fn color_before(a: vec4<f32>, b: vec4<f32>) -> bool {
    if a.x != b.x {
        return a.x < b.x;
    }
    if a.y != b.y {
        return a.y < b.y;
    }
    if a.z != b.z {
        return a.z < b.z;
    }
    return a.w < b.w;
}

// The color of the first of some pixels around one, of equal depth: bits row by row, at least one of them.
fn first_color(entry: Entry, x: i32, y: i32, which: u32) -> vec4<f32> {
    var rest = which;
    var best = vec4<f32>(0.0);
    var any_yet = false;
    // The condition stands at the head: where it ends a turn, one driver goes on computing `best` for pixels that are
    // done.
    while rest != 0u {
        let k = i32(firstTrailingBit(rest));
        let color = color_at(entry, x + k % 3 - 1, y + k / 3 - 1);
        let take = !any_yet || color_before(color, best);
        best = select(best, color, take);
        any_yet = true;
        rest &= rest - 1u;
    }
    return best;
}

fn depth_row(entry: Entry, x: i32, y: i32) -> vec3<f32> {
    return vec3<f32>(depth_at(entry, x - 1, y), depth_at(entry, x, y), depth_at(entry, x + 1, y));
}

fn filter_tile(entry: Entry, column: u32, first_row: u32, local: u32) {
    begin_range(local);
    let x = i32(column);
    let corner = vec2<u32>(entry.x % p.columns, entry.x / p.columns) * TILE;
    var above = depth_row(entry, x, i32(first_row) - 1);
    var here = depth_row(entry, x, i32(first_row));
    var low = NO_KEY;
    var high = 0u;
    var marked = 0u;
    for (var i = 0u; i < STRIP; i++) {
        let row = first_row + i;
        let below = depth_row(entry, x, i32(row) + 1);
        let own = here.y;
        let limit = floor_of(own);
        // In the order of the ring.
        let ring = bit(above.x > limit, 0u) | bit(above.y > limit, 1u) | bit(above.z > limit, 2u)
            | bit(here.z > limit, 3u) | bit(below.z > limit, 4u) | bit(below.y > limit, 5u)
            | bit(below.x > limit, 6u) | bit(here.x > limit, 7u);
        let replaced = is_looked_at(own) && !is_kept(ring);
        let least = min(min(above, here), below);
        let nearest = min(min(least.x, least.y), least.z);
        let as_near = bit(above.x == nearest, 0u) | bit(above.y == nearest, 1u) | bit(above.z == nearest, 2u)
            | bit(here.x == nearest, 3u) | bit(own == nearest, 4u) | bit(here.z == nearest, 5u)
            | bit(below.x == nearest, 6u) | bit(below.y == nearest, 7u) | bit(below.z == nearest, 8u);
        let depth = select(own, nearest, replaced);
        let color = first_color(entry, x, i32(row), select(1u << 4u, as_near, replaced));
        depths[write_place(entry, ENTRY_DEPTHS, column, row)] = depth;
        colors[write_place(entry, ENTRY_COLORS, column, row)] = color;
        let key = depth_key(depth);
        if is_background(depth) {
            let inside = corner.x + column < p.width && corner.y + row < p.height;
            marked |= select(0u, HAS_BACKGROUND, inside);
        } else {
            low = min(low, key);
            high = max(high, key);
        }
        marked |= select(0u, CHANGED, replaced);
        above = here;
        here = below;
    }
    add_range(low, high, marked);
    if local == 0u {
        let found = atomicLoad(&marks);
        // A tile without a changed pixel stays where it was, and so does its entry.
        if (found & CHANGED) != 0u {
            let depth_side = 1u - ((entry.y >> (4u + ENTRY_DEPTHS)) & 1u);
            let color_side = 1u - ((entry.y >> (4u + ENTRY_COLORS)) & 1u);
            let flags = (found & HAS_BACKGROUND) | depth_side * DEPTH_SIDE | color_side * COLOR_SIDE;
            tiles[entry.x] = found_tile(flags, p.run);
        }
    }
}
