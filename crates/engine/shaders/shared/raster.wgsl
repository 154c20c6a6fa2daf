// Bindings of every stage that visits the pixels of splats. The stage defines
// visit(splat's index in the chunk, splat, tilt, pixel); a walker calls it for each pixel that may be covered.
#import camera
#import coverage
#import splat

// Statistics of a chunk's projection; shared/stats.wgsl explains the members.
struct ChunkStats {
    visible: u32,
    large: u32,
    tiles_low: u32,
    tiles_high: u32,
    widest: u32,
    tallest: u32,
    area_low: u32,
    area_high: u32,
}

@group(0) @binding(1) var<storage, read> splats: array<PackedSplat>;
@group(0) @binding(2) var<storage, read> tilts: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(4) var<storage, read> large: array<u32>;
@group(0) @binding(5) var<storage, read> pair_offsets: array<u32>;
@group(0) @binding(6) var<storage, read> splat_depths: array<f32>;
@group(0) @binding(7) var<storage, read> stats: array<ChunkStats>;
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

// True if a rectangle has pixels in the band; false for an empty one.
fn in_band(low: vec2<u32>, high: vec2<u32>) -> bool {
    if any(low >= high) {
        return false;
    }
    let first = window_index(low, view.window);
    let last = window_index(high - 1u, view.window);
    return first < push.band_end && last >= push.band_start;
}
