// The filters that close holes of a light's image (Dobrev et al. 2010, Sections 3.2, 3.3 and 6): pixels that no mask
// keeps take the depth of the nearest of the 3 x 3 around them. A filter says which pixels it looks at, and beyond
// which depth neighbors keep one: is_looked_at(depths) and floor_of(depths). One invocation per four columns and RUN
// rows. Reference: reference::image_space::Layer::filled and occluded_replaced.
#import dispatch

// Depths, +inf where there is nothing; before the first filter keys of depths, which are positive, all ones where there
// is nothing. Rows of a multiple of four columns.
@group(0) @binding(0) var<storage, read> before: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> depths: array<vec4<f32>>;
#push

override RUN: u32 = 8u;
// 1: before the first filter.
override KEYS: u32 = 0u;

// Depths of four pixels of a row, with those to their left and right.
struct Row {
    left: vec4<f32>,
    own: vec4<f32>,
    right: vec4<f32>,
}

fn nothing() -> vec4<f32> {
    return vec4<f32>(bitcast<f32>(0x7f800000u));
}

fn depths_at(place: u32, inside: bool) -> vec4<f32> {
    let words = before[select(0u, place, inside)];
    let none = vec4<bool>(KEYS != 0u) & (words == vec4<u32>(0xffffffffu));
    return select(bitcast<vec4<f32>>(words & vec4<u32>(0x7fffffffu)), nothing(), none | vec4<bool>(!inside));
}

fn row_at(column: u32, row: u32, inside: bool) -> Row {
    let place = row * push.columns + column;
    let own = depths_at(place, inside);
    let left = depths_at(place - 1u, inside && column > 0u);
    let right = depths_at(place + 1u, inside && column + 1u < push.columns);
    return Row(vec4<f32>(left.w, own.xyz), own, vec4<f32>(own.yzw, right.x));
}

fn filtered(above: Row, here: Row, below: Row) -> vec4<f32> {
    let limit = floor_of(here.own);
    // The ring, clockwise from the upper left corner: what lies behind, background too.
    let a = above.left > limit;
    let b = above.own > limit;
    let c = above.right > limit;
    let d = here.right > limit;
    let e = below.right > limit;
    let f = below.own > limit;
    let g = below.left > limit;
    let h = here.left > limit;
    // Five in a row.
    let ab = a & b;
    let cd = c & d;
    let ef = e & f;
    let gh = g & h;
    let bc = b & c;
    let de = d & e;
    let fg = f & g;
    let ha = h & a;
    let is_kept = (ab & cd & e) | (bc & de & f) | (cd & ef & g) | (de & fg & h)
        | (ef & gh & a) | (fg & ha & b) | (gh & ab & c) | (ha & bc & d);
    let rows = min(min(above.own, here.own), below.own);
    let sides = min(min(above.left, above.right), min(below.left, below.right));
    let least = min(min(rows, sides), min(here.left, here.right));
    return select(here.own, least, is_looked_at(here.own) & !is_kept);
}

#main i {
    let column = i % push.columns;
    let first = i / push.columns * RUN;
    if first >= push.rows {
        return;
    }
    var above = row_at(column, first - 1u, first > 0u);
    var here = row_at(column, first, true);
    for (var row = first; row < min(first + RUN, push.rows); row++) {
        let below = row_at(column, row + 1u, row + 1u < push.rows);
        depths[row * push.columns + column] = filtered(above, here, below);
        above = here;
        here = below;
    }
}
