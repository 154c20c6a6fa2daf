// Output of projections of points: splats, their rectangles, and the statistics of a chunk. The stage defines
// project(i), which projects a point and returns columns and rows of its rectangle, and imports a walker behind that.
#import splat
#import stats
#import camera
#import sample_place

@group(0) @binding(6) var<storage, read_write> splats: array<PackedSplat>;
@group(0) @binding(7) var<storage, read_write> tilts: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> bounds: array<Bounds>;
@group(0) @binding(9) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> large: array<u32>;
@group(0) @binding(11) var<storage, read_write> tile_counts: array<u32>;
@group(0) @binding(12) var<storage, read_write> stats: array<Stats>;
@group(0) @binding(13) var<storage, read_write> splat_depths: array<f32>;
#push

// Points of one invocation, at most 32.
override RUN: u32 = 8u;

fn put_splat(i: u32, splat: Splat, tilt: Tilt) {
    splats[i] = pack_splat(splat);
    splat_depths[i] = splat.depth;
    if has_tilts() {
        tilts[tilt_stride() * i] = tilt.normal;
    }
    if tilt_stride() == 2u {
        tilts[tilt_stride() * i + 1u] = tilt.rest;
    }
}

// First column and row of the rectangle of pixels that lie so far to the left, top, right and bottom of the center, and
// one past the last; zero if it misses the part of the image in work. `always`: with the center's own pixel in any
// case.
fn rectangle_of(splat: Splat, reach: vec4<f32>, always: bool) -> vec4<u32> {
    let pixel = center_pixel(splat);
    let fraction = vec2<f32>(splat.fraction_x, splat.fraction_y);
    // Pixel i of the neighborhood has its sample at i + 0.5, or up to `most` away from there.
    let limit = vec2<f32>(65536.0);
    let most = most_aside();
    let low = pixel + vec2<i32>(clamp(ceil(fraction - reach.xy - 0.5 - most), -limit, limit));
    let high = pixel + vec2<i32>(clamp(floor(fraction + reach.zw - 0.5 + most), -limit, limit));
    var first = pixel;
    var last = pixel;
    if QUARTERS != 0u {
        // Quarters of the pixel of the picture that contains the center, as it is moved for each of their images.
        first -= select(vec2<i32>(0), vec2<i32>(1), fraction <= vec2<f32>(0.5 + most));
        last += select(vec2<i32>(0), vec2<i32>(1), fraction >= vec2<f32>(0.5 - most));
    }
    let window_low = vec2<i32>(view.window.xy);
    let window_high = vec2<i32>(view.window.zw);
    let l = vec2<u32>(clamp(select(low, min(low, first), always), window_low, window_high));
    let h = vec2<u32>(clamp(select(high, max(high, last), always) + 1, window_low, window_high));
    return select(vec4<u32>(0u), vec4<u32>(l, h), all(l < h));
}

// Number of tiles that a large splat meets.
fn tiles_of(i: u32) -> u32 {
    let rect = bounds[i];
    let first = (bounds_min(rect) - view.window.xy) / TILE;
    let last = (bounds_max(rect) - 1u - view.window.xy) / TILE;
    let tiles = last - first + 1u;
    return tiles.x * tiles.y;
}

// Statistics of an invocation's points.
struct Found {
    visible: u32,
    // Most columns and rows.
    most: vec2<u32>,
    // Pixels of all rectangles.
    area: u32,
    // Large splats wait in a mask, one bit for each step: invocations in step would all go through the listing.
    waiting: u32,
}

// Projects every WG_SIZE-th point from the first on.
fn project_run(first: u32) -> Found {
    var found = Found(0u, vec2<u32>(0u), 0u, 0u);
    for (var k = 0u; k < RUN; k++) {
        let i = first + k * WG_SIZE;
        if i < push.count {
            let extent = project(i);
            let area = extent.x * extent.y;
            found.visible += u32(area > 0u);
            found.waiting |= u32(area > view.small_area) << k;
            found.most = max(found.most, extent);
            // No image has more than 2^28 pixels: less than 2^32 for up to 15 points, and a bound that low is no harm.
            found.area += min(area, 0x0fffffffu);
        }
    }
    return found;
}
