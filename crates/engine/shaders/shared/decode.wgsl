// From display values to linear light: the curve of sRGB, which goes on above 1.
#import elementary

fn decode(c: vec3<f32>) -> vec3<f32> {
    let base = (c + 0.055) / 1.055;
    let curve = vec3<f32>(power(base.x, 2.4), power(base.y, 2.4), power(base.z, 2.4));
    return select(curve, c / 12.92, c <= vec3<f32>(0.04045));
}
