// Bindings of every stage that visits the pixels of splats. The stage defines
// visit(splat's index in the chunk, splat, tilt, pixel); a walker calls it for each pixel that may be covered.
#import camera
#import coverage
#import splat
#import stored_splat

@group(0) @binding(1) var<storage, read> splats: array<PackedSplat>;
@group(0) @binding(2) var<storage, read> tilts: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(4) var<storage, read> tile_starts: array<u32>;
@group(0) @binding(5) var<storage, read> tile_entries: array<u32>;
@group(0) @binding(6) var<storage, read> splat_depths: array<f32>;
#push

fn splat_of(i: u32) -> Splat {
    return unpack_splat(splats[i], splat_depths[i]);
}

fn tilt_of(i: u32) -> Tilt {
    if !has_tilts() {
        return no_tilt();
    }
    if tilt_stride() == 1u {
        return Tilt(tilts[i], vec4<f32>(0.0));
    }
    return Tilt(tilts[tilt_stride() * i], tilts[tilt_stride() * i + 1u]);
}

// The pixels of a rectangle, first ones and those past the last, that a splat may cover where it was moved to: those
// that it would have been given there. Other shapes than flat ones keep the rectangle.
fn narrowed(splat: Splat, low: vec2<u32>, high: vec2<u32>) -> vec4<u32> {
    if is_rectangle() || is_sphere() || all(view.shift.zw == vec2<f32>(0.0)) {
        return vec4<u32>(low, high);
    }
    let pixel = center_pixel(splat);
    let fraction = vec2<f32>(splat.fraction_x, splat.fraction_y);
    let limit = vec2<f32>(65536.0);
    let first = pixel + vec2<i32>(clamp(ceil(fraction - splat.radius - 0.5), -limit, vec2<f32>(0.0)));
    let last = pixel + vec2<i32>(clamp(floor(fraction + splat.radius - 0.5), vec2<f32>(0.0), limit));
    let end = max(min(vec2<i32>(high), last + 1), vec2<i32>(0));
    return vec4<u32>(vec2<u32>(max(vec2<i32>(low), first)), vec2<u32>(end));
}

// True if a rectangle has pixels in the band; false for an empty one.
fn in_band(low: vec2<u32>, high: vec2<u32>) -> bool {
    if any(low >= high) {
        return false;
    }
    let first = window_index(low, view.window);
    let last = window_index(high - 1u, view.window);
    return first < push.band_end && last >= push.band_start;
}
