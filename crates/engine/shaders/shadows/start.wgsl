// shadows/start: every light reaches every point, until one turns out not to. One invocation per point of a chunk.
#import dispatch

// The fourth component is the share of light, and until that is known the number of lights that reach the point.
@group(0) @binding(0) var<storage, read_write> normals: array<vec4<f32>>;
#push

// 1: the points have normals; else what lies there is nothing yet.
override NORMALS: u32 = 0u;

#main i {
    if i >= push.count {
        return;
    }
    var normal = vec3<f32>(0.0);
    if NORMALS != 0u {
        normal = normals[i].xyz;
    }
    normals[i] = vec4<f32>(normal, f32(push.lights));
}
