// shadows/occlusion: a pixel of a light's image that shows what lies behind through a hole in a surface takes the depth
// of the surface (Dobrev et al. 2010, Sections 3.3 and 6). Background stays.
#import light_filter

fn is_looked_at(own: vec4<f32>) -> vec4<bool> {
    return own != nothing();
}

// Below the depth itself, even where d~ is less than a unit of it in the last place: what is as near hides nothing.
fn floor_of(own: vec4<f32>) -> vec4<f32> {
    return min(own - push.apart, bitcast<vec4<f32>>(bitcast<vec4<u32>>(own) - vec4<u32>(1u)));
}
