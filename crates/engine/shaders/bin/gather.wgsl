// bin/gather: the data of each drawn splat for stages that go through tiles, in order; its record gets the
// depth in place of the key. One invocation per drawn splat.
#import compose
#import dispatch

struct Push {
    count: u32,
    // Key of the nearest depth.
    nearest: u32,
}

@group(0) @binding(13) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(14) var<storage, read_write> records: array<vec2<u32>>;
@group(0) @binding(15) var<storage, read_write> footprints: array<vec4<u32>>;
@group(0) @binding(16) var<storage, read_write> colors: array<vec4<f32>>;
@group(0) @binding(17) var<storage, read_write> slopes: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read_write> rectangles: array<vec2<u32>>;
var<immediate> push: Push;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let rank = invocation_index(workgroup, groups, local);
    if rank >= push.count {
        return;
    }
    let i = records[rank].y;
    let splat = splat_at(i);
    let x = bitcast<u32>(splat.fraction_x);
    footprints[rank] = vec4<u32>(x, bitcast<u32>(splat.fraction_y), splat.pixel, bitcast<u32>(splat.radius));
    records[rank] = vec2<u32>(depth_key(splat.depth) - push.nearest, i);
    colors[rank] = color_at(i);
    if SHAPE == SHAPE_ORIENTED {
        slopes[rank] = tilt_at(i).normal;
    }
    rectangles[rank] = bounds[i];
}
