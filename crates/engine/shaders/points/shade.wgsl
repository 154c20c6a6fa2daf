// points/shade: the color of every point, for the images of a frame with samples. One invocation per point.
#import all_points
#import splat
#import dispatch

@group(0) @binding(17) var<storage, read_write> shades: array<vec4<f32>>;
#push

#main {
    view = camera;
    let i = invocation_index(workgroup, groups, local);
    if i < push.count {
        shades[i] = vec4<f32>(color_of(i), 1.0);
    }
}
