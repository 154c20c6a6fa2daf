// shadows/fill: the occlusion filter over a light's image (Dobrev et al. 2010, Sections 3 and 6): a pixel that shows
// what lies behind through a hole in a surface takes the depth of the surface. Background stays. One invocation per
// four columns and RUN rows.
#import dispatch

// Keys of depths, which are positive; all ones where there is nothing. Rows of a multiple of four columns.
@group(0) @binding(0) var<storage, read> nearest: array<vec4<u32>>;
// Depths, +inf where there is nothing.
@group(0) @binding(1) var<storage, read_write> depths: array<vec4<f32>>;
#push

override RUN: u32 = 8u;

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
    let keys = nearest[select(0u, place, inside)];
    let none = keys == vec4<u32>(0xffffffffu);
    return select(bitcast<vec4<f32>>(keys & vec4<u32>(0x7fffffffu)), nothing(), none | vec4<bool>(!inside));
}

fn row_at(column: u32, row: u32, inside: bool) -> Row {
    let place = row * push.columns + column;
    let own = depths_at(place, inside);
    let before = depths_at(place - 1u, inside && column > 0u);
    let after = depths_at(place + 1u, inside && column + 1u < push.columns);
    return Row(vec4<f32>(before.w, own.xyz), own, vec4<f32>(own.yzw, after.x));
}

fn filled(above: Row, here: Row, below: Row) -> vec4<f32> {
    let limit = here.own - push.apart;
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
    let on_edge = (ab & cd & e) | (bc & de & f) | (cd & ef & g) | (de & fg & h)
        | (ef & gh & a) | (fg & ha & b) | (gh & ab & c) | (ha & bc & d);
    let rows = min(min(above.own, here.own), below.own);
    let sides = min(min(above.left, above.right), min(below.left, below.right));
    let least = min(min(rows, sides), min(here.left, here.right));
    return select(least, here.own, on_edge | (here.own == nothing()));
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
        depths[row * push.columns + column] = filled(above, here, below);
        above = here;
        here = below;
    }
}
