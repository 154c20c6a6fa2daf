// Optical depth of an open sphere (edge, middle, reach, absorption) between two depths along the axis; 0 beside its chord.
#import sphere
#import absorb

fn segment_of(open: vec4<f32>, first: f32, last: f32) -> f32 {
    let half = half_chord(open.x, 0.0);
    let x0 = clamp((first - open.y) / open.z, -half, half);
    let x1 = clamp((last - open.y) / open.z, -half, half);
    return open.w * integral(open.x, x0, x1);
}
