// Collects fragments tile by tile: one subgroup per tile goes through the tile's flat discs in order of depth
// (shared/hand_over.wgsl). There are no atomics, and each pixel's fragments come in the order of blending. An
// invocation holds one number of each of its pixels; the stage defines begin(pixel), visit(number, hit, index), which
// both return it, and finish(number, pixel).
#import coverage
#import hand_over

#push

alias PixelState = u32;

struct Handed {
    splat: Splat,
    // As in shared/folding.
    whole: vec2<f32>,
    index: u32,
}

const STOPS = false;

fn is_done(number: u32) -> bool {
    return false;
}

fn begin_run(cut: bool) {
}

fn take(i: u32, corner: vec2<u32>) -> Handed {
    let splat = flat_at(i);
    return Handed(splat, -whole_to(splat, corner), i);
}

fn may_touch(own: Handed, block: u32, corner: vec2<u32>) -> bool {
    return touches(own.splat, corner + block_corner(block));
}

fn handed(own: Handed, k: u32, present: bool, first: vec2<f32>) -> Handed {
    return Handed(handed_splat(own.splat, k), handed_whole(own.whole, k, present, first), subgroupShuffle(own.index, k));
}

fn covers(h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> bool {
    return cover_from(h.splat, no_tilt(), h.whole + vec2<f32>(further), pixel, tile_lens).hit;
}

fn show(number: u32, h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> u32 {
    return visit(number, covers(h, further, pixel), h.index);
}

// Index in the window of a pixel of the band, NOTHING for others.
fn band_pixel(pixel: vec2<u32>) -> u32 {
    let p = window_index(pixel, view.window);
    let inside = all(pixel < view.window.zw) && p >= push.band_start && p < push.band_end;
    return select(0xffffffffu, p, inside);
}
