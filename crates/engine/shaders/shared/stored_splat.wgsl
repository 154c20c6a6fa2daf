// A stored splat where the image in work has it. The stage has `view`.
#import splat

fn unpack_splat(splat: PackedSplat, depth: f32) -> Splat {
    let x = moved_place(bitcast<f32>(splat.x), view.shift.z);
    let y = moved_place(bitcast<f32>(splat.y), view.shift.w);
    let column = (splat.z + bitcast<u32>(x.carried)) & 0xffffu;
    let row = (splat.z & 0xffff0000u) + (bitcast<u32>(y.carried) << 16u);
    return Splat(x.fraction, y.fraction, column | row, depth, bitcast<f32>(splat.w));
}

// A place in a pixel, and the pixels that it was carried on.
struct MovedPlace {
    fraction: f32,
    carried: i32,
}

// A place in a pixel moved by at most half a pixel. One that stays within the pixel, or leaves it to the right, is
// rounded once, by 2^-25 of a pixel at most; one that leaves it to the left by half as much more. A center so far out
// that its fraction is beyond [0, 1) carries nothing.
fn moved_place(fraction: f32, shift: f32) -> MovedPlace {
    let moved = fraction + shift;
    if moved >= 1.0 && fraction < 1.0 {
        // Exact but for the last sum.
        return MovedPlace(max((fraction - 1.0) + shift, 0.0), 1);
    }
    if moved < 0.0 && fraction >= 0.0 {
        return MovedPlace(min(moved + 1.0, 0.99999994), -1);
    }
    return MovedPlace(moved, 0);
}
