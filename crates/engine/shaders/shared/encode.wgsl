// From linear light to display values: the curve of sRGB, which goes on above 1.
#import elementary

fn encode(c: vec3<f32>) -> vec3<f32> {
    let root = vec3<f32>(power(c.x, 1.0 / 2.4), power(c.y, 1.0 / 2.4), power(c.z, 1.0 / 2.4));
    let curve = 1.055 * root - 0.055;
    return select(curve, c * 12.92, c <= vec3<f32>(0.0031308));
}
