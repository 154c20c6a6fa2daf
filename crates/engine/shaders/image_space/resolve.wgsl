// image-space/resolve: index of each pixel's nearest point to its color, shaded here and not before, and depth. One
// workgroup per listed tile, one invocation per column and STRIP of rows.
#import all_points
#import tiled
#import dispatch

// Index and depth key.
@group(0) @binding(17) var<storage, read> nearest: array<vec2<u32>>;
@group(0) @binding(18) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(19) var<storage, read_write> depths: array<f32>;
@group(0) @binding(20) var<storage, read_write> colors: array<vec4<f32>>;
#push

// 1: colors are premultiplied by the points' opacities; else they are opaque.
override TRANSPARENT: u32 = 0u;

const NOTHING = 0xffffffffu;

fn opacity_of(i: u32) -> f32 {
    if TRANSPARENT == 0u {
        return 1.0;
    }
    return min(lo_at(i).w * view.opacity_factor, 1.0);
}

#main {
    view = camera;
    let size = vec2<u32>(push.width, push.height);
    let tile = entries[workgroup_index(workgroup, groups)].x;
    let corner = vec2<u32>(tile % push.columns, tile / push.columns) * TILE;
    let column = local % TILE;
    let first_row = local / TILE * STRIP;
    for (var i = 0u; i < STRIP; i++) {
        let at = vec2<u32>(column, first_row + i);
        let pixel = corner + at;
        let inside = all(pixel < size);
        let found = nearest[select(0u, pixel.y * size.x + pixel.x, inside)];
        let hit = inside && found.y != NOTHING;
        var color = vec4<f32>(BACKGROUND_ALPHA);
        if hit {
            let alpha = opacity_of(found.x);
            color = vec4<f32>(alpha * color_of(found.x), alpha);
        }
        let place = tile * AREA + at.y * TILE + at.x;
        colors[place] = color;
        depths[place] = select(infinity(), key_depth(found.y), hit);
    }
}
