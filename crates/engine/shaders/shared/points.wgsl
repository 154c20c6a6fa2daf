// Shared by the passes that find the nearest points: the choice of the points.
#import walk_points

// A single element each unless CULL or LIMITED.
@group(0) @binding(4) var<storage, read> normals: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> limits: array<u32>;

// 1: without points that face away from the viewer; those without a normal stay.
override CULL: u32 = 0u;
// 1: without points nearer than the pixel's limit, a depth key.
override LIMITED: u32 = 0u;

// True if a point is one of those asked for, wherever it shows; `place` is relative to the eye, in world axes.
fn is_kept(i: u32, place: vec3<f32>) -> bool {
    if CULL == 0u {
        return true;
    }
    let normal = normals[i].xyz;
    let facing = select(-dot3(normal, place), -dot3(normal, view.forward.xyz), view.orthographic != 0u);
    // An estimated one, of length 2, has no outside.
    return facing > 0.0 || all(normal == vec3<f32>(0.0)) || dot(normal, normal) > 2.0;
}

fn is_behind(hit: Hit) -> bool {
    if LIMITED == 0u {
        return true;
    }
    return hit.key >= limits[hit.pixel];
}

// With limits, points were counted with an earlier layer.
fn is_counted() -> bool {
    return LIMITED == 0u;
}
