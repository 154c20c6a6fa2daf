// Shows the splats of each tile, in the order in which they were binned, as fragments to every pixel that they may
// cover (shared/hand_over.wgsl). The stage imports `splat`, declares its push constants with a member `walk: TileWalk`,
// and then imports this. It defines the type PixelState, what an invocation holds of each of its pixels, and
//     begin(pixel) -> PixelState             before the first splat of a run
//     visit(state, fragment) -> PixelState   for each splat that may cover the pixel
//     finish(state, pixel)                   after the last splat of the run
// pixels outside the window included. A run takes TAKEN splats of each tile; a later one goes on from what
// earlier ones left, wherever the stage keeps that.
#import folding
#import hand_over

const STOPS = false;

fn is_done(held: PixelState) -> bool {
    return false;
}

fn begin_run(cut: bool) {
}

fn take(i: u32, corner: vec2<u32>) -> Handed {
    return whole_splat(i, corner);
}

fn may_touch(own: Handed, block: u32, corner: vec2<u32>) -> bool {
    return is_rectangle() || touches(own.splat, corner + block_corner(block));
}

fn show(held: PixelState, h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> PixelState {
    return visit(held, fragment_of(h, further, pixel));
}
