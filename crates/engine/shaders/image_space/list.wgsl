// image-space/list: the tiles that a filter may change into its work list, none left out, or those that another pass
// goes through; their number is the first word of its dispatch. One invocation per tile.
#import tiled
#import dispatch

// Whose list it is: a filter's, or that of what has to be shaded (LIST_RESOLVE) or put into the window (LIST_DELIVER).
override FILTER: u32 = 0u;

@group(0) @binding(0) var<storage, read> tiles: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> entries: array<vec2<u32>>;
// Four words for each run: workgroups in x, y, z.
@group(0) @binding(2) var<storage, read_write> arguments: array<atomic<u32>>;
// Tiles that each filter had, and the last runs of LIST_FILL and LIST_OCCLUSION that had any.
@group(0) @binding(3) var<storage, read_write> totals: array<atomic<u32>>;
#push

struct Around {
    low: f32,
    high: f32,
    background: bool,
    changed: bool,
}

fn is_listed(own: Tile, around: Around) -> bool {
    let any_own = bitcast<u32>(own.x) != INFINITY_BITS;
    let any_around = bitcast<u32>(around.low) != INFINITY_BITS;
    switch FILTER {
        case LIST_FILL: { return (own.z & HAS_BACKGROUND) != 0u && any_around; }
        case LIST_OCCLUSION: { return any_own && bitcast<f32>(own.y) - push.distance >= around.low; }
        case LIST_SMOOTH, LIST_RESOLVE: { return any_own; }
        // Antialiasing gives colors to tiles of background alone.
        case LIST_DELIVER: { return any_own || (own.z & COLOR_SIDE) != 0u; }
        default: {
            // |4 d - sum| is at most four times the range; the rest stands for rounding.
            let range = around.high - around.low + 2e-6 * max(abs(around.low), abs(around.high));
            return any_around && (around.background || range >= 0.9999 * push.threshold * push.distance);
        }
    }
}

#main t {
    if t >= push.columns * push.rows {
        return;
    }
    // Where the run before had no tile nothing has changed since: this one has none either.
    if push.before != 0u && atomicLoad(&arguments[4u * push.before]) == 0u {
        return;
    }
    let slot = 4u * push.slot;
    if t == 0u {
        atomicStore(&arguments[slot + 1u], 1u);
        atomicStore(&arguments[slot + 2u], 1u);
    }
    let own = tiles[t];
    let x = t % push.columns;
    let y = t / push.columns;
    var around = Around(infinity(), -infinity(), false, false);
    var bits = 0u;
    for (var k = 0u; k < 9u; k++) {
        // One more than the column and row.
        let column = x + k % 3u;
        let row = y + k / 3u;
        let inside = column > 0u && column <= push.columns && row > 0u && row <= push.rows;
        let near = tiles[select(t, (row - 1u) * push.columns + column - 1u, inside)];
        around.low = min(around.low, bitcast<f32>(near.x));
        around.high = max(around.high, bitcast<f32>(near.y));
        around.background = around.background || !inside || (near.z & HAS_BACKGROUND) != 0u;
        around.changed = around.changed || near.w == push.before;
        let sides = select(0u, 1u << ENTRY_DEPTHS, (near.z & DEPTH_SIDE) != 0u)
            | select(0u, 1u << ENTRY_COLORS, (near.z & COLOR_SIDE) != 0u);
        let any_near = inside && bitcast<u32>(near.x) != INFINITY_BITS;
        bits |= select(0u, sides << k, inside) | select(0u, 1u << k, any_near);
    }
    if is_listed(own, around) && (push.before == 0u || around.changed) {
        entries[atomicAdd(&arguments[slot], 1u)] = Entry(t, bits);
        if FILTER <= LIST_ANTIALIAS {
            atomicAdd(&totals[FILTER], 1u);
        }
        if FILTER <= LIST_OCCLUSION {
            atomicMax(&totals[LIST_ANTIALIAS + 1u + FILTER], push.slot);
        }
    }
}
