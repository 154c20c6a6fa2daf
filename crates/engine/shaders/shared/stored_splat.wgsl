// A stored splat where the image in work has it. The stage has `view`.
#import splat

// A place in a pixel, moved by at most half a pixel, is rounded once, by 2^-25 of a pixel at most; one that leaves the
// pixel to the left by half as much more. A center so far out that its fraction is beyond [0, 1) carries nothing.
fn unpack_splat(splat: PackedSplat, depth: f32) -> Splat {
    let place = bitcast<vec2<f32>>(splat.xy);
    let shift = view.shift.zw;
    let moved = place + shift;
    let onward = (moved >= vec2<f32>(1.0)) & (place < vec2<f32>(1.0));
    let back = (moved < vec2<f32>(0.0)) & (place >= vec2<f32>(0.0));
    let before = select(moved, min(moved + 1.0, vec2<f32>(0.99999994)), back);
    // Exact but for the last sum.
    let fraction = select(before, max((place - 1.0) + shift, vec2<f32>(0.0)), onward);
    let carried = vec2<u32>(onward) - vec2<u32>(back);
    let column = (splat.z + carried.x) & 0xffffu;
    let row = (splat.z & 0xffff0000u) + (carried.y << 16u);
    return Splat(fraction.x, fraction.y, column | row, depth, bitcast<f32>(splat.w));
}
