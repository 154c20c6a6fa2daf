// shadows/share: number of lights that reach a point to m, their share of all. One invocation per point of a chunk.
#import dispatch

@group(0) @binding(0) var<storage, read_write> normals: array<vec4<f32>>;
#push

#main i {
    if i < push.count {
        let normal = normals[i];
        normals[i] = vec4<f32>(normal.xyz, normal.w / f32(push.lights));
    }
}
