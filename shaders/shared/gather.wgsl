// What stages that go through tiles need of a drawn splat, put to its place in their order. The stage's push constants hold
// `nearest`, the key of the nearest depth.
#import compose

@group(0) @binding(13) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(14) var<storage, read_write> records: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> footprints: array<vec4<u32>>;
@group(0) @binding(16) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> slopes: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read_write> rectangles: array<vec2<u32>>;

fn gather(rank: u32, i: u32, rectangle: vec2<u32>) {
    let splat = splat_at(i);
    let x = bitcast<u32>(splat.fraction_x);
    footprints[rank] = vec4<u32>(x, bitcast<u32>(splat.fraction_y), splat.pixel, bitcast<u32>(splat.radius));
    records[rank] = vec2<u32>(depth_key(splat.depth) - push.nearest, i);
    colors[rank] = color_at(i);
    if SHAPE == SHAPE_ORIENTED {
        slopes[rank] = tilt_at(i).normal;
    }
    rectangles[rank] = rectangle;
}
