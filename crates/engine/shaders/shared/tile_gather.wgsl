// Collects fragments tile by tile: one subgroup per tile goes through the tile's flat discs in order of depth. Nobody else
// touches its pixels, so that there are no atomics, and each pixel's fragments come in the order of blending. An
// invocation holds one number of each of its pixels; the stage defines begin(pixel), visit(number, hit, rank), which both return
// it, and end_pixel(number, pixel).
#import blocks
#import dispatch

struct Push {
    // Tiles of the window in x; the tiles in work; cells of a tile in the table of ends.
    columns: u32,
    first_tile: u32,
    tiles: u32,
    runs: u32,
    // Which part of each tile's splats: those from segment * TAKEN on.
    segment: u32,
    // The band of pixels in work, and its first fragment among the window's.
    band_start: u32,
    band_end: u32,
    first_fragment: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> ends: array<u32>;
@group(0) @binding(2) var<storage, read> entries: array<u32>;
@group(0) @binding(3) var<storage, read> footprints: array<vec4<u32>>;
var<immediate> push: Push;

// Splats of a tile that one run takes: some 5 iterations for each stay below what CPU drivers allow.
override TAKEN: u32 = 1u;

// Index in the window of a pixel of the band, NOTHING for others.
fn band_pixel(pixel: vec2<u32>) -> u32 {
    let p = window_index(pixel, view.window);
    let inside = all(pixel < view.window.zw) && p >= push.band_start && p < push.band_end;
    return select(0xffffffffu, p, inside);
}

#each held var<private> number{held}: u32;

fn over_block(block: u32, hits: u32, splat: Splat, rank: u32, corner: vec2<u32>, lane: u32) {
    var left = hits;
    loop {
        let k = firstTrailingBit(left) & (SUBGROUP - 1u);
        var s: Splat;
        s.fraction_x = subgroupShuffle(splat.fraction_x, k);
        s.fraction_y = subgroupShuffle(splat.fraction_y, k);
        s.pixel = subgroupShuffle(splat.pixel, k);
        s.radius = subgroupShuffle(splat.radius, k);
        let r = subgroupShuffle(rank, k);
        let flat = Tilt(vec4<f32>(0.0));
        let any = left != 0u;
#each held         if {held}u / HELD == block { number{held} = visit(number{held}, any && cover(s, flat, corner + place(lane, {held}u), view).hit, r); }
        left &= left - 1u;
        if left == 0u {
            break;
        }
    }
}

@compute @workgroup_size(SUBGROUP)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(subgroup_invocation_id) lane: u32,
) {
    let group = workgroup_index(workgroup, groups);
    if group >= push.tiles {
        return;
    }
    let tile = push.first_tile + group;
    let before = select(0u, ends[max(tile * push.runs, 1u) - 1u], tile > 0u);
    let start = before + push.segment * TAKEN;
    let end = min(start + TAKEN, ends[(tile + 1u) * push.runs - 1u]);
    if push.segment > 0u && start >= end {
        return;
    }
    let corner = view.window.xy + vec2<u32>(tile % push.columns, tile / push.columns) * TILE_SIDE;
#each held     number{held} = begin(corner + place(lane, {held}u));
    for (var next = start; next < end; next += SUBGROUP) {
        let present = next + lane < end;
        let rank = entries[min(next + lane, end - 1u)];
        let footprint = footprints[rank];
        let splat = Splat(bitcast<f32>(footprint.x), bitcast<f32>(footprint.y), footprint.z, 0.0, bitcast<f32>(footprint.w));
#each block         let hits{block} = subgroupBallot(present && touches(splat, corner + block_corner({block}u))).x;
#each block         over_block({block}u, hits{block}, splat, rank, corner, lane);
    }
#each held     end_pixel(number{held}, corner + place(lane, {held}u));
}
