// The ray through a pixel's center, and where a chord on it begins and ends. The stage has `view`. Depths are relative
// to depth_origin().
#import coverage
#import elementary
#import splat
#import twofloat

fn depth_origin() -> f32 {
    return view.eye_hi.w;
}

// Unit direction of the ray, and its length over the depth along the axis.
fn ray_of(pixel: vec2<u32>) -> vec4<f32> {
    if view.orthographic != 0u {
        return vec4<f32>(0.0, 0.0, 1.0, 1.0);
    }
    let from_middle = vec2<f32>(pixel) + sample_in(pixel) - middle_of_image();
    let v = vec3<f32>(from_middle / view.focal.x, 1.0);
    let stretch = length3(v);
    return vec4<f32>(v / stretch, stretch);
}

// The part that rounding took from the depth at which a chord begins or ends: what it cuts may be small against the
// cloud's depth. 0 where it was cut.
fn rest_of(middle: f32, half: f32, exit: bool, depth: f32) -> f32 {
    let end = two_sum(middle, select(-half, half, exit));
    return select(0.0, end.y, end.x == depth);
}
