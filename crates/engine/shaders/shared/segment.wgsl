// Optical depth of an open sphere (edge, middle, reach, absorption) between two depths along the axis, of which the
// first is a sum of two floats; 0 beside its chord. `closing`: it ends at the last one, unless it was cut before.
#import sphere
#import absorb

fn segment_of(open: vec4<f32>, first: vec2<f32>, last: f32, closing: bool) -> f32 {
    let half = half_chord(open.x, 0.0);
    let x0 = clamp(((first.x - open.y) + first.y) / open.z, -half, half);
    let ended = closing && open.y + open.z * half == last;
    let x1 = select(clamp((last - open.y) / open.z, -half, half), half, ended);
    return open.w * integral(open.x, x0, x1);
}
